//! Sink for the tests of the drivers.

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{FrameHeader, FrameRefusal, FrameSink};

/// Sink that holds the matches of the last frame.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Taken {
    pub(crate) matches: Vec<Correspondence<f32>>,
    pub(crate) busy: bool,
}

impl FrameSink for Taken {
    fn is_busy(&self) -> bool {
        self.busy
    }

    fn start(&mut self, _: &FrameHeader) -> Result<(), FrameRefusal> {
        self.matches.clear();
        Ok(())
    }

    fn take(&mut self, correspondence: &Correspondence<f32>, _: u16) {
        self.matches.push(*correspondence);
    }

    fn finish(&mut self) -> usize {
        self.matches.len()
    }

    fn discard(&mut self) {
        self.matches.clear();
    }
}
