//! Trees of texts that tools print: `RealSense`, MYNT EYE, Kalibr.

use anyhow::{Context, Result, bail};

use super::node::Node;
use super::rigid::Rigid;

/// The tree of a text that a known tool prints; `None` for other texts.
pub(super) fn parse(text: &str) -> Option<Result<Node>> {
    let has = |words: &str| text.contains(words);
    if has("Intrinsic of \"") {
        Some(realsense(text))
    } else if has("Principal Point") && has("Focal Length") {
        Some(Ok(sensor_control(text)))
    } else if has("Intrinsics left: {") {
        Some(Ok(mynt(text)))
    } else if has("CameraGeometry'>") {
        Some(kalibr(text))
    } else {
        None
    }
}

/// The numbers in a text, which brackets, commas and other words may separate.
fn numbers(text: &str) -> impl Iterator<Item = f64> {
    let words = text.split(|c: char| c.is_whitespace() || "[],".contains(c));
    words.filter_map(|word| word.parse().ok())
}

/// `get_img_params` of MYNT EYE: `Intrinsics left: {key: value, ..}` after the prefix of its log. The lens model may
/// stand there as a word without value. It is left out, because the keys of a lens tell its model.
fn mynt(text: &str) -> Node {
    let braced = |name: &str| {
        let inside = text.split_once(&format!("{name}: {{"))?.1.split_once('}')?.0;
        let mut keys: Vec<(String, Node)> = Vec::new();
        let mut rest = inside;
        while let Some((key, after)) = rest.split_once(':') {
            let key = key.rsplit(',').next().unwrap_or_default().trim();
            let after = after.trim_start();
            let end = match after.strip_prefix('[') {
                Some(list) => list.find(']').map_or(after.len(), |end| end + 2),
                None => after.find(',').unwrap_or(after.len()),
            };
            let value = after[..end].replace(['[', ']', ','], " ");
            keys.push((key.to_owned(), Node::of_text(&value)));
            rest = &after[end..];
        }
        Some((name.to_owned(), Node::Map(keys)))
    };
    let all = ["Intrinsics left", "Intrinsics right", "Extrinsics right to left"];
    Node::Map(all.into_iter().filter_map(braced).collect())
}

/// Kalibr's `results-cam.txt`, as the tree of its `camchain.yaml`.
///
/// `baseline T_1_0` takes points of cam0 to cam1. Its quaternion is `x y z w` in the JPL convention: the matrix of
/// `camchain.yaml` is the transpose of the usual one.
fn kalibr(text: &str) -> Result<Node> {
    let mut cameras: Vec<(String, Vec<(String, Node)>)> = Vec::new();
    let (mut quaternion, mut baseline) = (Vec::new(), None);
    for line in text.lines().map(str::trim) {
        let (key, value) = line.split_once(':').unwrap_or((line, ""));
        let value_alone = value.split("+-").next().unwrap_or_default();
        let list = || Node::List(numbers(value_alone).map(Node::Number).collect());
        let name = key.split_whitespace().next().unwrap_or_default();
        if name.strip_prefix("cam").is_some_and(|n| n.parse::<u8>().is_ok()) {
            cameras.push((name.to_owned(), Vec::new()));
            continue;
        }
        if let Some(way) = key.strip_prefix("baseline T_") {
            baseline = way.split('_').next().map(|n| format!("cam{n}"));
            continue;
        }
        let place = match &baseline {
            Some(name) => cameras.iter_mut().find(|(camera, _)| camera == name),
            None => cameras.last_mut(),
        };
        let Some((camera, keys)) = place else { continue };
        match key {
            "type" => keys.extend(geometry(value)),
            "distortion" => keys.push(("distortion_coeffs".into(), list())),
            "projection" => keys.push(("intrinsics".into(), list())),
            "q" => quaternion = numbers(value_alone).collect(),
            "t" if baseline.is_some() => {
                let t: Vec<f64> = numbers(value_alone).collect();
                let way = way(&quaternion, &t)
                    .with_context(|| format!("baseline of {camera}: {quaternion:?}"))?;
                keys.push(("T_cn_cnm1".into(), way));
            }
            _ => {}
        }
    }
    Ok(Node::Map(cameras.into_iter().map(|(name, keys)| (name, Node::Map(keys))).collect()))
}

