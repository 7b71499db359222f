//! Trees of texts in any syntax: YAML, JSON, XML of OpenCV, `name=value`, lists as numpy prints them, tables of COLMAP,
//! bare numbers, and texts that tools print.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use roxmltree::{Document, Node as Element};

use super::bare;
use super::node::Node;
use super::printed;

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
            let (line, column) = (why.line(), why.column());
            anyhow::anyhow!(
                "not JSON: line {line} cannot be read at column {column}; give the file as its tool wrote it"
            )
        })?));
    }
    if let Some(tree) = printed::parse(start) {
        return tree;
    }
    let first =
        start.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with(['#', '%']));
    if first.is_some_and(is_section)
        || start.contains('=') && start.lines().any(|line| is_section(line.trim()))
    {
        return Ok(ini(start));
    }
    let file = name.rsplit(['/', '\\']).next().unwrap_or_default();
    if matches!(file, "cameras.txt" | "rigs.txt") {
        return Ok(table(file, start));
    }
    if let Some(numbers) = numbers_alone(start) {
        return Ok(numbers);
    }
    let is_named = |line: &str| line.contains('=') && (!line.contains(':') || line.contains("fc_"));
    if first.is_some_and(is_named) || start.lines().any(is_printed_row) {
        return Ok(assignments(start));
    }
    yaml(start)
}

/// A text of numbers alone, or the five lines of Stereo-DSO, whose first may name the lens and whose third is a word.
fn numbers_alone(text: &str) -> Option<Node> {
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let rows: Vec<Node> = lines.map(Node::of_text).collect();
    let is_numbers = |row: &Node| match row {
        Node::Number(_) => true,
        Node::List(all) => all.iter().all(|one| matches!(one, Node::Number(_))),
        _ => false,
    };
    let count = |row: &Node| match row {
        Node::List(all) => all.len(),
        _ => usize::from(is_numbers(row)),
    };
    let five = matches!(rows.as_slice(), [_, a, _, b, c] if [a, b, c].map(count) == [2, 2, 1]);
    let named = five && text.lines().next().is_some_and(|line| !line.contains([':', '=']));
    let whole = !rows.is_empty() && rows.iter().all(is_numbers);
    (whole || named).then(|| Node::Map(vec![(bare::KEY.into(), Node::List(rows))]))
}

/// Whether a line is the row of a matrix as numpy prints it: numbers in brackets, without commas.
fn is_printed_row(line: &str) -> bool {
    let line = line.trim();
    let numbers = line.trim_matches(['[', ']']).split_whitespace();
    line.starts_with('[')
        && numbers.clone().count() > 1
        && numbers.into_iter().all(|word| word.parse::<f64>().is_ok())
}

/// A list at the root has the key `""`.
fn rooted(node: Node) -> Node {
    if matches!(node, Node::Map(_)) { node } else { Node::Map(vec![(String::new(), node)]) }
}

/// The first document of YAML, without OpenCV's header.
fn yaml(text: &str) -> Result<Node> {
    let (mut document, mut has_content) = (String::new(), false);
    for line in text.lines() {
        let mark = line.trim_end() == "---" || line.trim_end() == "...";
        if line.starts_with('%') || line.starts_with("WARNING") {
            continue;
        }
        if mark && has_content {
            break;
        }
        if !mark {
            has_content |= !line.trim().is_empty() && !line.starts_with('#');
            // YAML does not take a tab for a space. OpenCV also reads `data:[` and `T:!!opencv-matrix`.
            let line = line.replace('\t', "  ").replacen(":[", ": [", 1).replacen(":!!", ": !!", 1);
            document.push_str(&line);
        }
        document.push('\n');
    }
    // A number that is not finite is refused at its use, with its key.
    let options = serde_saphyr::options! {
        non_finite_float_policy: serde_saphyr::options::NonFiniteFloatPolicy::PassThrough
    };
    let node: Node = serde_saphyr::from_str_with_options(&document, options).map_err(|why| {
        let place = why.location().map(|at| format!(": line {} cannot be read", at.line()));
        anyhow::anyhow!(
            "not YAML, JSON, XML or name = numbers{}; give the file as its tool wrote it, or write the numbers as K1 D1 K2 \
             D2 R T",
            place.unwrap_or_default()
        )
    })?;
    ensure!(
        matches!(node, Node::Map(_) | Node::List(_)),
        "no keys with values: YAML, JSON, XML or name=value are read"
    );
    Ok(rooted(node))
}

