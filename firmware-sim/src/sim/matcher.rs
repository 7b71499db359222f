//! A matcher made of recorded data: SPI device and data-ready line over one queue of bytes.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use host_tests::dataset::Match;
use stereo_selfcal::link::{FpgaMatcher, FrameCrc, FrameHeader, Record};

type Wire = Rc<RefCell<VecDeque<u8>>>;

/// What an idle bus reads as.
const IDLE: u8 = 0xff;

/// Fraction bits of the coordinates, and the step of the wire that they make, px.
const FRACTION_BITS: u8 = 8;
const WIRE_STEP_PX: f32 = 1.0 / 256.0;

/// The matcher's side of the bus.
#[derive(Debug)]
pub(crate) struct SimMatcher {
    wire: Wire,
    image_size: [u16; 2],
}

impl SimMatcher {
    /// A matcher with nothing to send yet.
    ///
    /// * `image_size`: of both images, px.
    pub(crate) fn new(image_size: [u16; 2]) -> Self {
        Self { wire: Wire::default(), image_size }
    }

    /// The controller's side of the bus.
    pub(crate) fn driver(&self) -> FpgaMatcher<SimSpi, SimReady> {
        FpgaMatcher::new(SimSpi(Rc::clone(&self.wire)), SimReady(Rc::clone(&self.wire)))
    }

    /// Puts a pair on the bus as one frame and raises data-ready.
    pub(crate) fn send(&self, sequence: u32, pair: &[Match]) {
        self.wire.borrow_mut().extend(self.frame(sequence, pair));
    }

    /// A pair as one frame. A match that no frame can carry (beyond its range, of another grid than the
    /// others, or beyond its 65535 records) stays behind.
    pub(crate) fn frame(&self, sequence: u32, pair: &[Match]) -> Vec<u8> {
        let header = self.header(sequence, pair);
        let records = pair.iter().filter_map(|m| Record::encode(&m.correspondence(), &header).ok());
        let records: Vec<_> =
            records.take(u16::MAX.into()).map(|record| record.to_bytes()).collect();
        let count = u16::try_from(records.len()).unwrap_or(u16::MAX);
        let header = FrameHeader { count, ..header }.encode().expect("bits and ratio are valid");
        let mut crc = FrameCrc::new(&header);
        for record in &records {
            crc.add(record);
        }
        [&header[..], records.as_flattened(), &crc.value().to_le_bytes()].concat()
    }

    /// The header whose pyramid has the steps of all matches, as nearly as one can: their finest step
    /// is that of level 0, and that of the wire where they have none.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "`as` keeps within the range"
    )]
    fn header(&self, sequence: u32, pair: &[Match]) -> FrameHeader {
        let mut steps: Vec<f32> =
            pair.iter().map(|m| m.correspondence::<f32>().grid_step).collect();
        steps.sort_by(f32::total_cmp);
        steps.dedup();
        let finest = steps.first().copied().unwrap_or_default();
        let header = FrameHeader {
            timestamp_us: 0,
            sequence,
            count: 0,
            image_size: self.image_size,
            grid_step: (finest / WIRE_STEP_PX).round() as u16,
            fraction_bits: FRACTION_BITS,
            pyramid_ratio: 64,
            dropped_before: false,
            more_found: false,
        };
        let error = |header: &FrameHeader, step: f32| {
            let said = header.level_of(step).map_or(f32::INFINITY, |l| header.grid_step_px(l));
            (said / step.max(WIRE_STEP_PX) - 1.0).abs()
        };
        let worst = |header: &FrameHeader| {
            steps.iter().map(|&step| error(header, step)).fold(0.0, f32::max)
        };
        let headers = (64..=u8::MAX).map(|pyramid_ratio| FrameHeader { pyramid_ratio, ..header });
        let best = headers.min_by(|a, b| worst(a).total_cmp(&worst(b)));
        best.unwrap_or(header)
    }
}

/// The bus: reads take what has been sent, writes go nowhere.
#[derive(Debug)]
pub(crate) struct SimSpi(Wire);

impl spi::ErrorType for SimSpi {
    type Error = Infallible;
}

impl SpiDevice for SimSpi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut wire = self.0.borrow_mut();
        for operation in operations {
            if let Operation::Read(buffer)
            | Operation::Transfer(buffer, _)
            | Operation::TransferInPlace(buffer) = operation
            {
                buffer.fill_with(|| wire.pop_front().unwrap_or(IDLE));
            }
        }
        Ok(())
    }
}

/// Data-ready: high while bytes wait.
#[derive(Debug)]
pub(crate) struct SimReady(Wire);

impl digital::ErrorType for SimReady {
    type Error = Infallible;
}

impl InputPin for SimReady {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.borrow().is_empty())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.borrow().is_empty())
    }
}
