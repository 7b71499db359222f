//! Matches the pairs of a source: a bounded number at a time, in parallel, with results in order.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};
use image::metadata::Orientation;
use rayon::prelude::*;

use crate::matcher::{Matched, Matcher};
use crate::picture::Picture;
use crate::source::{Frame, Item, Source};

/// A matched pair, or a skipped item.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "two frames are no more than their paths")]
pub enum Done {
    /// Matches of a pair.
    Matched {
        /// Its images.
        frames: [Frame; 2],
        /// Its matches.
        matched: Matched,
    },
    /// A skipped item, and why.
    Skipped {
        /// Kind of reason, for the count.
        kind: Skip,
        /// Full text of the reason.
        why: String,
    },
}

/// Reason for a skipped item.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Skip {
    /// An image without a partner.
    Alone,
    /// A damaged part of a bag.
    Damaged,
    /// An image cannot be read or decoded, or the pair cannot be matched.
    Unreadable,
    /// An image differs in size from those of the rig.
    Size,
    /// An image is empty: all its pixels have almost the same grey value.
    Blank,
    /// Left and right are exchanged.
    Exchanged,
}

impl Skip {
    /// All reasons.
    pub const ALL: [Self; 6] =
        [Self::Alone, Self::Damaged, Self::Unreadable, Self::Size, Self::Blank, Self::Exchanged];

    /// Description that follows a number.
    pub fn words(self) -> &'static str {
        match self {
            Self::Alone => "without a partner",
            Self::Damaged => "damaged in the bag",
            Self::Unreadable => "that cannot be read",
            Self::Size => "of another size",
            Self::Blank => "that show nothing",
            Self::Exchanged => "with left and right exchanged",
        }
    }
}

/// Selected pairs of a source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Selection {
    /// Step between the pairs taken: 1 takes every pair, 2 every second pair.
    pub every: usize,
    /// Largest number of pairs to take.
    pub most: usize,
}

/// The first readable pair of a source.
#[derive(Debug, Clone)]
pub struct First {
    /// Left and right.
    pub frames: [Frame; 2],
    /// Width and height as stored, px.
    pub sizes: [[u16; 2]; 2],
    /// EXIF orientations.
    pub turns: [Orientation; 2],
}

impl First {
    /// Width and height of the left and the right image, px.
    ///
    /// * `upright`: for each side, whether its image is turned by its EXIF orientation.
    pub fn sizes_if(&self, upright: [bool; 2]) -> [[u16; 2]; 2] {
        [0, 1].map(|side| {
            let [w, h] = self.sizes[side];
            if upright[side] && is_quarter(self.turns[side]) { [h, w] } else { [w, h] }
        })
    }
}

fn is_quarter(turn: Orientation) -> bool {
    matches!(
        turn,
        Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH
    )
}

/// Reads the first pair that can be decoded.
///
/// # Errors
/// If no pair of the source can be read.
pub fn first(source: &Source) -> Result<First> {
    let (mut found, mut why) = (None, None);
    source.read(&mut |item| {
        match item {
            Item::Skipped(_) | Item::Damaged(_) => {}
            Item::Pair(frames) => match frames.each_ref().map(Frame::picture_and_turn) {
                [Ok((left, l)), Ok((right, r))] => {
                    found =
                        Some(First { frames, sizes: [left.size(), right.size()], turns: [l, r] });
                }
                [Err(error), _] | [_, Err(error)] => why = Some(error),
            },
        }
        if found.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    match (found, why) {
        (Some(found), _) => Ok(found),
        (None, Some(error)) => {
            Err(error.context(format!("no pair of {} can be read", source.name)))
        }
        (None, None) => Err(anyhow::anyhow!(source.without_pairs())),
    }
}

/// Matches the pairs of a source; `each` receives them in order, and ends the run with `Break`.
///
/// * `sizes`: sizes of the rig's images, left and right, px.
/// * `stop`: ends the run after the pairs that have begun.
///
/// # Errors
/// If the source cannot be opened.
pub fn run(
    source: &Source,
    matcher: &Matcher,
    sizes: [[u16; 2]; 2],
    selection: Selection,
    stop: &AtomicBool,
    mut each: impl FnMut(Done) -> ControlFlow<()>,
) -> Result<()> {
    let room = 2 * rayon::current_num_threads();
    let mut waiting: Vec<Item> = Vec::with_capacity(room);
    let (mut seen, mut taken) = (0, 0);
    let mut ended = false;
    let mut flush = |waiting: &mut Vec<Item>| {
        let done: Vec<Done> =
            waiting.par_drain(..).map(|item| processed(item, matcher, sizes)).collect();
        for one in done {
            each(one)?;
        }
        if stop.load(Ordering::Relaxed) {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    source.read(&mut |item| {
        if matches!(item, Item::Pair(_)) {
            seen += 1;
            if (seen - 1) % selection.every != 0 {
                return ControlFlow::Continue(());
            }
            taken += 1;
        }
        waiting.push(item);
        if waiting.len() < room && taken < selection.most {
            return ControlFlow::Continue(());
        }
        ended = flush(&mut waiting).is_break() || taken >= selection.most;
        if ended { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if !ended {
        // These are the last pairs, so the answer does not matter.
        let _ = flush(&mut waiting);
    }
    Ok(())
}

fn processed(item: Item, matcher: &Matcher, sizes: [[u16; 2]; 2]) -> Done {
    let skipped = |kind, why| Done::Skipped { kind, why };
    let frames = match item {
        Item::Pair(frames) => frames,
        Item::Skipped(why) => return skipped(Skip::Alone, why),
        Item::Damaged(why) => return skipped(Skip::Damaged, why),
    };
    let name = format!("{} and {}", frames[0], frames[1]);
    let pictures = frames.each_ref().map(Frame::picture);
    let [left, right] = match pictures {
        [Ok(left), Ok(right)] => [left, right],
        [Err(why), _] | [_, Err(why)] => return skipped(Skip::Unreadable, format!("{why:#}")),
    };
    if let Some(why) = unfit([&left, &right], sizes) {
        return skipped(why.0, format!("{name}: {}", why.1));
    }
    match matcher.matches(&left, &right).with_context(|| name.clone()) {
        Ok(matched) if matched.is_exchanged() => {
            let [positive, negative] = matched.signs;
            let of = positive + negative;
            let why = format!(
                "{name}: left and right are exchanged: {negative} of {of} disparities are negative"
            );
            skipped(Skip::Exchanged, why)
        }
        Ok(matched) => Done::Matched { frames, matched },
        Err(why) => skipped(Skip::Unreadable, format!("{why:#}")),
    }
}

/// Why pictures cannot be matched, if so.
fn unfit(pictures: [&Picture; 2], sizes: [[u16; 2]; 2]) -> Option<(Skip, String)> {
    for ((side, picture), size) in ["left", "right"].into_iter().zip(pictures).zip(sizes) {
        let [width, height] = picture.size();
        if picture.size() != size {
            let [w, h] = size;
            let why =
                format!("the {side} image has {width} x {height} px, the rig's have {w} x {h}");
            return Some((Skip::Size, why));
        }
        if picture.is_blank() {
            return Some((Skip::Blank, format!("the {side} image is empty: all one grey value")));
        }
    }
    None
}
