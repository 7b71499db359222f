//! The whole way of a large frame: wire bytes, the selection of a batch, and the pair up to its fusion.

use stereo_selfcal::link::{Decoder, MatchRecord, Received};
use stereo_selfcal::{Config, FactoryCalibration, Scalar, State};

use crate::calls::{self, CAPACITY, CalibratorOf};
use crate::frame;
use crate::lens;
use crate::pair;
use crate::probe::Probe;
use crate::scene::{Rig, Scene};
use crate::table::row;

/// Matches of a frame from an FPGA matcher.
const MATCHES: usize = 1000;

/// Frames measured after the lock.
const LOCKED_FRAMES: u32 = 8;

/// Deviation of the rig, degrees about each axis.
const OFF_DEGREES: f32 = 5.0;

struct Way<'a, T: Scalar> {
    probe: &'a Probe,
    scene: Scene,
    decoder: Decoder,
    calibrator: CalibratorOf<T>,
    records: [MatchRecord; MATCHES],
    bytes: [u8; frame::bytes(MATCHES)],
    sequence: u32,
}

/// Measures frames until the lock and after it, and prints the rows.
///
/// # Panics
/// If the estimate does not lock, or loses the lock.
#[expect(clippy::large_stack_arrays, reason = "there is no heap to put them on")]
pub(crate) fn measure<T: Scalar>(probe: &Probe) {
    let factory = FactoryCalibration::guess(lens::pinholes());
    let calibrator = CalibratorOf::new(Config::robust(), &factory);
    let mut way = Way::<T> {
        probe,
        scene: Scene::new(Rig::off(OFF_DEGREES)),
        decoder: Decoder::new(),
        calibrator,
        records: [MatchRecord::default(); MATCHES],
        bytes: [0; frame::bytes(MATCHES)],
        sequence: 0,
    };
    let mut acquiring = 0;
    while way.calibrator.state() != State::Locked {
        acquiring = acquiring.max(way.frame());
    }
    let (mut sum, mut most) = (0, 0);
    for _ in 0..LOCKED_FRAMES {
        let instructions = way.frame();
        assert!(way.calibrator.state() == State::Locked, "the rig does not move");
        (sum, most) = (sum + instructions, most.max(instructions));
    }
    let name = format_args!("frame of {MATCHES} wire to fused acquiring at most");
    row(name, "instructions", acquiring);
    let mean = (sum + LOCKED_FRAMES / 2) / LOCKED_FRAMES;
    row(format_args!("frame of {MATCHES} wire to fused locked mean"), "instructions", mean);
    row(format_args!("frame of {MATCHES} wire to fused locked at most"), "instructions", most);
}

impl<T: Scalar> Way<'_, T> {
    /// Instructions of one frame, from its first byte to the fusion of its pair.
    fn frame(&mut self) -> u32 {
        let Self { probe, scene, decoder, calibrator, records, bytes, sequence } = self;
        scene.fill(records);
        *sequence += 1;
        let header = frame::encode(*sequence, records, bytes);
        let mut rest = bytes.as_slice();
        let (fed, sample) = probe.run(|| calls::feed(decoder, &mut rest, calibrator));
        assert_eq!(fed, Ok(Some(Received { header, taken: CAPACITY })));
        sample.instructions + pair::update(probe, calibrator).update
    }
}
