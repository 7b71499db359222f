//! The list of mechanisms, and a copy of the tree in which each has a switch.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::cache::digest;

/// The list of mechanisms; its first lines describe the format.
const MECHANISMS: &str = include_str!("mechanisms.txt");

/// The switch, in the copy of the core. Each thread has its own number.
const SWITCH: &str = "//! Switch of the mechanisms.
extern crate std;
std::thread_local! { static OFF: core::cell::Cell<usize> = const { core::cell::Cell::new(usize::MAX) } }
/// Switches a mechanism off in this thread.
pub fn switch(number: usize) { OFF.with(|off| off.set(number)) }
pub(crate) fn is_off(number: usize) -> bool { OFF.with(|off| off.get() == number) }
";

/// A mechanism of the estimator.
#[derive(Debug)]
pub(super) struct Mechanism {
    pub(super) number: usize,
    pub(super) name: String,
    /// Thresholds that only it uses.
    pub(super) thresholds: Vec<String>,
    /// Code that only it uses: files, or `file:function`.
    code: Vec<String>,
    /// File, expression, expression without the mechanism.
    edits: Vec<[String; 3]>,
}

/// All mechanisms of the list.
pub(super) fn mechanisms() -> Result<Vec<Mechanism>> {
    let mut all: Vec<Mechanism> = Vec::new();
    for line in MECHANISMS.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
        if let Some(head) = line.strip_prefix("== ") {
            let mut parts = head.split('|').map(str::trim);
            let name = parts.next().unwrap_or_default().to_owned();
            let mut words =
                || parts.next().unwrap_or_default().split_whitespace().map(str::to_owned).collect();
            let (thresholds, code) = (words(), words());
            all.push(Mechanism { number: all.len(), name, thresholds, code, edits: Vec::new() });
            continue;
        }
        let edit = line.split_once(": ").and_then(|(file, rest)| {
            let (from, to) = rest.split_once(" => ")?;
            Some([file, from, to].map(|part| part.trim().to_owned()))
        });
        let mechanism = all.last_mut().context("an edit before the first mechanism")?;
        mechanism.edits.push(edit.with_context(|| format!("no edit: {line}"))?);
    }
    Ok(all)
}

/// Files of the core with a switch for every edit: names below core/src, and texts.
///
/// # Errors
/// Names the mechanism whose text does not occur exactly once.
fn edited(root: &Path, mechanisms: &[Mechanism]) -> Result<Vec<(String, String)>> {
    let mut edited: Vec<(String, String)> = Vec::new();
    for mechanism in mechanisms {
        for [file, from, to] in &mechanism.edits {
            let known = edited.iter().position(|(name, _)| name == file);
            let place = known.unwrap_or(edited.len());
            if known.is_none() {
                let text = fs::read_to_string(root.join("core/src").join(file))
                    .with_context(|| format!("{}: {file}", mechanism.name))?;
                edited.push((file.clone(), text));
            }
            let text = &mut edited[place].1;
            let at = find(text, from)
                .with_context(|| format!("{}: not found in {file}: {from}", mechanism.name))?;
            let off = format!("crate::ablation::is_off({})", mechanism.number);
            let with = format!("(if {off} {{ {to} }} else {{ {} }})", &text[at.clone()]);
            text.replace_range(at, &with);
        }
    }
    Ok(edited)
}

