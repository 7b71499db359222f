//! The controller at the end of a serial line: a host sends cameras and frames and gets the result of each
//! pair. `firmware-sim pil` is the host.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt::{error, info};
use defmt_semihosting as _;
use firmware_sim::board::{Link, LinkError, Timer, Uart, exit};
use firmware_sim::pil::{SessionError, run_session};
use firmware_sim::{CAPACITY, Controller};
use panic_probe as _;
use static_cell::StaticCell;
use stereo_selfcal::link::ReceiveError;

/// Constructed in place, without initial values in flash.
static CONTROLLER: StaticCell<Controller> = StaticCell::new();

#[entry]
fn main() -> ! {
    info!("waiting for cameras and frames, up to {} matches per pair", CAPACITY);
    let link = Link::new(Uart::start(), Timer::start());
    let controller = |cameras| CONTROLLER.init_with(|| firmware_sim::start(cameras));
    let ended = run_session(controller, &link, &link, |bytes| link.send(bytes));
    match ended {
        Ok(()) => info!("all pairs are finished"),
        Err(why) => log(&why),
    }
    exit(ended.is_ok())
}

fn log(why: &SessionError<LinkError, LinkError>) {
    match why {
        SessionError::Line(why) => error!("line: {}", why),
        SessionError::Request(why) => error!("request refused: {}", why),
        SessionError::Matcher(ReceiveError::Bus(why) | ReceiveError::Ready(why)) => {
            error!("line: {}", why)
        }
        SessionError::Matcher(ReceiveError::Refused(why)) => error!("frame refused: {}", why),
        _ => error!("the session failed"),
    }
}
