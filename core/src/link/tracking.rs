//! Sink that fills a calibrator and the tracks of its frames.

use super::header::FrameHeader;
use super::sink::{FrameRefusal, FrameSink, in_scalar};
use crate::batch::correspondence::Correspondence;
use crate::calibrator::Calibrator;
use crate::depth::tracks::Tracks;
use crate::scalar::Scalar;

/// A calibrator and the tracks of its frames, for a matcher that sends tracks. Both receive each frame. The tracks cost
/// two more undistortions per tracked match.
///
/// ```
/// # use embedded_io::Read;
/// # use stereo_selfcal::{Calibrator, depth::Tracks, link::{ReadStatus, StreamMatcher, Tracking}};
/// # fn step<R: Read>(matcher: &mut StreamMatcher<R>, calibrator: &mut Calibrator<f32, 256>, tracks: &mut Tracks<f32, 256>) {
/// let mut sink = Tracking { calibrator, tracks: Some(tracks) };
/// if let Ok(ReadStatus::Frame(_)) = matcher.read(&mut sink) {
///     let outcome = calibrator.solve_pair();
///     let witnessed = calibrator.push_tracks(tracks); // NoMotion: the rig has not moved far enough yet
///     # let _ = (outcome, witnessed);
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct Tracking<'a, T: Scalar, const N: usize, const M: usize> {
    /// Receives all matches.
    pub calibrator: &'a mut Calibrator<T, N>,
    /// Receives the rays of the tracked matches; with `None`, tracks are ignored.
    pub tracks: Option<&'a mut Tracks<T, M>>,
}

impl<T: Scalar, const N: usize, const M: usize> FrameSink for Tracking<'_, T, N, M> {
    fn is_busy(&self) -> bool {
        self.calibrator.is_busy()
    }

    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal> {
        self.calibrator.start(header)?;
        if let Some(tracks) = &mut self.tracks {
            tracks.begin();
        }
        Ok(())
    }

    fn take(&mut self, c: &Correspondence<f32>, track: u16) {
        self.calibrator.take(c, track);
        // The batch counts the matches that have no rays.
        if track != 0
            && let Some(tracks) = &mut self.tracks
            && let Ok(rays) = self.calibrator.factory.cameras.rays(&in_scalar(c))
        {
            tracks.push(track, &rays);
        }
    }

    fn finish(&mut self) -> usize {
        if let Some(tracks) = &mut self.tracks {
            tracks.end();
        }
        self.calibrator.finish()
    }

    fn discard(&mut self) {
        // `Tracks` ignores a frame that has not ended.
        if let Some(tracks) = &mut self.tracks {
            tracks.begin();
        }
        self.calibrator.discard();
    }
}
