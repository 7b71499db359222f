//! Pairs left and right images: by time stamp, by the number in the name, or in order.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use super::names;

/// Largest number of images of a side that wait for a partner.
const WAITING: usize = 64;

/// Largest length of all images that wait for a partner, bytes.
const WAITING_BYTES: usize = 256 << 20;

/// Pairs of files, and files without a partner.
#[derive(Debug, Default)]
pub(super) struct PairedFiles {
    pub(super) pairs: Vec<[PathBuf; 2]>,
    pub(super) skipped: Vec<String>,
    /// Least difference of the times of a left and a right image, s; `None` if the names tell no times.
    pub(super) nearest_s: Option<f64>,
}

/// Finds the partners of left and right files.
pub(super) fn of_files([left, right]: [Vec<PathBuf>; 2], tolerance_s: f64) -> PairedFiles {
    // A single file on each side makes a pair whatever the names, such as im0.png and im1.png.
    if left.len() == 1 && right.len() == 1 {
        return in_order(left, right);
    }
    let Some([l, r]) = names::keys([&left, &right]) else { return in_order(left, right) };
    let mut partners = Partners::new(tolerance_s);
    let mut events: Vec<(f64, usize, PathBuf)> = Vec::new();
    events.extend(l.into_iter().zip(left).map(|(stamp, path)| (stamp, 0, path)));
    events.extend(r.into_iter().zip(right).map(|(stamp, path)| (stamp, 1, path)));
    events.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let gaps = events.windows(2).filter(|two| two[0].1 != two[1].1).map(|two| two[1].0 - two[0].0);
    let mut found = PairedFiles { nearest_s: gaps.reduce(f64::min), ..PairedFiles::default() };
    let mut take = |all: Vec<Partner<PathBuf>>| {
        for one in all {
            match one {
                Partner::Pair(pair) => found.pairs.push(pair),
                Partner::Alone(side, path) => found.skipped.push(alone(side, &path)),
            }
        }
    };
    for (stamp, side, path) in events {
        take(partners.push(side, stamp, 0, path));
    }
    take(partners.finish());
    found
}

fn in_order(left: Vec<PathBuf>, right: Vec<PathBuf>) -> PairedFiles {
    let both = left.len().min(right.len());
    let rest = |side: usize, all: &[PathBuf]| -> Vec<String> {
        all[both..].iter().map(|path| alone(side, path)).collect()
    };
    let skipped = [rest(0, &left), rest(1, &right)].concat();
    let pairs = left.into_iter().zip(right).map(Into::into).collect();
    PairedFiles { pairs, skipped, nearest_s: None }
}

fn alone(side: usize, path: &Path) -> String {
    let [this, other] = if side == 0 { ["left", "right"] } else { ["right", "left"] };
    format!("{}: {this} image without a {other} one", path.display())
}

/// Fate of an image.
#[derive(Debug, PartialEq)]
pub(super) enum Partner<T> {
    /// Left and right.
    Pair([T; 2]),
    /// An image without a partner: side and image.
    Alone(usize, T),
}

/// Finds partners in two streams, each in the order of its time stamps.
#[derive(Debug)]
pub(super) struct Partners<T> {
    tolerance_s: f64,
    waiting: [VecDeque<Waiting<T>>; 2],
}

/// An image that waits for a partner.
#[derive(Debug)]
struct Waiting<T> {
    stamp: f64,
    bytes: usize,
    image: T,
}

impl<T> Partners<T> {
    pub(super) fn new(tolerance_s: f64) -> Self {
        Self { tolerance_s, waiting: [VecDeque::new(), VecDeque::new()] }
    }

    /// Adds an image; returns the images whose fate it decides.
    ///
    /// * `bytes`: memory that the image takes.
    pub(super) fn push(
        &mut self,
        side: usize,
        stamp: f64,
        bytes: usize,
        image: T,
    ) -> Vec<Partner<T>> {
        self.waiting[side].push_back(Waiting { stamp, bytes, image });
        let mut decided = Vec::new();
        while let [Some(l), Some(r)] = self.waiting.each_ref().map(VecDeque::front) {
            let late = r.stamp - l.stamp;
            let alone = if late > self.tolerance_s {
                0
            } else if late < -self.tolerance_s {
                1
            } else {
                let [l, r] = self.waiting.each_mut().map(VecDeque::pop_front);
                decided.extend(l.zip(r).map(|(l, r)| Partner::Pair([l.image, r.image])));
                continue;
            };
            self.drop_first(alone, &mut decided);
        }
        for side in 0..2 {
            while self.waits_too_long(side) {
                self.drop_first(side, &mut decided);
            }
        }
        decided
    }

