//! Receiver of decoded frames.

use thiserror::Error;

use super::header::FrameHeader;
use crate::batch::correspondence::Correspondence;
use crate::calibrator::Calibrator;
use crate::error::BUSY;
use crate::scalar::Scalar;

/// Receiver of the matches of one frame at a time: a [`Calibrator`], or a buffer of the caller.
pub trait FrameSink {
    /// Returns whether the sink cannot take a frame now. If so, the drivers read nothing, and the sender keeps the
    /// frame.
    fn is_busy(&self) -> bool {
        false
    }

    /// Prepares for the matches of a frame.
    ///
    /// # Errors
    /// [`FrameRefusal`]: the sink is unchanged and receives no match of this frame.
    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal>;

    /// Takes one match, in px. The sink counts the matches it rejects.
    ///
    /// * `track`: track number as the matcher sent it, up to 4095; 0 for a match without a track.
    fn take(&mut self, correspondence: &Correspondence<f32>, track: u16);

    /// Ends a whole frame; returns the number of its matches that are held.
    fn finish(&mut self) -> usize;

    /// Ends a damaged frame: drops every match since [`FrameSink::start`].
    fn discard(&mut self);
}

/// Why a sink refused a frame. The content of the sink is unchanged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameRefusal {
    /// A pair is being solved. Finish or discard it, then read again.
    #[error("a pair is being solved")]
    Busy,
    /// The image size differs from the image size of the left camera. Correct the sender or the cameras.
    #[error("the matcher's images are {} x {} px, not the cameras'", .0[0], .0[1])]
    ImageSize([u16; 2]),
}

codes! { FrameRefusal { Busy = BUSY, ImageSize = 1102 } }

/// A whole frame in the sink.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Received {
    /// Header of the frame.
    pub header: FrameHeader,
    /// Number of matches held, out of `header.count` sent.
    pub taken: usize,
}

/// Converts a match to the scalar of a calibrator.
#[inline(always)]
pub(super) fn in_scalar<T: Scalar>(c: &Correspondence<f32>) -> Correspondence<T> {
    let ([u_l, v_l], [u_r, v_r]) = (c.left, c.right);
    Correspondence {
        left: [T::single(u_l), T::single(v_l)],
        right: [T::single(u_r), T::single(v_r)],
        score: T::single(c.score),
        grid_step: T::single(c.grid_step),
    }
}

/// The frame replaces the content of the batch. The batch selects from a frame that exceeds its capacity.
///
/// No frame is taken while a pair is being solved.
///
/// The matches of a frame stay hidden until its CRC proves correct. Before [`Received`] the batch therefore appears
/// empty, and solving it returns [`crate::Rejection::TooFew`] with 0 usable correspondences. The hidden matches stay
/// in the batch: if the link stops within a frame and continues later, the frame is received whole.
/// [`Calibrator::discard_pair`] gives the frame up: its other matches are dropped, and [`Received::taken`] is 0.
impl<T: Scalar, const N: usize> FrameSink for Calibrator<T, N> {
    fn is_busy(&self) -> bool {
        self.is_solving()
    }

    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal> {
        if self.is_solving() {
            return Err(FrameRefusal::Busy);
        }
        // The header does not contain the size of the right image, which may differ.
        if self.factory.cameras.left.intrinsics().size != header.image_size {
            return Err(FrameRefusal::ImageSize(header.image_size));
        }
        self.discard_pair();
        self.batch.begin_frame();
        Ok(())
    }

    #[inline(always)]
    fn take(&mut self, c: &Correspondence<f32>, _: u16) {
        // If `discard_pair` has given the frame up, its other matches are dropped. While a frame arrives, its matches
        // are hidden, so no pair is being solved.
        if !self.batch.is_arriving() {
            return;
        }
        // The batch counts refused and omitted matches.
        let _ = self.batch.push(&self.corrected, &in_scalar(c));
    }

    fn finish(&mut self) -> usize {
        if !self.batch.is_arriving() {
            return 0;
        }
        self.batch.end_frame();
        self.batch.matches().len()
    }

    fn discard(&mut self) {
        if self.batch.is_arriving() {
            self.discard_pair();
        }
    }
}
