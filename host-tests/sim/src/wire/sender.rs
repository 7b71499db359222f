//! A data set as the frames of a matcher.

use anyhow::{Context, Result, ensure};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Encoder, FrameHeader, MatchRecord};

use rigs::data::{Dataset, Match};

/// Time between pairs, us: 20 Hz.
const PERIOD_US: u64 = 50_000;

/// Fraction bits of a frame: 1/256 px.
const FRACTION_BITS: u8 = 8;

/// Pyramid ratios that are tried, in 1/64: from 1 to the largest that a header can carry.
const RATIOS: std::ops::RangeInclusive<u8> = 64..=255;

/// Turns pairs into frames.
#[derive(Debug, Clone, Copy)]
pub struct Sender {
    header: FrameHeader,
}

impl Sender {
    /// A sender for images of a size, px, and for matches on grids with these steps, px.
    ///
    /// # Errors
    /// If no pyramid of 16 levels has all these steps.
    pub fn new(image_size: [u16; 2], steps: impl IntoIterator<Item = f64>) -> Result<Self> {
        let mut steps: Vec<f64> = steps.into_iter().collect();
        steps.sort_by(f64::total_cmp);
        steps.dedup();
        let base = steps.iter().copied().find(|step| *step > 0.0).unwrap_or(0.0);
        let header = |pyramid_ratio| FrameHeader {
            timestamp_us: 0,
            sequence: 0,
            count: 0,
            image_size,
            grid_step: in_256ths(base),
            fraction_bits: FRACTION_BITS,
            pyramid_ratio,
            dropped_before: false,
            more_found: false,
        };
        // Chooses the ratio whose worst relative error over all steps is least.
        let worst = |header: &FrameHeader| {
            let errors = steps.iter().map(|step| error_of(header, *step));
            errors.reduce(f64::max).unwrap_or(0.0)
        };
        let best = RATIOS.map(header).min_by(|a, b| worst(a).total_cmp(&worst(b)));
        let header = best.context("there are ratios")?;
        ensure!(worst(&header) < f64::INFINITY, "no pyramid has the grid steps {steps:?} px");
        Ok(Self { header })
    }

    /// A sender of a data set.
    pub fn of(set: &Dataset) -> Result<Self> {
        let steps = set.pairs.iter().flatten().map(|m| m.step);
        Self::new([set.meta.width, set.meta.height], steps)
    }

    /// A pair as one frame, and the number of its matches that the frame cannot carry: matches with a quantity out of
    /// range or with a grid step of no level, and matches beyond the first 65535.
    pub fn frame(&self, sequence: u32, pair: &[Match]) -> (Vec<u8>, usize) {
        let plain: Vec<(Match, u16)> = pair.iter().map(|m| (*m, 0)).collect();
        self.tracked_frame(sequence, &plain)
    }

    /// As [`Sender::frame`], with the number of each match's track; 0 without a track. The frame carries the low 12
    /// bits of the number.
    pub fn tracked_frame(&self, sequence: u32, pair: &[(Match, u16)]) -> (Vec<u8>, usize) {
        let encode = |(m, track): &(Match, u16)| {
            let record = MatchRecord::encode(&m.correspondence(), &self.header);
            record.map(|record| record.with_track(*track)).ok()
        };
        let records: Vec<MatchRecord> =
            pair.iter().filter_map(encode).take(u16::MAX.into()).collect();
        let header = FrameHeader {
            timestamp_us: u64::from(sequence) * PERIOD_US,
            sequence,
            count: u16::try_from(records.len()).unwrap_or(u16::MAX),
            ..self.header
        };
        (seal(&header, &records), pair.len() - records.len())
    }
}

/// Header, records and checksum as one frame.
pub(super) fn seal(header: &FrameHeader, records: &[MatchRecord]) -> Vec<u8> {
    let (mut encoder, start) =
        Encoder::begin(*header).expect("fraction bits and ratio are in range");
    let mut bytes = start.to_vec();
    for record in records {
        bytes.extend(encoder.push_record(record).expect("the header counts the records"));
    }
    bytes.extend(encoder.finish().expect("the header counts the records"));
    bytes
}

/// Relative error of a grid step that is sent as its closest level; infinite if no level is close.
fn error_of(header: &FrameHeader, step: f64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "the core's scalar")]
    let step = step as f32;
    let Some(level) = header.level_of(step) else { return f64::INFINITY };
    let sent = header.grid_step_px(level);
    // A step finer than that of the wire is sent as the step of the wire.
    if step <= sent && header.grid_step == 0 { 0.0 } else { f64::from((sent / step - 1.0).abs()) }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "kept in range")]
fn in_256ths(px: f64) -> u16 {
    (px * 256.0).round().clamp(0.0, 65_535.0) as u16
}

/// A match of continuous coordinates, rounded to the resolution of the wire. Computed independently of the link.
pub fn quantised(m: &Match) -> Correspondence<f32> {
    let exact: Correspondence<f32> = m.correspondence();
    let px = |x: f32| (x * 256.0).round() / 256.0;
    Correspondence {
        left: exact.left.map(px),
        right: exact.right.map(px),
        score: (exact.score * 65_535.0).round() / 65_535.0,
        grid_step: 1.0 / 256.0,
    }
}
