//! The frames and pairs in a stream of bytes.

use std::io::{self, BufRead, ErrorKind};

use anyhow::{Result, ensure};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Counters, Decoder, Event, FrameHeader};

use rigs::data::{Match, Meta};

/// The whole frames of a stream, one by one in order of arrival, without repeated frames. Damaged frames are skipped
/// and counted.
#[derive(Debug)]
pub struct FrameReader<R> {
    input: R,
    decoder: Decoder,
    matches: Vec<Correspondence<f32>>,
}

/// A whole frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its header.
    pub header: FrameHeader,
    /// Its matches, as a calibrator gets them from the link.
    pub matches: Vec<Correspondence<f32>>,
}

impl<R: BufRead> FrameReader<R> {
    /// A reader at the start of a stream.
    pub fn new(input: R) -> Self {
        Self { input, decoder: Decoder::new(), matches: Vec::new() }
    }

    /// Counters of the decoder.
    pub fn counters(&self) -> &Counters {
        self.decoder.counters()
    }
}

impl<R: BufRead> Iterator for FrameReader<R> {
    type Item = io::Result<Frame>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let mut bytes = match self.input.fill_buf() {
                Ok(bytes) => bytes,
                Err(why) if why.kind() == ErrorKind::Interrupted => continue,
                Err(why) => return Some(Err(why)),
            };
            let there = bytes.len();
            let event = self.decoder.next(&mut bytes);
            let used = there - bytes.len();
            self.input.consume(used);
            match event {
                Some(Event::Started(_) | Event::Discarded) => self.matches.clear(),
                Some(Event::Match(m, _)) => self.matches.push(m),
                Some(Event::Finished(header)) => {
                    let matches = std::mem::take(&mut self.matches);
                    return Some(Ok(Frame { header, matches }));
                }
                None if there == 0 => return None,
                None => {}
            }
        }
    }
}

impl Frame {
    /// The matches as a pair of a rig, bit-identical to the matches that a calibrator gets from the link.
    ///
    /// # Errors
    /// If the size of the frame's images differs from that of the rig's left image.
    pub fn pair(&self, rig: &Meta) -> Result<Vec<Match>> {
        let [width, height] = self.header.image_size;
        ensure!(
            [width, height] == [rig.width, rig.height],
            "the images of frame {} have {width} x {height} px, the rig's have {} x {}",
            self.header.sequence,
            rig.width,
            rig.height,
        );
        Ok(self.matches.iter().map(as_match).collect())
    }
}

/// The counters of a link in words: the number of whole frames, and the counters above 0.
pub fn counted(c: &Counters) -> String {
    let rare = [
        (c.bad_crc, "with a wrong checksum"),
        (c.bad_header, "with a damaged header"),
        (c.unsupported, "of another version"),
        (c.refused, "refused"),
        (c.gaps, "missing in the sequence"),
        (c.repeats, "repeated"),
        (c.restarts, "restarts of the sender"),
        (c.overruns, "with others dropped before them by the sender"),
        (c.skipped_bytes, "bytes between frames skipped"),
    ];
    let rare = rare.into_iter().filter(|(count, _)| *count > 0);
    rare.fold(format!("{} whole frames", c.good), |text, (n, what)| format!("{text}, {n} {what}"))
}

fn as_match(c: &Correspondence<f32>) -> Match {
    let ([ul, vl], [ur, vr]) = (c.left.map(f64::from), c.right.map(f64::from));
    Match { ul, vl, ur, vr, score: c.score.into(), step: c.grid_step.into() }
}