/// Copies the tree with a switch for every edit. Returns the digest of its code.
pub(super) fn copy(root: &Path, tree: &Path, mechanisms: &[Mechanism]) -> Result<String> {
    let mut edited = edited(root, mechanisms)?;
    let lib = fs::read_to_string(root.join("core/src/lib.rs"))?;
    edited.push(("lib.rs".into(), format!("{lib}\npub mod ablation;\n")));
    edited.push(("ablation.rs".into(), SWITCH.into()));
    let own = "host-tests/evidence/src/cli/campaign/ablation/mod.rs";
    let text = fs::read_to_string(root.join(own))?;
    let body = "fn switch(_number: usize) {}";
    ensure!(text.contains(body), "not found: {body}");
    let with = "fn switch(number: usize) { stereo_selfcal::ablation::switch(number) }";
    let mut files: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    let listed = Command::new("git")
        .args(["ls-files", "--cached", "--others", "--exclude-standard"])
        .current_dir(root)
        .output()
        .context("cannot start git")?;
    ensure!(listed.status.success(), "git ls-files fails in {}", root.display());
    for file in String::from_utf8(listed.stdout)?.lines().filter(|file| root.join(file).is_file()) {
        files.insert(file.to_owned(), fs::read(root.join(file))?);
    }
    for (file, text) in edited {
        files.insert(format!("core/src/{file}"), text.into_bytes());
    }
    files.insert(own.to_owned(), text.replace(body, with).into_bytes());
    let mut all = Vec::new();
    for (file, content) in files {
        let to = tree.join(&file);
        write_if_other(&to, &content).with_context(|| format!("cannot write {}", to.display()))?;
        let is_code = ["rs", "toml", "lock", "txt"]
            .iter()
            .any(|end| to.extension().is_some_and(|e| e == *end));
        if is_code {
            all.extend(file.into_bytes());
            all.extend(content);
        }
    }
    Ok(digest(&all))
}

/// Writes a file only if its content differs, so that cargo does not build it again.
fn write_if_other(to: &Path, content: &[u8]) -> io::Result<()> {
    if fs::read(to).is_ok_and(|old| old == content) {
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::write(to, content)
}

/// Place of an expression, where white space of any length counts as equal; `None` unless it occurs exactly once.
fn find(text: &str, expression: &str) -> Option<Range<usize>> {
    let words: Vec<&str> = expression.split_whitespace().collect();
    let first = words.first()?;
    let starts = text.match_indices(first).map(|(start, _)| start);
    let mut places = starts.filter_map(|start| {
        let mut end = start + first.len();
        for word in words.iter().skip(1) {
            let rest = text.get(end..)?;
            let blank = rest.len() - rest.trim_start().len();
            if blank == 0 || !rest.trim_start().starts_with(word) {
                return None;
            }
            end += blank + word.len();
        }
        Some(start..end)
    });
    let place = places.next()?;
    places.next().is_none().then_some(place)
}

impl Mechanism {
    /// Lines of its code without comments and tests.
    pub(super) fn lines(&self, core: &Path) -> Result<usize> {
        let mut lines = 0;
        for part in &self.code {
            let (file, function) = part.split_once(':').unwrap_or((part, ""));
            let text = fs::read_to_string(core.join(file)).with_context(|| self.name.clone())?;
            let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
            let code = |line: &&str| !line.trim().is_empty() && !line.trim().starts_with("//");
            if function.is_empty() {
                lines += text.lines().filter(code).count();
                continue;
            }
            let [plain, generic] = [format!("fn {function}("), format!("fn {function}<")];
            let mut after =
                text.lines().skip_while(|line| !line.contains(&plain) && !line.contains(&generic));
            let head = after.next().with_context(|| format!("{}: no {part}", self.name))?;
            let indent = head.len() - head.trim_start().len();
            let is_end = |line: &&str| line.trim_start() == "}" && line.len() == indent + 1;
            lines += 2 + after.take_while(|line| !is_end(line)).filter(code).count();
        }
        Ok(lines)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_text_of_the_list_stands_once_in_the_core() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let all = mechanisms().unwrap();
        assert!(all.len() > 60);
        edited(&root, &all).unwrap();
        let thresholds = ["thresholds.rs", "thresholds/pair.rs", "thresholds/paper.rs"]
            .map(|file| fs::read_to_string(root.join("core/src").join(file)).unwrap())
            .concat();
        for mechanism in &all {
            mechanism.lines(&root.join("core/src")).unwrap();
            for name in &mechanism.thresholds {
                assert!(
                    thresholds.contains(&format!("const {name}:")),
                    "{}: {name}",
                    mechanism.name
                );
            }
        }
    }
}
