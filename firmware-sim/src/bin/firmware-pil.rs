//! Processes the recording on the controller and prints the checksum of each result; `firmware-sim pil` compares them
//! with those of this computer.
#![no_std]
#![no_main]

use cortex_m_rt::entry;
use defmt_semihosting as _;
use firmware_sim::Controller;
use firmware_sim::board::exit;
use firmware_sim::recording::{FRAMES, factory};
use panic_probe as _;
use semihosting::println;
use static_cell::StaticCell;

/// Constructed in place, without initial values in flash.
static CONTROLLER: StaticCell<Controller> = StaticCell::new();

#[entry]
fn main() -> ! {
    let Ok(factory) = factory() else { exit(false) };
    let controller = CONTROLLER.init_with(|| firmware_sim::start(factory.cameras));
    let ended = firmware_sim::checksums(FRAMES, controller, |checksum| println!("{checksum:08x}"));
    exit(ended.is_ok())
}
