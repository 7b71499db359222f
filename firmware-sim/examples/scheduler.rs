//! Two priorities under RTIC: an interrupt receives the bytes of the next frame, and the idle task solves
//! the previous pair, pass by pass.
//!
//! A timer interrupt simulates the matcher: it takes 64 bytes of the recording in flash at a time. The run
//! succeeds if every pair is received, the solver was interrupted within a pass, and the estimate can be
//! applied.
//!
//! `.cargo/for-target thumbv7em-none-eabihf run -p firmware-sim --example scheduler --features controller`
#![no_std]
#![no_main]

use core::convert::Infallible;

use defmt_semihosting as _;
use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use heapless::spsc::{Consumer, Producer};
use panic_probe as _;

/// Size of the queue, bytes: more than two of the longest frames of the recording.
const QUEUE_BYTES: usize = 16_384;

/// The driver's end of the queue, as a bus. Data-ready is high while bytes wait.
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
                // The interrupt enqueues the rest of the frame.
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

/// The matcher's end of the queue.
struct Receiver {
    timer: firmware_sim::board::Timer,
    recording: firmware_sim::recording::ReplayBus<'static>,
    bytes: Producer<'static, u8>,
}

#[rtic::app(device = firmware_sim::board::interrupts, peripherals = false)]
mod firmware {
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

    use defmt::{error, info};
    use firmware_sim::board::{Timer, exit};
    use firmware_sim::recording::{self, FRAMES, ReplayBus};
    use firmware_sim::{App, Controller, Event};
    use heapless::spsc::Queue;
    use static_cell::StaticCell;
    use stereo_selfcal::Calibration;
    use stereo_selfcal::link::FpgaMatcher;

    use super::{Inbox, QUEUE_BYTES, Receiver};

    /// Bytes per interrupt.
    const CHUNK: usize = 64;

    /// Ticks of the timer per interrupt: 20 us, 3.2 MB/s.
    const PERIOD: u32 = Timer::HZ / 50_000;

    /// Whether a step of a pair is running, a pass or the fusion, and the number of interrupts within such steps.
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
        fifo: Queue<u8, QUEUE_BYTES> = Queue::new(),
        memory: StaticCell<Controller> = StaticCell::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let Ok(factory) = recording::factory() else { exit(false) };
        // In place: a `const` initial value would take as much flash as the calibrator.
        let controller = cx.local.memory.init_with(|| firmware_sim::start(factory.cameras));
        load_rectifier(&controller.in_use());
        let (bytes, read) = cx.local.fifo.split();
        let receiver =
            Receiver { timer: Timer::every(PERIOD), recording: ReplayBus::new(FRAMES), bytes };
        let inbox = Inbox { bytes: read.into() };
        (Shared {}, Local { receiver, inbox, controller })
    }

    /// Stands for the board's rectifier, which loads the calibration in use at the start and each one that is applied.
    fn load_rectifier(calibration: &Calibration<f32>) {
        info!("rectifier: generation {}, {}", calibration.generation, calibration.extrinsics);
    }

    /// Enqueues the next bytes if they fit.
    #[task(binds = TIMER0, priority = 2, local = [receiver])]
    fn receive(cx: receive::Context) {
        let Receiver { timer, recording, bytes } = cx.local.receiver;
        timer.acknowledge();
        if IN_A_PASS.load(Ordering::Relaxed) {
            INTERRUPTED.fetch_add(1, Ordering::Relaxed);
        }
        if bytes.capacity() - bytes.len() < CHUNK {
            return;
        }
        for &byte in recording.take(CHUNK) {
            // The bytes fit, as checked above.
            let _ = bytes.enqueue(byte);
        }
        if recording.is_at_end() {
            timer.stop();
        }
    }

    /// Polls the application with the lowest priority.
    #[idle(local = [inbox, controller])]
    fn idle(cx: idle::Context) -> ! {
        let inbox: &Inbox = cx.local.inbox;
        let mut app = App::new(FpgaMatcher::new(inbox, inbox), cx.local.controller);
        let (mut solved, pairs) = (0, recording::pairs());
        while solved < pairs {
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
                    solved += 1;
                    info!("pair {} of {}, solved: {}", solved, pairs, pair.outcome.is_ok());
                }
                _ => (),
            }
            // The poll after these events takes a step of the pair.
            let in_a_pass = matches!(event, Event::Frame { .. } | Event::Pass);
            IN_A_PASS.store(in_a_pass, Ordering::Relaxed);
        }
        let interrupted = INTERRUPTED.load(Ordering::Relaxed);
        let applied = app.apply();
        info!("{} interrupts within a pass; applied: {}", interrupted, applied.is_ok());
        if let Ok(calibration) = &applied {
            load_rectifier(calibration);
        }
        exit(applied.is_ok() && interrupted > 0)
    }
}
