//! Matrices whose keys say what they are: `left_camera_matrix`, `camera_left.dist_coeffs`, `stereo.R`, `translation_mm`.
//!
//! Many programs store the results of `cv::stereoCalibrate` under names of their own. The words of a key and the number
//! of its values tell the role. Each role must occur once; the rig says which keys were taken.

use anyhow::{Result, bail, ensure};

use super::Files;
use super::node::Value;
use super::opencv;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta, Rows};

/// A value with the words of its keys.
struct Named<'a> {
    keys: String,
    words: Vec<String>,
    value: Value<'a>,
}

/// Words for the left and the right camera.
const SIDES: [[&str; 2]; 4] = [["left", "right"], ["l", "r"], ["0", "1"], ["1", "2"]];

/// Words of values that are derived from a calibration.
#[rustfmt::skip]
const DERIVED: [&str; 14] = [
    "new", "optimal", "rect", "rectified", "rectification", "projection", "essential", "fundamental", "e", "f", "p", "q",
    "std", "error",
];

/// The rig; `None` if no two keys name camera matrices. `--cameras 1,0` exchanges left and right.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Option<Result<Meta>> {
    let values: Vec<Value> = files.values().collect();
    let all: Vec<Named> = values.iter().flat_map(named).collect();
    let matrices = pairs(&all, is_camera_matrix);
    (!matrices.is_empty()).then(|| of_matrices(files, &all, &matrices, unknowns))
}

fn of_matrices(
    files: &Files,
    all: &[Named],
    matrices: &[[&Named; 2]],
    unknowns: Unknowns,
) -> Result<Meta> {
    let [k_l, k_r] = only(files, "left and right camera matrices (3 x 3)", matrices)?;
    let [d_l, d_r] = only(files, "left and right lens coefficients", &pairs(all, is_lens))?;
    let r = only(files, "R (3 x 3)", &alone(all, &["r", "rs", "rot", "rotation"], 9))?;
    let t = only(files, "T (3 x 1)", &alone(all, &["t", "ts", "trans", "translation"], 3))?;
    let model = opencv::lens(files)?;
    let lens = model.unwrap_or(LensModel::RadialTangential);
    let (own, exchanged) = (size(files, all)?, unknowns.are_exchanged(files)?);
    let view = |side: usize, k: &Named, d: &Named| -> Result<View> {
        let size = unknowns.size(side ^ usize::from(exchanged), own, &files.to_string())?;
        View::of(camera_matrix(&k.value)?, lens, Some(&d.value), size)
    };
    let mut views = [view(0, k_l, d_l)?, view(1, k_r, d_r)?];
    let mut rigid =
        Rigid { r: rig::rotation(&r.value)?, t: t.value.array::<3>("T (3 x 1)")?.into() };
    if exchanged {
        views.reverse();
        rigid = rigid.inverse();
    }
    // The key may say the unit.
    let said = [("mm", 0.001), ("cm", 0.01)].into_iter().find(|(unit, _)| t.has(&[unit]));
    let unit_m = said.map_or(unknowns.unit_m, |(_, metres)| metres);
    let pose = Pose::of(&rigid, t.value.place())?.in_unit(unit_m)?;
    let mut meta = rig::meta(views, &pose, files.to_string())?;
    let taken = [k_l, k_r, d_l, d_r, r, t].map(|named| named.keys.as_str()).join(", ");
    meta.other.insert(Meta::TAKEN.to_owned(), taken.into());
    if model.is_none() && d_l.count() == 4 && d_r.count() == 4 {
        meta.other.insert(Meta::UNNAMED_LENS.to_owned(), true.into());
    }
    Ok(meta)
}

/// The one candidate for a role.
fn only<T: Clone + Keys>(files: &Files, what: &str, found: &[T]) -> Result<T> {
    match found {
        [one] => Ok(one.clone()),
        [] => bail!("{files}: {what}: no key tells which these are"),
        several => {
            let keys = several.iter().map(Keys::keys).collect::<Vec<_>>().join("; or ");
            bail!("{files}: {what}: which of {keys}? Give a file with one of them")
        }
    }
}

trait Keys {
    fn keys(&self) -> String;
}

impl Keys for &Named<'_> {
    fn keys(&self) -> String {
        self.keys.clone()
    }
}

impl Keys for [&Named<'_>; 2] {
    fn keys(&self) -> String {
        self.map(|named| named.keys.as_str()).join(" and ")
    }
}

impl Named<'_> {
    fn has(&self, words: &[&str]) -> bool {
        self.words.iter().any(|word| words.contains(&word.as_str()))
    }

    fn count(&self) -> usize {
        self.value.numbers().map_or(0, |numbers| numbers.len())
    }

    /// The words without that of a side.
    fn beside(&self, side: &str) -> Option<Vec<&str>> {
        let rest: Vec<&str> =
            self.words.iter().map(String::as_str).filter(|word| *word != side).collect();
        (rest.len() < self.words.len()).then_some(rest)
    }
}

