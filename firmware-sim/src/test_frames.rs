//! Frames of the tests.

use core::ops::Range;
use std::vec::Vec;

use rigs::data::Match;
use sim::wire::Sender;
use stereo_selfcal::Correspondence;

/// The `i`-th match. All differ, and their scene makes all directions observable.
fn found(i: u16) -> Match {
    let [ul, vl] = [i * 37 % 900 + 700, i * 71 % 1100].map(f64::from);
    let disparity = f64::from(i * 13 % 97) + 20.0;
    // Score and step are exact on the wire, so they are not rounded.
    Match { ul, vl, ur: ul - disparity, vr: vl + 1.5, score: 0.2, step: 1.0 / 256.0 }
}

/// The `i`-th match as the core takes it.
pub(crate) fn correspondence(i: u16) -> Correspondence<f32> {
    found(i).correspondence()
}

/// Encodes a frame of these matches, of images of 1920 x 1200 px.
pub(crate) fn frame(sequence: u32, matches: Range<u16>) -> Vec<u8> {
    let sender = Sender::new([1920, 1200], []).expect("no grid");
    sender.frame(sequence, &matches.map(found).collect::<Vec<_>>()).0
}
