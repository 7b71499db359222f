//! A stream of bytes as the frames and pairs in it.

use std::fmt;

use anyhow::{Result, ensure};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Counters, Decoder, Event, FrameHeader};

use crate::data::{Dataset, Match, Meta};

/// Frames decoded from a stream of bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct DecodedStream {
    /// Whole frames, in the order of their arrival.
    pub frames: Vec<(FrameHeader, Vec<Correspondence<f32>>)>,
    /// Counters of the decoder.
    pub counters: Counters,
}

impl DecodedStream {
    /// Decodes a stream.
    #[must_use]
    pub fn decode(mut bytes: &[u8]) -> Self {
        let (mut decoder, mut matches, mut frames) = (Decoder::new(), Vec::new(), Vec::new());
        while let Some(event) = decoder.next(&mut bytes) {
            match event {
                Event::Started(_) | Event::Discarded(_) => matches.clear(),
                Event::Match(m) => matches.push(m),
                Event::Finished(header) => frames.push((header, std::mem::take(&mut matches))),
            }
        }
        Self { frames, counters: *decoder.counters() }
    }

    /// The frames as the pairs of a rig, bit-identical to those that a calibrator gets from the link.
    ///
    /// # Errors
    /// If there is no whole frame, or one of images of another size.
    pub fn dataset(&self, name: &str, meta: Meta) -> Result<Dataset> {
        ensure!(!self.frames.is_empty(), "not one whole frame in {name}");
        let size = [meta.width, meta.height];
        for (header, _) in &self.frames {
            let [width, height] = header.image_size;
            ensure!(
                header.image_size == size,
                "frame {} is of images of {width} x {height} px, the rig's have {} x {}",
                header.sequence,
                meta.width,
                meta.height,
            );
        }
        let pairs = self.frames.iter().map(|(_, m)| m.iter().map(as_match).collect());
        Ok(Dataset { name: name.into(), meta, pairs: pairs.collect(), rigs: Vec::new() })
    }
}

impl fmt::Display for DecodedStream {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&counted(&self.counters))
    }
}

/// The counters of a link in words.
#[must_use]
pub fn counted(c: &Counters) -> String {
    let rare = [
        (c.bad_crc, "with a wrong checksum"),
        (c.bad_header, "with a damaged header"),
        (c.truncated, "cut short"),
        (c.unsupported, "of another version"),
        (c.refused, "refused"),
        (c.gaps, "missing in the sequence"),
        (c.repeats, "repeated"),
        (c.restarts, "restarts of the sender"),
        (c.overruns, "with others dropped before them by the sender"),
        (c.skipped_bytes, "bytes between frames passed over"),
    ];
    let rare = rare.into_iter().filter(|(count, _)| *count > 0);
    rare.fold(format!("{} whole frames", c.good), |text, (n, what)| format!("{text}, {n} {what}"))
}

fn as_match(c: &Correspondence<f32>) -> Match {
    let ([ul, vl], [ur, vr]) = (c.left.map(f64::from), c.right.map(f64::from));
    Match { ul, vl, ur, vr, score: c.score.into(), step: c.grid_step.into() }
}