fn is_camera_matrix(named: &Named) -> bool {
    let is_matrix = named.has(&["k", "m", "mtx", "cm", "intrinsic", "intrinsics"])
        || named.has(&["camera", "cam"]) && named.has(&["matrix", "mat"]);
    is_matrix && !named.has(&DERIVED) && camera_matrix(&named.value).is_ok()
}

fn is_lens(named: &Named) -> bool {
    named.has(&["d", "dist", "distortion"])
        && !named.has(&DERIVED)
        && matches!(named.count(), 4 | 5 | 8 | 12 | 14)
}

/// A camera matrix, or `fx fy cx cy` as keys.
fn camera_matrix(value: &Value) -> Result<Rows> {
    if value.get(&["fx"]).is_some() {
        return Ok(rig::camera_matrix(value.numbers_at(["fx", "fy", "cx", "cy"])?));
    }
    ensure!(value.numbers()?.len() == 9, value.refuse("expected 3 x 3 numbers"));
    rig::intrinsics(value)
}

/// Pairs of values of one role, whose words differ in the side alone.
fn pairs<'a, 'b>(all: &'b [Named<'a>], is: fn(&Named) -> bool) -> Vec<[&'b Named<'a>; 2]> {
    let found: Vec<&Named> = all.iter().filter(|named| is(named)).collect();
    let mut pairs: Vec<[&Named; 2]> = Vec::new();
    for [left, right] in SIDES {
        for one in &found {
            let Some(rest) = one.beside(left) else { continue };
            let other = found.iter().find(|other| {
                other.words.len() == one.words.len() && other.beside(right).as_ref() == Some(&rest)
            });
            // A key of three cameras, or of both kinds of words, is in one pair alone.
            let Some(other) = other else { continue };
            if !pairs
                .iter()
                .flatten()
                .any(|taken| taken.keys == one.keys || taken.keys == other.keys)
            {
                pairs.push([one, other]);
            }
        }
    }
    pairs
}

/// Values of one role that belong to no side.
fn alone<'a, 'b>(all: &'b [Named<'a>], words: &[&str], count: usize) -> Vec<&'b Named<'a>> {
    let sided = |named: &Named| {
        named.words.iter().any(|word| SIDES[0].contains(&word.as_str()) || is_number(word))
    };
    let is = |named: &&Named| {
        named.has(words)
            && !named.has(&DERIVED)
            && !sided(named)
            && named.count() == count
            && !is_camera_matrix(named)
    };
    all.iter().filter(is).collect()
}

fn is_number(word: &str) -> bool {
    word.bytes().all(|byte| byte.is_ascii_digit())
}

/// The size of the images, if all sizes of the files are equal.
fn size(files: &Files, all: &[Named]) -> Result<Option<[u16; 2]>> {
    let outermost = files.values().map(|file| file.size_if(&["width"], &["height"]));
    let outermost = outermost.collect::<Result<Vec<_>>>()?;
    let mut sizes: Vec<[u16; 2]> = outermost.into_iter().flatten().collect();
    for Named { words, value, .. } in all {
        let last = words.last().map_or("", String::as_str);
        if let Some(both) = value.size_if(&["width"], &["height"])? {
            sizes.push(both);
        } else if matches!(last, "size" | "resolution") && value.items().len() == 2 {
            sizes.extend(value.size().ok());
        }
    }
    sizes.dedup();
    Ok(<[_; 1]>::try_from(sizes).ok().map(|[one]| one))
}

/// The values of a file with the words of their keys. Outer keys that all of them have say nothing.
fn named<'a>(file: &Value<'a>) -> Vec<Named<'a>> {
    let nested = file.nested().into_iter();
    nested
        .map(|(keys, value)| {
            let keys = keys.join(".");
            Named { words: words(&keys), keys, value }
        })
        .collect()
}

/// The words of a key in lower case: `CameraMatrixL`, `camera_matrix_l` and `camera.matrix.l` have the same.
fn words(key: &str) -> Vec<String> {
    let mut words = Vec::new();
    let mut word = String::new();
    let mut last = ' ';
    for c in key.chars() {
        let begins =
            c.is_uppercase() && last.is_lowercase() || c.is_ascii_digit() != last.is_ascii_digit();
        if (begins || !c.is_alphanumeric()) && !word.is_empty() {
            words.push(std::mem::take(&mut word));
        }
        if c.is_alphanumeric() {
            word.extend(c.to_lowercase());
        }
        last = c;
    }
    words.extend(Some(word).filter(|word| !word.is_empty()));
    words
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn keys_of_any_spelling_have_the_same_words() {
        for key in ["CameraMatrixL", "camera_matrix_l", "camera.matrix.L", "Camera_MatrixL"] {
            assert_eq!(words(key), ["camera", "matrix", "l"], "{key}");
        }
        assert_eq!(words("distCoeffs2"), ["dist", "coeffs", "2"]);
        assert_eq!(words("CM1"), ["cm", "1"]);
    }
}