fn xml(text: &str) -> Result<Node> {
    let document = Document::parse(text).map_err(|why| {
        let line = why.pos().row;
        anyhow::anyhow!("not XML: line {line} cannot be read; give the file as its tool wrote it")
    })?;
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

/// `[SECTION]`, and `key=value` or `key value`, which continues until the next key. Keys in lower case, sections in
/// upper. `//` starts a comment.
fn ini(text: &str) -> Node {
    let mut sections: Vec<(String, Vec<(String, String)>)> = Vec::new();
    for line in text.lines().map(|line| line.split("//").next().unwrap_or_default().trim()) {
        if line.is_empty() || line.starts_with([';', '#']) {
            continue;
        }
        if is_section(line) {
            sections.push((line[1..line.len() - 1].to_uppercase(), Vec::new()));
            continue;
        }
        let Some((_, keys)) = sections.last_mut() else { continue };
        let parts = line.split_once('=').or_else(|| line.split_once(char::is_whitespace));
        match parts.filter(|_| line.starts_with(|c: char| c.is_ascii_alphabetic())) {
            Some((key, value)) => {
                keys.push((key.trim().to_lowercase(), value.trim().trim_matches('"').to_owned()));
            }
            None => {
                if let Some((_, value)) = keys.last_mut() {
                    value.push(' ');
                    value.push_str(line);
                }
            }
        }
    }
    let section = |(name, keys): (String, Vec<(String, String)>)| {
        let keys = keys.into_iter().map(|(key, value)| (key, Node::of_text(&value)));
        (name, Node::Map(keys.collect()))
    };
    Node::Map(sections.into_iter().map(section).collect())
}

/// `name=value` or `name: value` a line, of Middlebury, Python and MATLAB: a value continues to the next name. `%`
/// starts a comment, `±` a deviation; both are ignored, and so are lines that start with `#`.
fn assignments(text: &str) -> Node {
    let mut all: Vec<(String, String)> = Vec::new();
    let is_name = |name: &str| {
        !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_.".contains(c))
    };
    for line in text.lines().filter(|line| !line.trim_start().starts_with('#')) {
        let line = line.split(['%', '±']).next().unwrap_or_default();
        let parts = match line.split_once('=') {
            // Words may stand before the name.
            Some((words, value)) => Some((words.split_whitespace().last().unwrap_or(""), value)),
            None => line.split_once(':').map(|(name, value)| (name.trim(), value)),
        };
        match (parts.filter(|(name, _)| is_name(name)), all.last_mut()) {
            (Some((name, value)), _) => all.push((name.to_owned(), value.to_owned())),
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

/// The text of a file in UTF-8, or in UTF-16 with its mark; refuses other bytes.
pub(super) fn text_of(bytes: Vec<u8>) -> Result<String> {
    let wide = match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => Some((rest, u16::from_le_bytes as fn([u8; 2]) -> u16)),
        [0xfe, 0xff, rest @ ..] => Some((rest, u16::from_be_bytes as fn([u8; 2]) -> u16)),
        _ => None,
    };
    let text = match wide {
        Some((rest, unit)) => {
            let units = rest.chunks_exact(2).filter_map(|two| two.try_into().ok()).map(unit);
            char::decode_utf16(units).collect::<Result<String, _>>().ok()
        }
        None => String::from_utf8(bytes).ok(),
    };
    text.filter(|text| !text.contains('\0')).context(
        "it is not text: expected a rig file of YAML, JSON, XML or plain text; write the arrays of a .npz or .mat as \
         K1 D1 K2 D2 R T in a text",
    )
}
