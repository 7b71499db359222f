//! The controller at the end of a line: cameras and frames come from a host, which is told what became
//! of each pair. `firmware-sim pil` is the host.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt::{error, info};
use defmt_semihosting as _;
use firmware_sim::board::{Link, LinkError, Timer, Uart, exit};
use firmware_sim::frame::FrameError;
use firmware_sim::pil::{ServeError, serve};
use firmware_sim::{CAPACITY, MatcherError};
use panic_probe as _;

#[entry]
fn main() -> ! {
    info!("waiting for cameras and frames, room for {} matches a pair", CAPACITY);
    let link = Link::new(Uart::start(), Timer::start());
    let served = serve(&link, &link, |bytes| link.send(bytes));
    match served {
        Ok(()) => info!("all pairs answered"),
        Err(why) => log(&why),
    }
    exit(served.is_ok())
}

fn log(why: &ServeError<LinkError, LinkError>) {
    match why {
        ServeError::Line(why) => error!("line: {}", why),
        ServeError::Opening(why) => error!("opening not taken: {}", why),
        ServeError::Matcher(MatcherError::Bus(why) | MatcherError::Ready(why)) => {
            error!("line: {}", why);
        }
        ServeError::Matcher(MatcherError::Frame(FrameError::BadMagic(bytes))) => {
            error!("no frame starts with {}", bytes);
        }
        _ => error!("a frame that is not understood"),
    }
}
