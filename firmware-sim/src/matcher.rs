//! Driver of the matcher: SPI with chip select, and a data-ready line.
//!
//! The matcher raises data-ready while a whole frame waits, and hands out its bytes in order over as
//! many transactions as the controller cares to make.

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use stereo_selfcal::Correspondence;
use thiserror::Error;
use zerocopy::IntoBytes;

use crate::frame::{FrameError, FrameHeader, Record};

/// Records read in one transaction: 320 bytes of stack.
const CHUNK: usize = 16;

/// Why a frame was not read to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum MatcherError<S, P> {
    /// The bus failed; the rest of the frame is lost.
    #[error("bus: {0:?}")]
    Bus(S),
    /// The data-ready line could not be read. Nothing is lost.
    #[error("data-ready line: {0:?}")]
    Ready(P),
    /// The header is not one that is understood.
    #[error(transparent)]
    Frame(#[from] FrameError),
}

/// The matcher at the end of its bus.
///
/// * `SPI`: the bus, an [`SpiDevice`].
/// * `RDY`: data-ready, an [`InputPin`]; high while a frame waits.
#[derive(Debug)]
pub struct Matcher<SPI, RDY> {
    spi: SPI,
    ready: RDY,
}

impl<SPI: SpiDevice, RDY: InputPin> Matcher<SPI, RDY> {
    /// A driver; the bus is not touched.
    pub const fn new(spi: SPI, ready: RDY) -> Self {
        Self { spi, ready }
    }

    /// Reads the frame that waits, if one does: its header in one transaction, its records 16 to a
    /// transaction. `None` if data-ready is low.
    ///
    /// * `each`: takes the correspondences, in order; also those of a frame that then fails.
    ///
    /// Bounded by the largest frame, 65535 records.
    ///
    /// # Errors
    /// [`MatcherError`]; the bus is not read any further.
    pub fn poll(
        &mut self,
        mut each: impl FnMut(&Correspondence<f32>),
    ) -> Result<Option<FrameHeader>, MatcherError<SPI::Error, RDY::Error>> {
        if !self.ready.is_high().map_err(MatcherError::Ready)? {
            return Ok(None);
        }
        let mut bytes = [0; FrameHeader::BYTES];
        self.spi.read(&mut bytes).map_err(MatcherError::Bus)?;
        let header = FrameHeader::decode(bytes)?;
        let count = usize::from(header.count);
        let mut chunk = [Record::EMPTY; CHUNK];
        for start in (0..count).step_by(CHUNK) {
            let records = chunk.get_mut(..CHUNK.min(count - start)).unwrap_or_default();
            self.spi.read(records.as_mut_bytes()).map_err(MatcherError::Bus)?;
            for record in records {
                each(&record.decode());
            }
        }
        Ok(Some(header))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_bus::{BusFault, TestBus, frame, record};
    use embedded_hal_mock::eh1::MockError;
    use embedded_hal_mock::eh1::digital::{
        Mock as PinMock, State::High, State::Low, Transaction as PinTransaction,
    };
    use embedded_hal_mock::eh1::spi::{Mock as SpiMock, Transaction as SpiTransaction};
    use std::vec::Vec;

    /// One read in a transaction of its own.
    fn read(bytes: &[u8]) -> [SpiTransaction<u8>; 3] {
        let [start, end] = [SpiTransaction::transaction_start(), SpiTransaction::transaction_end()];
        [start, SpiTransaction::read_vec(bytes.to_vec()), end]
    }

    #[test]
    fn a_frame_is_read_header_first_then_sixteen_records_a_transaction() {
        let records: Vec<Record> = (0..37).map(record).collect();
        let header = FrameHeader { sequence: 7, count: 37 };
        let (first, rest) = records.split_at(16);
        let (second, third) = rest.split_at(16);
        let chunks = [first, second, third].map(|chunk| read(chunk.as_bytes()));
        let expected = [read(&header.encode())].into_iter().chain(chunks).flatten();
        let mut spi = SpiMock::new(&expected.collect::<Vec<_>>());
        let mut ready = PinMock::new(&[PinTransaction::get(High)]);

        let mut seen = Vec::new();
        let polled = Matcher::new(spi.clone(), ready.clone()).poll(|c| seen.push(*c));

        assert_eq!(polled, Ok(Some(header)));
        assert_eq!(seen, records.iter().map(Record::decode).collect::<Vec<_>>());
        spi.done();
        ready.done();
    }

    #[test]
    fn an_empty_frame_is_its_header_alone() {
        let header = FrameHeader { sequence: 1, count: 0 };
        let mut spi = SpiMock::new(&read(&header.encode()));
        let mut ready = PinMock::new(&[PinTransaction::get(High)]);
        let polled = Matcher::new(spi.clone(), ready.clone()).poll(|_| panic!("no record"));
        assert_eq!(polled, Ok(Some(header)));
        spi.done();
        ready.done();
    }

    #[test]
    fn while_data_ready_is_low_the_bus_is_left_alone() {
        let mut spi = SpiMock::<u8>::new(&[]);
        let mut ready = PinMock::new(&[PinTransaction::get(Low)]);
        assert_eq!(Matcher::new(spi.clone(), ready.clone()).poll(|_| ()), Ok(None));
        spi.done();
        ready.done();
    }

    #[test]
    fn after_a_damaged_header_no_record_is_read() {
        let mut spi = SpiMock::new(&read(&[0xff; FrameHeader::BYTES]));
        let mut ready = PinMock::new(&[PinTransaction::get(High)]);
        let polled = Matcher::new(spi.clone(), ready.clone()).poll(|_| panic!("no record"));
        assert_eq!(polled, Err(MatcherError::Frame(FrameError::BadMagic([0xff; 4]))));
        spi.done();
        ready.done();
    }

    #[test]
    fn a_failing_bus_ends_the_frame_with_its_own_error() {
        for reads in 0..4 {
            let bus = TestBus::new(frame(7, (0..37).map(record)), reads);
            let mut ready = PinMock::new(&[PinTransaction::get(High)]);
            let mut seen = 0;
            let polled = Matcher::new(bus, ready.clone()).poll(|_| seen += 1);
            assert_eq!(polled, Err(MatcherError::Bus(BusFault)));
            assert_eq!(seen, [0, 0, 16, 32][reads]);
            ready.done();
        }
    }

    #[test]
    fn an_unreadable_data_ready_line_is_reported_as_such() {
        let fault = MockError::Io(std::io::ErrorKind::NotConnected);
        let mut spi = SpiMock::<u8>::new(&[]);
        let mut ready = PinMock::new(&[PinTransaction::get(High).with_error(fault.clone())]);
        let polled = Matcher::new(spi.clone(), ready.clone()).poll(|_| ());
        assert_eq!(polled, Err(MatcherError::Ready(fault)));
        spi.done();
        ready.done();
    }
}
