//! Finds out which number in the names of images is the frame number or the time.

use std::path::{Path, PathBuf};

/// Range of times that names may have, s since 1970: the years 2001 to 2033.
const EPOCH_S: [f64; 2] = [1e9, 2e9];

/// Units of such times, per second: nanoseconds, microseconds, milliseconds.
const UNITS: [f64; 3] = [1e9, 1e6, 1e3];

/// Number of digits from which a number outside [`EPOCH_S`] counts as a time in nanoseconds.
const NANOSECONDS: usize = 16;

/// Spacing of frame numbers that are taken as times, s: so large that only equal numbers become partners.
const FRAME_S: f64 = 1e9;

/// The numbers in a name, as strings of digits.
fn runs(path: &Path) -> Option<Vec<String>> {
    let stem = path.file_stem()?.to_str()?;
    let all = stem.split(|c: char| !c.is_ascii_digit()).filter(|run| !run.is_empty());
    Some(all.map(str::to_owned).collect())
}

/// A time for each file of both sides, s. For numbered frames it is a multiple of [`FRAME_S`] that only the partner
/// shares. `None` if the names have no numbers, have different patterns, or repeat a number.
pub(super) fn keys(sides: [&[PathBuf]; 2]) -> Option<[Vec<f64>; 2]> {
    let all: [Vec<Vec<String>>; 2] = [numbers(sides[0])?, numbers(sides[1])?];
    let count = all.iter().flatten().next()?.len();
    if count == 0 || all.iter().flatten().any(|numbers| numbers.len() != count) {
        return None;
    }
    // A number that is equal in all names of each side is the number of the camera or of the run.
    let varies =
        |i: usize| all.iter().any(|side| side.iter().any(|numbers| numbers[i] != side[0][i]));
    let varying: Vec<usize> = (0..count).filter(|i| varies(*i)).collect();
    let found = match seconds_and_fraction(sides, &all, &varying) {
        Some(times) => times,
        None => counted(&all, &varying)?,
    };
    let rising = |times: &Vec<f64>| {
        let mut sorted = times.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.windows(2).all(|two| two[0] < two[1])
    };
    found.iter().all(rising).then_some(found)
}

fn numbers(side: &[PathBuf]) -> Option<Vec<Vec<String>>> {
    side.iter().map(|path| runs(path)).collect()
}

/// Times, s, from names that have them as two numbers; `None` for other names. Either a point separates seconds and
/// their fraction, or the seconds since 1970 are followed by nanoseconds (7 to 9 digits) or microseconds (up to 6
/// digits).
fn seconds_and_fraction(
    sides: [&[PathBuf]; 2],
    all: &[Vec<Vec<String>>; 2],
    varying: &[usize],
) -> Option<[Vec<f64>; 2]> {
    let &last = varying.last()?;
    let first = last.checked_sub(1)?;
    let dotted = |path: &PathBuf, numbers: &Vec<String>| {
        let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        stem.contains(&format!("{}.{}", numbers[first], numbers[last]))
    };
    let is_dotted = (0..2).all(|side| {
        sides[side].iter().zip(&all[side]).all(|(path, numbers)| dotted(path, numbers))
    });
    let is_epoch = all.iter().flatten().all(|numbers| {
        numbers[first].parse().is_ok_and(|s: f64| (EPOCH_S[0]..EPOCH_S[1]).contains(&s))
    });
    let longest = all.iter().flatten().map(|numbers| numbers[last].len()).max()?;
    // `cam0.0001` is frame 1 of camera 0. In times since a start, in contrast, the seconds vary, and the fraction has
    // three or more digits.
    let fine = all.iter().flatten().all(|numbers| numbers[last].len() >= 3);
    let is_time = if is_epoch {
        is_dotted || longest <= 9
    } else {
        is_dotted && fine && varying.contains(&first)
    };
    if varying.iter().any(|i| *i < first) || !is_time {
        return None;
    }
    let origin: f64 =
        all.iter().flatten().filter_map(|numbers| numbers[first].parse().ok()).reduce(f64::min)?;
    let digits = if longest > 6 { 9 } else { 6 };
    let time = |numbers: &Vec<String>| -> Option<f64> {
        let fraction = &numbers[last];
        let fraction: f64 = if is_dotted {
            format!("0.{fraction}").parse().ok()?
        } else {
            fraction.parse::<f64>().ok()? / 10_f64.powi(digits)
        };
        Some(numbers[first].parse::<f64>().ok()? - origin + fraction)
    };
    let times = |side: usize| all[side].iter().map(time).collect::<Option<Vec<f64>>>();
    Some([times(0)?, times(1)?])
}

/// Times from names with one number that varies, if it is a time. Otherwise the varying numbers together are the number
/// of a frame.
fn counted(all: &[Vec<Vec<String>>; 2], varying: &[usize]) -> Option<[Vec<f64>; 2]> {
    if let [one] = varying
        && let Some(times) = times(all, *one)
    {
        return Some(times);
    }
    if varying.is_empty() {
        return None;
    }
    let key = |numbers: &Vec<String>| -> Option<Vec<u128>> {
        varying.iter().map(|i| numbers[*i].parse().ok()).collect()
    };
    let keys = |side: usize| all[side].iter().map(key).collect::<Option<Vec<_>>>();
    let keys = [keys(0)?, keys(1)?];
    let mut sorted: Vec<&Vec<u128>> = keys.iter().flatten().collect();
    sorted.sort();
    sorted.dedup();
    let rank =
        |key: &Vec<u128>| sorted.binary_search(&key).map_or(0.0, |rank| rank as f64) * FRAME_S;
    Some([keys[0].iter().map(rank).collect(), keys[1].iter().map(rank).collect()])
}

/// Times, s, if the numbers at this position are times in one of [`UNITS`].
fn times(all: &[Vec<Vec<String>>; 2], i: usize) -> Option<[Vec<f64>; 2]> {
    let parse = |side: usize| {
        all[side].iter().map(|numbers| numbers[i].parse().ok()).collect::<Option<Vec<u128>>>()
    };
    let [left, right] = [parse(0)?, parse(1)?];
    let both = || left.iter().chain(&right);
    let within =
        |unit: &f64| both().all(|n| (EPOCH_S[0] * unit..EPOCH_S[1] * unit).contains(&(*n as f64)));
    let long = all.iter().flatten().all(|numbers| numbers[i].len() >= NANOSECONDS);
    let unit = UNITS.into_iter().find(within).or(long.then_some(1e9))?;
    let origin = *both().min()?;
    let seconds = |n: &u128| (n - origin) as f64 / unit;
    Some([left.iter().map(seconds).collect(), right.iter().map(seconds).collect()])
}
