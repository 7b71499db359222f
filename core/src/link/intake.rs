//! What a frame goes into.

use thiserror::Error;

use super::decoder::Decoder;
use super::event::Event;
use super::header::FrameHeader;
use crate::calibrator::Calibrator;
use crate::correspondence::Correspondence;
use crate::scalar::Scalar;

/// Takes the matches of one frame at a time.
///
/// A [`Calibrator`] is one: the frame replaces its batch, which selects of a frame beyond its capacity.
pub trait Intake {
    /// Whether no frame can be taken now. The drivers then read nothing: the sender keeps the frame.
    fn is_busy(&self) -> bool {
        false
    }

    /// Makes room for a frame.
    ///
    /// # Errors
    /// [`FrameRefusal`]; nothing has changed, and nothing of the frame will come.
    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal>;

    /// Takes one match. What it cannot use it counts itself.
    fn take(&mut self, correspondence: &Correspondence<f32>);

    /// The frame is whole; how many of its matches are held.
    fn finish(&mut self) -> usize;

    /// The frame is lost: forgets what came since [`Intake::start`].
    fn discard(&mut self);
}

/// Why a frame was not taken. What was there before is untouched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameRefusal {
    /// A pair is being solved. Finish it or clear it, then read on.
    #[error("a pair is being solved")]
    Busy,
    /// `set_cameras` comes first.
    #[error("no cameras have been set")]
    NoCameras,
    /// The images are not of the size that the cameras were set with. Correct the one or the other.
    #[error("the matcher's images are {} x {} px, not the cameras'", .0[0], .0[1])]
    ImageSize([u16; 2]),
}

codes! { FrameRefusal { Busy = 1100, NoCameras = 1101, ImageSize = 1102 } }

/// A whole frame and what was taken of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Received {
    /// Its header.
    pub header: FrameHeader,
    /// Matches held of the `count` offered.
    pub taken: usize,
}

impl Decoder {
    /// Takes `bytes` into `intake`, up to the end of the first whole frame, and off their front what was
    /// used; for a receiver with buffers of its own. `None`: all are used.
    ///
    /// # Errors
    /// [`FrameRefusal`], once a frame; the rest of `bytes` is still to be fed.
    pub fn feed(
        &mut self,
        bytes: &mut &[u8],
        intake: &mut impl Intake,
    ) -> Result<Option<Received>, FrameRefusal> {
        while let Some(event) = self.next(bytes) {
            match event {
                Event::Started(header) => intake.start(&header).inspect_err(|_| self.refuse())?,
                Event::Match(correspondence) => intake.take(&correspondence),
                Event::Discarded(_) => intake.discard(),
                Event::Finished(header) => {
                    return Ok(Some(Received { header, taken: intake.finish() }));
                }
            }
        }
        Ok(None)
    }
}

/// A frame replaces the batch. While a pair is being solved nothing is taken, so that no solve is given
/// up unsaid. Do not begin a pair before [`Received`]: half a frame may be in the batch.
impl<T: Scalar, const N: usize> Intake for Calibrator<T, N> {
    fn is_busy(&self) -> bool {
        self.is_solving()
    }

    fn start(&mut self, header: &FrameHeader) -> Result<(), FrameRefusal> {
        if self.is_solving() {
            return Err(FrameRefusal::Busy);
        }
        let cameras = self.cameras().ok_or(FrameRefusal::NoCameras)?;
        if [&cameras.left, &cameras.right]
            .iter()
            .any(|camera| camera.intrinsics().size != header.image_size)
        {
            return Err(FrameRefusal::ImageSize(header.image_size));
        }
        self.clear_pair();
        Ok(())
    }

    fn take(&mut self, c: &Correspondence<f32>) {
        let correspondence = Correspondence {
            left: c.left.map(T::single),
            right: c.right.map(T::single),
            score: T::single(c.score),
            grid_step: T::single(c.grid_step),
        };
        // The batch counts what it refuses and what it leaves out.
        let _ = self.push(&correspondence);
    }

    fn finish(&mut self) -> usize {
        self.batch().pairs().len()
    }

    fn discard(&mut self) {
        if !self.is_solving() {
            self.clear_pair();
        }
    }
}
