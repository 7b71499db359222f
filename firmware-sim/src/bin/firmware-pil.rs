//! The controller at the end of a line: cameras and frames come from a host, which is told what became
//! of each pair. `firmware-sim pil` is the host.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt::{error, info};
use defmt_semihosting as _;
use firmware_sim::CAPACITY;
use firmware_sim::board::{Link, LinkError, Timer, Uart, exit};
use firmware_sim::pil::{ServeError, serve};
use panic_probe as _;
use stereo_selfcal::link::ReceiveError;

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
        ServeError::Matcher(ReceiveError::Bus(why) | ReceiveError::Ready(why)) => {
            error!("line: {}", why)
        }
        ServeError::Matcher(ReceiveError::Refused(why)) => error!("frame not taken: {}", why),
        _ => error!("the exchange failed"),
    }
}