/// The camera model and the lens model of a class of Kalibr, such as `DistortedPinholeCameraGeometry`.
fn geometry(class: &str) -> Vec<(String, Node)> {
    let class = class.rsplit('.').next().unwrap_or_default();
    let name = class.split("CameraGeometry").next().unwrap_or_default();
    let (camera, lens) = match name {
        "DistortedPinhole" => ("pinhole", "radtan"),
        "EquidistantDistortedPinhole" => ("pinhole", "equidistant"),
        "Pinhole" => ("pinhole", "none"),
        _ => (name, "none"),
    };
    let text = |key: &str, text: &str| (key.to_owned(), Node::Text(text.to_owned()));
    vec![text("camera_model", camera), text("distortion_model", lens)]
}

/// `[R t; 0 1]` row by row, from a quaternion `x y z w` in the JPL convention and a translation.
fn way(quaternion: &[f64], t: &[f64]) -> Result<Node> {
    let (&[x, y, z, w], &[a, b, c]) = (quaternion, t) else {
        bail!("expected q of four numbers and t of three")
    };
    let Rigid { r, t } = Rigid::of_quaternion([w, -x, -y, -z], [a, b, c])?;
    let rows =
        (0..3).map(|i| [r[(i, 0)], r[(i, 1)], r[(i, 2)], t[i]]).chain([[0.0, 0.0, 0.0, 1.0]]);
    Ok(Node::List(rows.flatten().map(Node::Number).collect()))
}

/// `rs-enumerate-devices -c`: blocks of intrinsics, each with its stream and size, and of extrinsics.
fn realsense(text: &str) -> Result<Node> {
    let (mut intrinsics, mut extrinsics) = (Vec::new(), Vec::new());
    let mut lines = text.lines().map(str::trim).peekable();
    let quoted = |line: &str| -> Vec<String> {
        line.split('"').skip(1).step_by(2).map(str::to_owned).collect()
    };
    while let Some(line) = lines.next() {
        let mut block: Vec<(String, Node)> = Vec::new();
        if line.starts_with("Intrinsic of \"") {
            block.push(("stream".into(), Node::Text(quoted(line).concat())));
            while let Some((key, value)) = lines
                .next_if(|line| line.contains(':') && !line.contains('"'))
                .and_then(|line| line.split_once(':'))
            {
                block.push((key.trim().to_lowercase(), Node::of_text(value)));
            }
            intrinsics.push(Node::Map(block));
        } else if line.starts_with("Extrinsic from \"") {
            let names = quoted(line);
            let [from, to] = names.as_slice() else {
                bail!("`{line}`: expected two streams in quotation marks")
            };
            block.push(("from".into(), Node::Text(from.clone())));
            block.push(("to".into(), Node::Text(to.clone())));
            let mut all = Vec::new();
            while let Some(line) = lines.next_if(|line| !line.contains('"')) {
                all.extend(numbers(line.rsplit(':').next().unwrap_or_default()).map(Node::Number));
            }
            all.truncate(12);
            block.push(("numbers".into(), Node::List(all)));
            extrinsics.push(Node::Map(block));
        }
    }
    Ok(Node::Map(vec![
        ("rs intrinsics".into(), Node::List(intrinsics)),
        ("rs extrinsics".into(), Node::List(extrinsics)),
    ]))
}

/// `rs-sensor-control`: the intrinsics of the left and of the right stream, and one transform, `name : numbers` a line.
fn sensor_control(text: &str) -> Node {
    let (mut cameras, mut rotation, mut translation) = (Vec::new(), Vec::new(), Vec::new());
    let mut name = String::new();
    for line in text.lines() {
        let Some((key, value)) = line.split_once(':') else { continue };
        if !key.trim().is_empty() {
            name = key.trim().to_lowercase();
        }
        let numbers = || numbers(value).map(Node::Number);
        let list = || Node::List(numbers().collect());
        match name.as_str() {
            "principal point" => cameras.push(vec![("principal point".to_owned(), list())]),
            "rotation matrix" => rotation.extend(numbers()),
            "translation vector" => translation.extend(numbers()),
            "distortion model" => cameras.iter_mut().rev().take(1).for_each(|camera| {
                camera.push(("model".into(), Node::Text(value.trim().to_owned())));
            }),
            "focal length" | "distortion coefficients" => {
                cameras.iter_mut().rev().take(1).for_each(|camera| {
                    let key = if name == "focal length" { name.clone() } else { "coeffs".into() };
                    camera.push((key, list()));
                });
            }
            _ => {}
        }
    }
    let key = |name: &str| name.to_owned();
    Node::Map(vec![
        (key("rs sensors"), Node::List(cameras.into_iter().map(Node::Map).collect())),
        (key("rotation matrix"), Node::List(rotation)),
        (key("translation vector"), Node::List(translation)),
    ])
}
