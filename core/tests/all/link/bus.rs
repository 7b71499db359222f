//! Simulated matcher: bytes to be read, and a log of the reads.

use core::cell::RefCell;
use core::convert::Infallible;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{FrameHeader, FrameRefusal, FrameSink};

/// Far end of the wire. Idle bytes are `0xff`.
#[derive(Debug, Default, Clone)]
pub(crate) struct Far(Rc<RefCell<State>>);

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<u8>,
    reads: Vec<usize>,
    failing: bool,
}

impl Far {
    pub(crate) fn send(&self, bytes: impl IntoIterator<Item = u8>) {
        self.0.borrow_mut().waiting.extend(bytes);
    }

    /// Sets whether reads fail; a failed read loses its bytes.
    pub(crate) fn fail(&self, failing: bool) {
        self.0.borrow_mut().failing = failing;
    }

    pub(crate) fn waits(&self) -> bool {
        !self.0.borrow().waiting.is_empty()
    }

    /// Lengths of the reads so far.
    pub(crate) fn reads(&self) -> Vec<usize> {
        self.0.borrow().reads.clone()
    }

    fn take(&self, buffer: &mut [u8]) -> Result<usize, ErrorKind> {
        let mut state = self.0.borrow_mut();
        state.reads.push(buffer.len());
        let count = buffer.len().min(state.waiting.len());
        for (to, from) in buffer.iter_mut().zip(state.waiting.drain(..count)) {
            *to = from;
        }
        if state.failing { Err(ErrorKind::Overrun) } else { Ok(count) }
    }
}

impl ErrorType for Far {
    type Error = ErrorKind;
}

impl SpiDevice for Far {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        for operation in operations {
            let Operation::Read(buffer) = operation else { panic!("a matcher is only read from") };
            buffer.fill(0xff);
            self.take(buffer)?;
        }
        Ok(())
    }
}

/// Data-ready: high while bytes wait.
impl embedded_hal::digital::ErrorType for Far {
    type Error = Infallible;
}

impl embedded_hal::digital::InputPin for Far {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.waits())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.waits())
    }
}

/// [`Far`] as a UART with at most 100 bytes per read.
#[derive(Debug, Clone)]
pub(crate) struct Uart(pub(crate) Far);

impl embedded_io::ErrorType for Uart {
    type Error = embedded_io::ErrorKind;
}

impl embedded_io::Read for Uart {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, embedded_io::ErrorKind> {
        let most = buffer.len().min(100);
        self.0.take(&mut buffer[..most]).map_err(|_| embedded_io::ErrorKind::Other)
    }
}

impl embedded_io::ReadReady for Uart {
    fn read_ready(&mut self) -> Result<bool, embedded_io::ErrorKind> {
        Ok(self.0.waits())
    }
}

/// Sink that holds the last frame.
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

    fn take(&mut self, correspondence: &Correspondence<f32>) {
        self.matches.push(*correspondence);
    }

    fn finish(&mut self) -> usize {
        self.matches.len()
    }

    fn discard(&mut self) {
        self.matches.clear();
    }
}
