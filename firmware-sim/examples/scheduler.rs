//! Two priorities under RTIC: an interrupt takes in the bytes of the next frame, while below it the pair
//! before is being solved, pass by pass.
//!
//! The interrupt is the timer's, and what it takes in is the recording in flash, 64 bytes a time: a
//! matcher that needs no wires. The run succeeds if every pair came through, the solver was interrupted
//! in the middle of a pass, and what it found could be applied.
//!
//! `.cargo/for-target thumbv7em-none-eabihf run -p firmware-sim --example scheduler --features scheduler`
#![no_std]
#![no_main]

use core::convert::Infallible;

use defmt_semihosting as _;
use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use heapless::spsc::{Consumer, Producer};
use panic_probe as _;

/// Room for two of the longest frames.
const ROOM: usize = 16_384;

/// The end of the queue that the driver reads as its bus; data-ready is high while bytes wait.
struct Inbox {
    bytes: core::cell::RefCell<Consumer<'static, u8>>,
}

impl spi::ErrorType for &Inbox {
    type Error = Infallible;
}

impl SpiDevice for &Inbox {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut bytes = self.bytes.borrow_mut();
        for operation in operations {
            let Operation::Read(buffer) = operation else { continue };
            for place in buffer.iter_mut() {
                // The rest of the frame is on its way: the interrupt brings it.
                *place = loop {
                    if let Some(byte) = bytes.dequeue() {
                        break byte;
                    }
                };
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for &Inbox {
    type Error = Infallible;
}

impl InputPin for &Inbox {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.bytes.borrow().ready())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.bytes.borrow().ready())
    }
}

/// The matcher's side of the queue.
struct Receiver {
    timer: firmware_sim::board::Timer,
    tape: firmware_sim::baked::Tape,
    bytes: Producer<'static, u8>,
}

#[rtic::app(device = firmware_sim::board::interrupts, peripherals = false)]
mod firmware {
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

    use defmt::{error, info};
    use firmware_sim::baked::{self, FRAMES, PAIRS, Tape};
    use firmware_sim::board::{Timer, exit};
    use firmware_sim::{App, Controller, Event};
    use heapless::spsc::Queue;
    use stereo_selfcal::Config;
    use stereo_selfcal::link::FpgaMatcher;

    use super::{Inbox, ROOM, Receiver};

    /// Bytes a tick.
    const CHUNK: usize = 64;

    /// Ticks of the timer between two chunks: 20 us, 3.2 MB/s.
    const PERIOD: u32 = Timer::HZ / 50_000;

    /// Whether a pass is being taken, and how often that has been interrupted.
    static IN_A_PASS: AtomicBool = AtomicBool::new(false);
    static INTERRUPTED: AtomicU32 = AtomicU32::new(0);

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        receiver: Receiver,
        inbox: Inbox,
        controller: &'static mut Controller,
    }

    #[init(local = [
        fifo: Queue<u8, ROOM> = Queue::new(),
        memory: Controller = Controller::new(Config::robust()),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let Ok(cameras) = baked::cameras() else { exit(false) };
        let controller = cx.local.memory;
        controller.set_cameras(cameras);
        let (bytes, read) = cx.local.fifo.split();
        let receiver = Receiver { timer: Timer::every(PERIOD), tape: Tape::new(FRAMES), bytes };
        let inbox = Inbox { bytes: read.into() };
        (Shared {}, Local { receiver, inbox, controller })
    }

    /// Takes in what has come, if there is room for it.
    #[task(binds = TIMER0, priority = 2, local = [receiver])]
    fn receive(cx: receive::Context) {
        let Receiver { timer, tape, bytes } = cx.local.receiver;
        timer.acknowledge();
        if IN_A_PASS.load(Ordering::Relaxed) {
            INTERRUPTED.fetch_add(1, Ordering::Relaxed);
        }
        if bytes.capacity() - bytes.len() < CHUNK {
            return;
        }
        for &byte in tape.take(CHUNK) {
            // There is room.
            let _ = bytes.enqueue(byte);
        }
        if tape.is_at_end() {
            timer.stop();
        }
    }

    /// All that is left of the time: one piece of work after the other.
    #[idle(local = [inbox, controller])]
    fn idle(cx: idle::Context) -> ! {
        let inbox: &Inbox = cx.local.inbox;
        let mut app = App::new(FpgaMatcher::new(inbox, inbox), cx.local.controller);
        let mut pairs = 0;
        while pairs < PAIRS {
            let event = match app.poll() {
                Ok(event) => event,
                Err(why) => {
                    error!("the matcher: {}", why);
                    exit(false)
                }
            };
            match event {
                Event::Idle => cortex_m::asm::wfi(),
                Event::Pair(pair) => {
                    pairs += 1;
                    let solved = pair.outcome.is_ok();
                    info!("pair {} of {}, solved: {}", pairs, PAIRS, solved);
                }
                _ => (),
            }
            // A frame or a pass is followed by a pass.
            let in_a_pass = matches!(event, Event::Frame { .. } | Event::Pass);
            IN_A_PASS.store(in_a_pass, Ordering::Relaxed);
        }
        let interrupted = INTERRUPTED.load(Ordering::Relaxed);
        let applied = app.apply();
        info!("bytes came in {} times in mid pass; applied: {}", interrupted, applied.is_ok());
        exit(applied.is_ok() && interrupted > 0)
    }
}
