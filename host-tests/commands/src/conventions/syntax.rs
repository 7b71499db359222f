//! Trees of texts that are neither YAML nor JSON: XML of OpenCV, `name=value`, tables of COLMAP, output of the
//! `RealSense` tools.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use roxmltree::{Document, Node as Element};

use super::node::Node;

/// Largest depth of nested elements.
const DEEPEST: usize = 16;

/// The tree of a text in any of the syntaxes.
pub(super) fn parse(name: &str, text: &str) -> Result<Node> {
    let start = text.trim_start_matches('\u{feff}').trim_start();
    if start.starts_with('<') {
        return xml(start);
    }
    if start.starts_with('{')
        || start.starts_with("[\n")
        || start.starts_with("[{")
        || Path::new(name).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json"))
    {
        return Ok(rooted(serde_json::from_str(start).map_err(|why| {
            anyhow::anyhow!("not JSON: {why}; give the file as its tool wrote it")
        })?));
    }
    if start.contains("Intrinsic of \"") {
        return realsense(start);
    }
    if start.contains("Principal Point") && start.contains("Focal Length") {
        return Ok(sensor_control(start));
    }
    if start.lines().any(|line| is_section(line.trim())) && start.contains('=') {
        return Ok(ini(start));
    }
    let first =
        start.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
    let file = name.rsplit(['/', '\\']).next().unwrap_or_default();
    if matches!(file, "cameras.txt" | "rigs.txt") {
        return Ok(table(file, start));
    }
    if first.is_some_and(|line| line.contains('=') && !line.contains(':')) {
        return Ok(assignments(start));
    }
    yaml(start)
}

/// A list at the root has the key `""`.
fn rooted(node: Node) -> Node {
    if matches!(node, Node::Map(_)) { node } else { Node::Map(vec![(String::new(), node)]) }
}

/// The first document of YAML, without OpenCV's header.
fn yaml(text: &str) -> Result<Node> {
    let mut document = String::new();
    for line in text.lines() {
        let mark = line.trim_end() == "---" || line.trim_end() == "...";
        if line.starts_with('%') || line.starts_with("WARNING") {
            continue;
        }
        if mark && document.lines().any(|line| !line.trim().is_empty() && !line.starts_with('#')) {
            break;
        }
        if !mark {
            // YAML does not take a tab for a space, and OpenCV also writes `data:[`.
            document.push_str(&line.replace('\t', "  ").replacen(":[", ": [", 1));
        }
        document.push('\n');
    }
    // A number that is not finite is refused at its use, with its key.
    let options = serde_saphyr::options! {
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::PassThrough
    };
    let node: Node = serde_saphyr::from_str_with_options(&document, options).map_err(|why| {
        anyhow::anyhow!(
            "not YAML: {}; give the file as its tool wrote it",
            first_line(&why.to_string())
        )
    })?;
    ensure!(
        matches!(node, Node::Map(_) | Node::List(_)),
        "no keys with values: YAML, JSON, XML or name=value are read"
    );
    Ok(rooted(node))
}

/// An error without the picture of its line, and without the names of options of the library.
fn first_line(why: &str) -> &str {
    let line = why.lines().find(|line| !line.trim().is_empty()).unwrap_or(why).trim();
    line.split(", set DuplicateKeyPolicy").next().unwrap_or(line)
}

fn xml(text: &str) -> Result<Node> {
    let document = Document::parse(text)
        .map_err(|why| anyhow::anyhow!("not XML: {why}; give the file as its tool wrote it"))?;
    element(document.root_element(), 0)
}

fn element(of: Element<'_, '_>, depth: usize) -> Result<Node> {
    ensure!(depth < DEEPEST, "elements within elements, more than {DEEPEST} of them");
    let children: Vec<Element<'_, '_>> = of.children().filter(Element::is_element).collect();
    if children.is_empty() {
        return Ok(Node::of_text(&of.text().unwrap_or_default().replace('"', "")));
    }
    let named = |child: &Element<'_, '_>| {
        Ok((child.tag_name().name().to_owned(), element(*child, depth + 1)?))
    };
    Ok(Node::Map(children.iter().map(named).collect::<Result<_>>()?))
}

fn is_section(line: &str) -> bool {
    let inside = line.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    inside.is_some_and(|name| {
        name.starts_with(|c: char| c.is_ascii_alphabetic()) && !name.contains([',', '"'])
    })
}

/// `[SECTION]` and `key=value`. Keys in lower case, sections in upper.
fn ini(text: &str) -> Node {
    let mut sections: Vec<(String, Node)> = Vec::new();
    for line in text.lines().map(str::trim).filter(|line| !line.starts_with([';', '#'])) {
        if is_section(line) {
            sections.push((line[1..line.len() - 1].to_uppercase(), Node::Map(Vec::new())));
        } else if let (Some((key, value)), Some((_, Node::Map(keys)))) =
            (line.split_once('='), sections.last_mut())
        {
            keys.push((key.trim().to_lowercase(), Node::of_text(value)));
        }
    }
    Node::Map(sections)
}

/// `name=value` a line, of Middlebury and of Python: a value continues to the next name.
fn assignments(text: &str) -> Node {
    let mut all: Vec<(String, String)> = Vec::new();
    for line in text.lines().filter(|line| !line.trim_start().starts_with('#')) {
        let name = line.split_once('=').filter(|(name, _)| {
            let name = name.trim();
            !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_.".contains(c))
        });
        match (name, all.last_mut()) {
            (Some((name, value)), _) => all.push((name.trim().to_owned(), value.to_owned())),
            (None, Some((_, value))) => {
                value.push(' ');
                value.push_str(line);
            }
            (None, None) => {}
        }
    }
    let plain = |value: &str| {
        let inner = value.trim().trim_start_matches("np.").trim_start_matches("array");
        Node::of_text(&inner.replace(['[', ']', '(', ')', ',', ';'], " "))
    };
    Node::Map(all.iter().map(|(name, value)| (name.clone(), plain(value))).collect())
}

/// The rows of a text of COLMAP, under a key of its name.
fn table(file: &str, text: &str) -> Node {
    let rows =
        text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let word = |word: &str| word.parse().map_or_else(|_| Node::Text(word.to_owned()), Node::Number);
    let row = |line: &str| Node::List(line.split_whitespace().map(word).collect());
    Node::Map(vec![(file.to_owned(), Node::List(rows.map(row).collect()))])
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
            let mut numbers = Vec::new();
            while let Some(line) = lines.next_if(|line| !line.contains('"')) {
                let rest = line.rsplit(':').next().unwrap_or_default();
                numbers.extend(
                    rest.split_whitespace().filter_map(|word| word.parse().ok()).map(Node::Number),
                );
            }
            numbers.truncate(12);
            block.push(("numbers".into(), Node::List(numbers)));
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
        let numbers = || {
            value
                .split(|c: char| c.is_whitespace() || "[],".contains(c))
                .filter_map(|word| word.parse().ok())
        };
        let list = || Node::List(numbers().map(Node::Number).collect());
        match name.as_str() {
            "principal point" => cameras.push(vec![("principal point".to_owned(), list())]),
            "rotation matrix" => rotation.extend(numbers().map(Node::Number)),
            "translation vector" => translation.extend(numbers().map(Node::Number)),
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

/// Reads the text of a file; refuses bytes that are not text.
pub(super) fn text_of(bytes: Vec<u8>) -> Result<String> {
    String::from_utf8(bytes)
        .ok()
        .context("it is not text: expected a rig file of YAML, JSON, XML or plain text")
}
