//! Doubts about a rig that was read: numbers that are possible, and more often a mistake.

use crate::data::{LensModel, Meta, Rows};

/// Distance of the principal point from the middle beyond which a size is doubtful, image widths or heights.
const FAR_CENTRE: f64 = 0.25;

/// Field of view beyond which the focal length of a lens without a fisheye model is doubtful, degrees.
const WIDE_DEG: f64 = 150.0;

/// The doubts, each a sentence with what to change.
pub fn doubts(meta: &Meta) -> Vec<String> {
    let text = |key: &str| meta.other.get(key).and_then(|value| value.as_str());
    let rounded = meta.other.get(Meta::ROUNDED).and_then(serde_json::Value::as_f64);
    let mut doubts = Vec::new();
    doubts.extend(rounded.map(|off| {
        format!("R has few digits: R^T R differed from the identity by {off:.1e}, and R was made orthonormal")
    }));
    doubts.extend(text(Meta::TAKEN).map(|keys| {
        format!("the file is of no known format: the words of its keys told K, D, R and T: {keys}. Compare them")
    }));
    doubts.extend(text(Meta::UNREAD).map(|formats| {
        format!(
            "{}: the file has keys of {formats}, too, which were not read. If the other numbers fit the images, give \
             a file with these alone",
            meta.source
        )
    }));
    if meta.other.get(Meta::UNNAMED_LENS) == Some(&true.into()) {
        doubts.push(
            "the lenses have four coefficients and no name: read as k1 k2 p1 p2. For k1 to k4 of a fisheye (cv::fisheye) \
             add distortion_model: equidistant to the file"
                .to_owned(),
        );
    }
    let views = [("left", &meta.k_l), ("right", &meta.k_r)].into_iter().zip(meta.sizes());
    doubts.extend(views.clone().find_map(|((side, k), size)| centre(side, k, size)));
    let lenses = views.zip(meta.lenses()).filter(|(_, lens)| *lens != LensModel::Fisheye);
    doubts.extend(lenses.into_iter().find_map(|(((side, k), size), _)| field(side, k, size)));
    doubts.extend(other_axes(meta));
    doubts
}

/// A doubt about the size of the images.
fn centre(side: &str, k: &Rows, [width, height]: [u16; 2]) -> Option<String> {
    let [x, y] = [k[0][2], k[1][2]];
    let off = |[width, height]: [u16; 2]| {
        (x / f64::from(width) - 0.5).abs().max((y / f64::from(height) - 0.5).abs())
    };
    let (given, exchanged) = (off([width, height]), off([height, width]));
    let why = if given > 0.15 && exchanged < 0.7 * given {
        format!("of {height} x {width} px it would be near it. Are width and height exchanged?")
    } else if given > FAR_CENTRE {
        "are these images of another size, or cut?".to_owned()
    } else {
        return None;
    };
    Some(format!(
        "the principal point ({x:.1}, {y:.1}) of the {side} camera is far from the middle of {width} x {height} px: {why}"
    ))
}

/// A doubt about the focal length.
fn field(side: &str, k: &Rows, [width, _]: [u16; 2]) -> Option<String> {
    let focal = k[0][0];
    let across = 2.0 * (f64::from(width) / (2.0 * focal)).atan().to_degrees();
    (across > WIDE_DEG).then(|| {
        format!(
            "a focal length of {focal:.1} px for {width} px of the {side} camera is a field of view of {across:.0} degrees: is \
             it in mm, or of a fisheye?"
        )
    })
}

/// A doubt about the axes, if the rig has cameras above or behind each other or turned by more than 90 degrees.
fn other_axes(meta: &Meta) -> Option<String> {
    let [x, y, z] = meta.t.map(f64::abs);
    let cosine = (0..3).map(|i| meta.r[i][i]).sum::<f64>() / 2.0 - 0.5;
    let odd = if cosine < 0.0 && meta.r[2][2] < 0.0 {
        "the cameras look in opposite directions"
    } else if z > x && z > y {
        "the cameras stand behind each other"
    } else if y > x {
        "the cameras stand above each other"
    } else {
        return None;
    };
    Some(format!(
        "{odd}. If they do not, the axes are others than x right, y down, z forward: OpenGL, Blender and NeRF have y up and z back, \
         Unity y up and a left-handed frame, Unreal x forward, y right and z up, a robot's body x forward, y left and z up. Write R and \
         t for the axes of OpenCV"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The doubts about a rig of these cameras and this size.
    fn about(k: [f64; 4], size: [u16; 2]) -> Vec<String> {
        let [fx, fy, cx, cy] = k;
        let k = [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]];
        doubts(&Meta::side_by_side([k; 2], [size; 2], "a file".to_owned()))
    }

    #[test]
    fn usual_cameras_raise_no_doubt() {
        for (k, size) in [
            ([458.0, 457.0, 367.0, 248.0], [752, 480]),
            ([721.5, 721.5, 609.6, 172.9], [1241, 376]),
            ([2262.5, 2265.3, 1096.9, 513.1], [2048, 1024]),
            ([285.0, 285.0, 419.0, 399.0], [848, 800]),
        ] {
            assert_eq!(about(k, size), [""; 0], "{k:?} {size:?}");
        }
    }

    #[test]
    fn a_size_that_the_principal_point_contradicts_is_doubted() {
        let other = about([1776.0, 1807.0, 871.0, 557.0], [720, 576]);
        assert!(other.len() == 1 && other[0].contains("another size"), "{other:?}");
        let exchanged = about([265.8, 266.0, 325.8, 174.2], [480, 640]);
        assert!(exchanged.len() == 1 && exchanged[0].contains("exchanged"), "{exchanged:?}");
    }

    #[test]
    fn a_focal_length_in_millimetres_is_doubted() {
        let found = about([5.3, 5.3, 197.0, 129.0], [400, 260]);
        assert!(found.len() == 1 && found[0].contains("177 degrees"), "{found:?}");
    }
}
