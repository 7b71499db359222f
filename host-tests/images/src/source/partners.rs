//! Which left image belongs to which right one: by time stamp, by the number in the name, or in order.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

/// Digits from which a number in a name is a time stamp in nanoseconds.
const NANOSECONDS: usize = 16;

/// Images without a partner that are kept waiting.
const WAITING: usize = 64;

/// Pairs of files, and what has no partner.
pub(super) fn of_files(
    [left, right]: [Vec<PathBuf>; 2],
    tolerance_s: f64,
) -> (Vec<[PathBuf; 2]>, Vec<String>) {
    let numbers = [&left, &right].map(|side| side.iter().map(|path| number(path)).collect());
    let [Some(l), Some(r)]: [Option<Vec<u128>>; 2] = numbers else { return in_order(left, right) };
    let rising = |numbers: &[u128]| numbers.windows(2).all(|two| two[0] < two[1]);
    // One of each belongs together whatever its name: im0.png and im1.png.
    if !rising(&l) || !rising(&r) || (l.len() == 1 && r.len() == 1) {
        return in_order(left, right);
    }
    let stamped = [&left, &right]
        .map(|side| side.iter().all(|path| digits(path).is_some_and(|d| d.len() >= NANOSECONDS)));
    // Numbers of frames are exact; time stamps may differ.
    let unit = if stamped == [true; 2] { 1e-9 } else { 1e9 };
    let origin = l[0].min(r[0]);
    let seconds = |numbers: Vec<u128>| numbers.into_iter().map(move |n| (n - origin) as f64 * unit);
    let mut partners = Partners::new(tolerance_s);
    let mut events: Vec<(f64, usize, PathBuf)> = Vec::new();
    events.extend(seconds(l).zip(left).map(|(stamp, path)| (stamp, 0, path)));
    events.extend(seconds(r).zip(right).map(|(stamp, path)| (stamp, 1, path)));
    events.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut pairs, mut skipped) = (Vec::new(), Vec::new());
    let mut take = |found: Vec<Partner<PathBuf>>| {
        for one in found {
            match one {
                Partner::Pair(pair) => pairs.push(pair),
                Partner::Alone(side, path) => skipped.push(alone(side, &path)),
            }
        }
    };
    for (stamp, side, path) in events {
        take(partners.push(side, stamp, path));
    }
    take(partners.finish());
    (pairs, skipped)
}

fn in_order(left: Vec<PathBuf>, right: Vec<PathBuf>) -> (Vec<[PathBuf; 2]>, Vec<String>) {
    let both = left.len().min(right.len());
    let rest = |side: usize, all: &[PathBuf]| -> Vec<String> {
        all[both..].iter().map(|path| alone(side, path)).collect()
    };
    let skipped = [rest(0, &left), rest(1, &right)].concat();
    (left.into_iter().zip(right).map(Into::into).collect(), skipped)
}

fn alone(side: usize, path: &Path) -> String {
    let [this, other] = if side == 0 { ["left", "right"] } else { ["right", "left"] };
    format!("{}: {this} image without a {other} one", path.display())
}

/// The last run of digits in a name.
fn digits(path: &Path) -> Option<&str> {
    let stem = path.file_stem()?.to_str()?;
    stem.split(|c: char| !c.is_ascii_digit()).rfind(|run| !run.is_empty())
}

fn number(path: &Path) -> Option<u128> {
    digits(path)?.parse().ok()
}

/// What became of an image.
#[derive(Debug, PartialEq)]
pub(super) enum Partner<T> {
    /// Left and right.
    Pair([T; 2]),
    /// No partner: side and image.
    Alone(usize, T),
}

/// Finds partners in two streams, each in the order of its time stamps.
#[derive(Debug)]
pub(super) struct Partners<T> {
    tolerance_s: f64,
    waiting: [VecDeque<(f64, T)>; 2],
}

impl<T> Partners<T> {
    pub(super) fn new(tolerance_s: f64) -> Self {
        Self { tolerance_s, waiting: [VecDeque::new(), VecDeque::new()] }
    }

    /// One more image; out comes whatever is decided by it.
    pub(super) fn push(&mut self, side: usize, stamp: f64, image: T) -> Vec<Partner<T>> {
        self.waiting[side].push_back((stamp, image));
        let mut decided = Vec::new();
        while let [Some((l, _)), Some((r, _))] = self.waiting.each_ref().map(VecDeque::front) {
            let late = r - l;
            let alone = if late > self.tolerance_s {
                0
            } else if late < -self.tolerance_s {
                1
            } else {
                let [l, r] = self.waiting.each_mut().map(VecDeque::pop_front);
                decided.extend(l.zip(r).map(|((_, l), (_, r))| Partner::Pair([l, r])));
                continue;
            };
            self.drop_first(alone, &mut decided);
        }
        for side in 0..2 {
            if self.waiting[side].len() > WAITING {
                self.drop_first(side, &mut decided);
            }
        }
        decided
    }

    /// What still waits at the end.
    pub(super) fn finish(&mut self) -> Vec<Partner<T>> {
        let mut decided = Vec::new();
        for side in 0..2 {
            while !self.waiting[side].is_empty() {
                self.drop_first(side, &mut decided);
            }
        }
        decided
    }

    fn drop_first(&mut self, side: usize, decided: &mut Vec<Partner<T>>) {
        decided
            .extend(self.waiting[side].pop_front().map(|(_, image)| Partner::Alone(side, image)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    fn names(left: &[&str], right: &[&str]) -> (Vec<[String; 2]>, usize) {
        let (pairs, skipped) = of_files([paths(left), paths(right)], 0.005);
        let text = |path: &PathBuf| path.display().to_string();
        (pairs.iter().map(|pair| pair.each_ref().map(text)).collect(), skipped.len())
    }

    #[test]
    fn numbers_in_names_pair_images_and_a_gap_shifts_nothing() {
        let (pairs, alone) =
            names(&["left01.png", "left02.png", "left04.png"], &["right01.png", "right04.png"]);
        assert_eq!(pairs, [["left01.png", "right01.png"], ["left04.png", "right04.png"]]);
        assert_eq!(alone, 1);
    }

    #[test]
    fn time_stamps_pair_within_the_tolerance_only() {
        let left = ["1403636579763555584.png", "1403636579813555456.png"];
        let right = ["1403636579764555584.png", "1403636579893555456.png"];
        let (pairs, alone) = names(&left, &right);
        assert_eq!(pairs, [[left[0], right[0]]]);
        assert_eq!(alone, 2);
    }

    #[test]
    fn names_without_numbers_pair_in_order_and_the_longer_folder_says_so() {
        let (pairs, alone) = names(&["a.png", "b.png", "c.png"], &["x.png", "y.png"]);
        assert_eq!(pairs, [["a.png", "x.png"], ["b.png", "y.png"]]);
        assert_eq!(alone, 1);
    }

    #[test]
    fn a_stream_without_partners_is_dropped_and_not_hoarded() {
        let mut partners = Partners::new(0.01);
        let alone: usize = (0..1000).map(|i| partners.push(0, f64::from(i), i).len()).sum();
        assert_eq!(alone, 1000 - WAITING);
        assert_eq!(partners.push(1, 999.0, -1).last(), Some(&Partner::Pair([999, -1])));
    }
}
