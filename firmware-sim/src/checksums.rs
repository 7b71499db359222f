//! One checksum per pair over everything that the application computes: two processors print the same numbers only if
//! they compute the same bits.

use core::convert::Infallible;
use core::fmt::{self, Write};

use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use stereo_selfcal::link::ReceiveError;

use crate::app::{App, Event};
use crate::controller::Controller;
use crate::recording::ReplayBus;

static CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// A checksum of text and bytes.
struct Checksum(Digest<'static, u32>);

impl Write for Checksum {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

/// Processes the frames of a recording and applies the estimate.
///
/// * `report`: takes a checksum after each pair, and one at the end.
///
/// # Errors
/// [`ReceiveError::Refused`] if the calibrator refuses a frame.
pub fn checksums(
    frames: &[u8],
    controller: &mut Controller,
    mut report: impl FnMut(u32),
) -> Result<(), ReceiveError<Infallible, Infallible>> {
    let bus = ReplayBus::new(frames);
    let mut app = App::new(bus.driver(), controller);
    loop {
        match app.poll()? {
            Event::Idle => break,
            Event::Pair(pair) => report(checksum(&pair, app.calibrator())),
            _ => (),
        }
    }
    let applied = app.apply();
    report(checksum(&applied, app.calibrator()));
    Ok(())
}

/// Checksum of a result, of the proposal and of the calibrator's snapshot. `Debug` prints each `f32` such that it
/// reads back with the same bits.
fn checksum(result: &impl fmt::Debug, controller: &Controller) -> u32 {
    let mut checksum = Checksum(CRC.digest());
    // The checksum at the end of the snapshot would make that of the whole snapshot a constant.
    let snapshot = controller.snapshot();
    let state = snapshot.split_last_chunk::<4>().map_or(&[][..], |(state, _)| state);
    checksum.0.update(state);
    // `write_str` never fails.
    let _ = write!(checksum, "{result:?}{:?}", controller.proposal());
    checksum.0.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{FRAMES, factory};
    use crate::start;
    use std::boxed::Box;
    use std::vec::Vec;
    use stereo_selfcal::link::{FrameCrc, FrameHeader, MatchRecord};

    fn of(frames: &[u8]) -> Vec<u32> {
        let mut controller = Box::new(start(factory().unwrap().cameras));
        let mut found = Vec::new();
        checksums(frames, &mut controller, |checksum| found.push(checksum)).unwrap();
        found
    }

    /// The frames of the recording, with the lowest bit of one match of the first frame changed.
    fn changed() -> Vec<u8> {
        let mut frames = FRAMES.to_vec();
        let header: [u8; FrameHeader::BYTES] = *frames.first_chunk().unwrap();
        let end = FrameHeader::decode(&header).unwrap().frame_bytes();
        frames[FrameHeader::BYTES] ^= 1;
        let mut crc = FrameCrc::new(&header);
        let records = &frames[FrameHeader::BYTES..end - FrameCrc::BYTES];
        let (records, []) = records.as_chunks::<{ MatchRecord::BYTES }>() else { panic!() };
        for record in records {
            crc.add(record);
        }
        frames[end - FrameCrc::BYTES..end].copy_from_slice(&crc.value().to_le_bytes());
        frames
    }

    #[test]
    fn each_pair_and_the_end_have_a_checksum_that_repeats() {
        let found = of(FRAMES);
        assert_eq!(found.len(), 13 + 1);
        assert_eq!(of(FRAMES), found);
        let mut different = found.clone();
        different.sort_unstable();
        different.dedup();
        assert_eq!(different.len(), found.len());
    }

    #[test]
    fn one_bit_of_one_match_changes_every_checksum_from_its_pair_on() {
        let both = of(FRAMES).into_iter().zip(of(&changed()));
        assert!(both.clone().all(|(a, b)| a != b), "{:x?}", both.collect::<Vec<_>>());
    }

    #[test]
    fn the_sign_of_a_zero_changes_the_checksum() {
        let controller = Box::new(start(factory().unwrap().cameras));
        assert_ne!(checksum(&0.0_f32, &controller), checksum(&-0.0_f32, &controller));
    }
}
