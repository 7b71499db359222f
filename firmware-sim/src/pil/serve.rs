//! The controller's side of an exchange.

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use stereo_selfcal::link::{FpgaMatcher, ReceiveError};
use thiserror::Error;
use zerocopy::IntoBytes;

use super::answer::{EndAnswer, Greeting, PairAnswer};
use super::opening::{Opening, OpeningError};
use crate::app::{App, Event};
use crate::controller::{CAPACITY, start};

/// Why an exchange ended before its last pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum ServeError<S, P> {
    /// The line failed before the first frame.
    #[error("line: {0:?}")]
    Line(S),
    /// The opening was not taken; the host has been told so.
    #[error(transparent)]
    Opening(#[from] OpeningError),
    /// The line failed, or a frame was not taken.
    #[error("{0}")]
    Matcher(#[from] ReceiveError<S, P>),
}

/// Serves one exchange, from the opening to the answer after the last pair.
///
/// * `spi`, `ready`: what the host sends.
/// * `send`: sends it an answer.
///
/// # Errors
/// [`ServeError`].
pub fn serve<SPI: SpiDevice, RDY: InputPin>(
    mut spi: SPI,
    ready: RDY,
    mut send: impl FnMut(&[u8]),
) -> Result<(), ServeError<SPI::Error, RDY::Error>> {
    let mut bytes = [0; Opening::BYTES];
    spi.read(&mut bytes).map_err(ServeError::Line)?;
    let opened = Opening::decode(bytes);
    send(Greeting::new(opened.err(), u16::try_from(CAPACITY).unwrap_or(u16::MAX)).as_bytes());
    let Opening { pairs, cameras } = opened?;

    let mut controller = start(cameras);
    let mut app = App::new(FpgaMatcher::new(spi, ready), &mut controller);
    let (mut number, mut in_batch, mut answered) = (0, 0, 0);
    while answered < pairs {
        match app.poll()? {
            Event::Frame { sequence, taken, .. } => (number, in_batch) = (sequence, taken),
            Event::Pair(pair) => {
                send(PairAnswer::new(number, in_batch, &pair, app.calibrator()).as_bytes());
                answered += 1;
            }
            _ => (),
        }
    }
    let refused = app.apply().err();
    send(EndAnswer::new(refused, app.calibrator()).as_bytes());
    Ok(())
}