    fn waits_too_long(&self, side: usize) -> bool {
        let waiting = &self.waiting[side];
        let bytes: usize = waiting.iter().map(|one| one.bytes).sum();
        waiting.len() > WAITING || (waiting.len() > 1 && bytes > WAITING_BYTES)
    }

    /// Gives up the images that still wait at the end.
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
        decided.extend(self.waiting[side].pop_front().map(|one| Partner::Alone(side, one.image)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paths(names: &[&str]) -> Vec<PathBuf> {
        names.iter().map(PathBuf::from).collect()
    }

    fn names(left: &[&str], right: &[&str]) -> (Vec<[String; 2]>, usize) {
        let found = of_files([paths(left), paths(right)], 0.005);
        let text = |path: &PathBuf| path.display().to_string();
        (found.pairs.iter().map(|pair| pair.each_ref().map(text)).collect(), found.skipped.len())
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
    fn a_gap_shifts_nothing_whichever_number_of_a_name_is_the_frame_or_the_time() {
        for (left, right) in [
            (
                ["frame0001_cam0.png", "frame0002_cam0.png", "frame0004_cam0.png"],
                ["frame0001_cam1.png", "frame0004_cam1.png"],
            ),
            (
                ["000001_10.png", "000002_10.png", "000004_10.png"],
                ["000001_10.png", "000004_10.png"],
            ),
            (
                ["cam0_run2_7.png", "cam0_run2_8.png", "cam0_run2_10.png"],
                ["cam1_run2_7.png", "cam1_run2_10.png"],
            ),
            (["s1_f9.png", "s1_f10.png", "s2_f9.png"], ["s1_f9.png", "s2_f9.png"]),
            (
                ["100.250000.png", "100.300000.png", "101.250000.png"],
                ["100.250100.png", "101.250000.png"],
            ),
            (
                ["1403636579.763555.png", "1403636579.813.png", "1403636580.01.png"],
                ["1403636579.763.png", "1403636580.011.png"],
            ),
            (
                ["1403636579763.png", "1403636579813.png", "1403636580010.png"],
                ["1403636579764.png", "1403636580011.png"],
            ),
            (
                ["1403636579763555.png", "1403636579813555.png", "1403636580010555.png"],
                ["1403636579764555.png", "1403636580011555.png"],
            ),
        ] {
            let (pairs, alone) = names(&left, &right);
            assert_eq!(pairs, [[left[0], right[0]], [left[2], right[1]]], "{left:?}");
            assert_eq!(alone, 1);
        }
    }

    #[test]
    fn the_nearest_stamps_are_known_if_no_pair_is_within_the_tolerance() {
        let left = paths(&["1403636579763555584.png", "1403636579813555456.png"]);
        let right = paths(&["1403636579771555584.png", "1403636579821555456.png"]);
        let found = of_files([left, right], 0.005);
        assert!(found.pairs.is_empty());
        assert!((found.nearest_s.unwrap() - 0.008).abs() < 1e-6, "{found:?}");
    }

    #[test]
    fn names_without_numbers_pair_in_order_and_surplus_images_are_skipped() {
        let (pairs, alone) = names(&["a.png", "b.png", "c.png"], &["x.png", "y.png"]);
        assert_eq!(pairs, [["a.png", "x.png"], ["b.png", "y.png"]]);
        assert_eq!(alone, 1);
    }

    #[test]
    fn images_of_a_stream_without_partners_are_dropped() {
        let mut partners = Partners::new(0.01);
        let alone: usize = (0..1000).map(|i| partners.push(0, f64::from(i), 0, i).len()).sum();
        assert_eq!(alone, 1000 - WAITING);
        assert_eq!(partners.push(1, 999.0, 0, -1).last(), Some(&Partner::Pair([999, -1])));
        let mut partners = Partners::new(0.01);
        let most = (0..20).map(|i| partners.push(0, f64::from(i), WAITING_BYTES / 4, i).len());
        assert_eq!(most.sum::<usize>(), 20 - 4);
    }
}
