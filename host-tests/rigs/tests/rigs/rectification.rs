//! Rectification of rigs that are not side by side, and of a part of a fisheye, in the files of OpenCV and ROS.

use nalgebra::{Matrix3, Matrix3x4, Matrix4, Vector3, Vector4};
use rigs::data::{LensModel, Meta, matrix, rows};
use rigs::formats::{Format, Unknowns};
use stereo_selfcal::geometry::metrics::Deviation;

use crate::{journey, read};

fn plain() -> Meta {
    let text = "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [500, 500, 319.5, 239.5]\n  \
                resolution: [640, 480]\n";
    let transform =
        "  T_cn_cnm1:\n  - [1, 0, 0, -0.2]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n";
    let text = format!("{text}{}{transform}", text.replace("cam0", "cam1"));
    read([("camchain.yaml", text.as_str())], Unknowns::default()).unwrap()
}

/// The right camera rolled by degrees, at a place in the left frame, and slightly turned.
fn rig(degrees: f64, centre: [f64; 3]) -> Meta {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let roll = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let (sin, cos) = 0.02_f64.sin_cos();
    let pitch = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
    let r = roll * pitch;
    let t = -(r * Vector3::from(centre));
    Meta { r: rows(&r), t: t.normalize().into(), baseline_m: Some(t.norm()), ..plain() }
}

/// A matrix of a file of OpenCV.
fn mat(text: &str, name: &str) -> Vec<f64> {
    let data = text.split_once(&format!("\n{name}: ")).unwrap().1.split_once("data: [").unwrap().1;
    let data = data.split_once(']').unwrap().0;
    data.split(',').map(|x| x.trim().parse().unwrap()).collect()
}

struct Written {
    r: [Matrix3<f64>; 2],
    p: [Matrix3x4<f64>; 2],
    q: Matrix4<f64>,
}

fn opencv(meta: &Meta, field: Option<f64>) -> Written {
    let documents = Format::Opencv.write_part(meta, field).unwrap();
    let text = &documents[1].text;
    let of = |name: &str| mat(text, name);
    Written {
        r: ["R1", "R2"].map(|name| Matrix3::from_row_slice(&of(name))),
        p: ["P1", "P2"].map(|name| Matrix3x4::from_row_slice(&of(name))),
        q: Matrix4::from_row_slice(&of("Q")),
    }
}

/// Pixels of a point of the left frame in both rectified images.
fn pixels(written: &Written, p: Vector3<f64>) -> [[f64; 2]; 2] {
    // Both projections take points of the left rectified frame.
    let rectified = (written.r[0] * p).push(1.0);
    written.p.map(|p| {
        let at = p * rectified;
        [at.x / at.z, at.y / at.z]
    })
}

#[test]
fn rows_of_a_rolled_rig_and_columns_of_a_vertical_one_agree_and_q_leads_back() {
    let cases = [
        (0.0, [0.2, 0.0, 0.0], 0),
        (180.0, [0.2, 0.01, 0.0], 0),
        (90.0, [0.2, -0.01, 0.01], 0),
        (0.0, [0.0, 0.2, 0.0], 1),
        (0.0, [0.01, -0.2, 0.0], 1),
        (-90.0, [0.0, 0.2, 0.01], 1),
    ];
    for (degrees, centre, axis) in cases {
        let meta = rig(degrees, centre);
        let written = opencv(&meta, None);
        // The frame is as upright as the left camera.
        assert!(
            written.r[0][(0, 0)] > 0.9 && written.r[0][(1, 1)] > 0.9,
            "{degrees} {}",
            written.r[0]
        );
        let p = Vector3::new(0.3, -0.2, 4.0);
        let [l, r] = pixels(&written, p);
        assert!((l[1 - axis] - r[1 - axis]).abs() < 1e-9, "{degrees} {centre:?}: {l:?} {r:?}");
        let disparity = l[axis] - r[axis];
        let depth = (written.r[0] * p).z;
        let sign = centre[axis].signum();
        assert!((disparity - sign * written.p[0][(0, 0)] * 0.2 / depth).abs() < 0.5, "{disparity}");
        let back = written.q * Vector4::new(l[0], l[1], disparity, 1.0);
        assert!((back.xyz() / back.w - written.r[0] * p).norm() < 1e-9, "{back}");
        // The right camera's own rotation leads to the same place.
        let right =
            written.r[1] * (matrix(&meta.r) * p + Vector3::from(meta.t) * meta.baseline_m.unwrap());
        let (focal, place) = (written.p[0][(0, 0)], [0, 1].map(|i| written.p[0][(i, 2)]));
        let at = [0, 1].map(|i| place[i] + focal * right[i] / right.z);
        assert!(
            (at[0] - r[0]).abs() < 1e-9 && (at[1] - r[1]).abs() < 1e-9,
            "{degrees}: {at:?} {r:?}"
        );
    }
}

#[test]
fn ros_gives_vertical_and_rolled_rigs_back() {
    for (degrees, centre) in
        [(0.0, [0.0, 0.2, 0.0]), (0.0, [0.01, -0.2, 0.0]), (180.0, [0.2, 0.01, 0.0])]
    {
        let meta = rig(degrees, centre);
        let (documents, back) = journey(Format::Ros, &meta);
        let off =
            Deviation::between(&back.extrinsics::<f64>().unwrap(), &meta.extrinsics().unwrap());
        assert!(
            off.rotation < 1e-14 && off.translation < 1e-14,
            "{degrees}: {off:?}\n{}",
            documents[1].text
        );
        assert!((back.baseline_m.unwrap() - meta.baseline_m.unwrap()).abs() < 1e-14);
    }
}

#[test]
fn a_fisheye_of_170_degrees_is_rectified_in_part() {
    // 640 px over 170 degrees.
    let focal = 319.5 / (85.0_f64).to_radians();
    let k = [[focal, 0.0, 319.5], [0.0, focal, 239.5], [0.0, 0.0, 1.0]];
    let lens = LensModel::Fisheye;
    let meta = Meta {
        k_l: k,
        k_r: k,
        lens,
        dist_l: vec![0.0; 4],
        dist_r: vec![0.0; 4],
        ..rig(0.0, [0.2, 0.0, 0.0])
    };
    let field = |written: &Written| 2.0 * (319.5 / written.p[0][(0, 0)]).atan().to_degrees();
    let widest = field(&opencv(&meta, None));
    assert!((90.0..150.0).contains(&widest), "{widest}");
    assert!((field(&opencv(&meta, Some(80.0))) - 80.0).abs() < 1e-9);
    let why = Format::Ros.write_part(&meta, Some(175.0)).unwrap_err().to_string();
    assert!(why.contains("--field 175"), "{why}");
}
