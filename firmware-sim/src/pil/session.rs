//! The controller's side of a session.

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use stereo_selfcal::Cameras;
use stereo_selfcal::link::{FpgaMatcher, ReceiveError};
use thiserror::Error;
use zerocopy::IntoBytes;

use super::reply::{EndReply, PairReply, SessionReply};
use super::request::{RequestError, SessionRequest};
use crate::app::{App, Event};
use crate::controller::{CAPACITY, Controller};

/// Why a session ended before its last pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SessionError<S, P> {
    /// The line failed before the first frame.
    #[error("line: {0:?}")]
    Line(S),
    /// The request was refused. The host has the reason.
    #[error(transparent)]
    Request(#[from] RequestError),
    /// The line failed, or a frame was refused.
    #[error("{0}")]
    Matcher(#[from] ReceiveError<S, P>),
}

/// Runs one session, from the request to the reply after the last pair.
///
/// * `controller`: returns a calibrator without any pair, for the cameras of the request.
/// * `spi`, `ready`: input from the host.
/// * `send`: output to the host.
///
/// # Errors
/// [`SessionError`].
pub fn run_session<'a, SPI: SpiDevice, RDY: InputPin>(
    controller: impl FnOnce(Cameras<f32>) -> &'a mut Controller,
    mut spi: SPI,
    ready: RDY,
    mut send: impl FnMut(&[u8]),
) -> Result<(), SessionError<SPI::Error, RDY::Error>> {
    let mut bytes = [0; SessionRequest::BYTES];
    spi.read(&mut bytes).map_err(SessionError::Line)?;
    let request = SessionRequest::decode(bytes);
    send(SessionReply::new(request.err(), u16::try_from(CAPACITY).unwrap_or(u16::MAX)).as_bytes());
    let SessionRequest { pairs, cameras } = request?;

    let controller = controller(cameras);
    let mut app = App::new(FpgaMatcher::new(spi, ready), controller);
    let (mut number, mut in_batch, mut finished) = (0, 0, 0);
    while finished < pairs {
        match app.poll()? {
            Event::Frame { sequence, taken, .. } => (number, in_batch) = (sequence, taken),
            Event::Pair(pair) => {
                send(PairReply::new(number, in_batch, &pair, app.calibrator()).as_bytes());
                finished += 1;
            }
            _ => (),
        }
    }
    let refused = app.apply().err();
    send(EndReply::new(refused, app.calibrator()).as_bytes());
    Ok(())
}
