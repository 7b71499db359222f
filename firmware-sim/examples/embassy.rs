//! Two tasks under Embassy: one awaits the frames of the matcher and solves each pair, pass by pass; the other
//! represents the rest of the firmware and runs between two passes.
//!
//! A timer interrupt simulates the matcher: it takes 64 bytes of the recording in flash at a time. The run
//! succeeds if every pair is received, the other task ran between passes, and the estimate can be applied.
//!
//! `.cargo/for-target thumbv7em-none-eabihf run -p firmware-sim --example embassy --features controller`
#![no_std]
#![no_main]

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use defmt::{error, info};
use defmt_semihosting as _;
use embassy_executor::Spawner;
use embassy_futures::yield_now;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::pipe::Pipe;
use embassy_sync::signal::Signal;
use embedded_hal::{digital, spi};
use embedded_hal_async::digital::Wait;
use embedded_hal_async::spi::{Operation, SpiDevice};
use firmware_sim::Controller;
use firmware_sim::board::interrupts::{Interrupt, enable, interrupt};
use firmware_sim::board::{Timer, exit};
use firmware_sim::recording::{self, FRAMES, ReplayBus};
use panic_probe as _;
use static_cell::StaticCell;
use stereo_selfcal::Calibration;
use stereo_selfcal::link::FpgaMatcher;

/// Size of the queue, bytes: more than two of the longest frames of the recording.
const QUEUE_BYTES: usize = 16_384;

/// Bytes per interrupt.
const CHUNK: usize = 64;

/// Ticks of the timer per interrupt: 20 us, 3.2 MB/s.
const PERIOD: u32 = Timer::HZ / 50_000;

/// Bytes on their way from the interrupt to the driver.
static QUEUE: Pipe<CriticalSectionRawMutex, QUEUE_BYTES> = Pipe::new();

/// Signalled with each chunk, in place of an edge of the data-ready line.
static READY: Signal<CriticalSectionRawMutex, ()> = Signal::new();

/// Whether a pair is being solved, and the number of turns of the other task meanwhile.
static SOLVING: AtomicBool = AtomicBool::new(false);
static TURNS: AtomicU32 = AtomicU32::new(0);

/// The driver's end of the queue, as a bus. A board has an SPI device of its HAL and a pin here.
struct Inbox;

impl spi::ErrorType for Inbox {
    type Error = Infallible;
}

impl SpiDevice for Inbox {
    async fn transaction(
        &mut self,
        operations: &mut [Operation<'_, u8>],
    ) -> Result<(), Infallible> {
        for operation in operations {
            let Operation::Read(buffer) = operation else { continue };
            let mut rest: &mut [u8] = buffer;
            while !rest.is_empty() {
                let count = QUEUE.read(rest).await;
                rest = rest.get_mut(count..).unwrap_or_default();
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for Inbox {
    type Error = Infallible;
}

impl Wait for Inbox {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        while QUEUE.is_empty() {
            READY.wait().await;
        }
        Ok(())
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        while !QUEUE.is_empty() {
            yield_now().await;
        }
        Ok(())
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_low().await?;
        self.wait_for_high().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        self.wait_for_high().await?;
        self.wait_for_low().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        if QUEUE.is_empty() { self.wait_for_high().await } else { self.wait_for_low().await }
    }
}

/// The matcher: enqueues the next bytes if they fit.
#[cortex_m_rt::interrupt]
fn TIMER0() {
    static mut RECORDING: ReplayBus<'static> = ReplayBus::new(FRAMES);
    static mut TIMER: Option<Timer> = None;
    let timer = TIMER.get_or_insert_with(|| Timer::every(PERIOD));
    timer.acknowledge();
    if QUEUE.free_capacity() < CHUNK {
        return;
    }
    // The bytes fit, as checked above.
    let _ = QUEUE.try_write(RECORDING.take(CHUNK));
    READY.signal(());
    if RECORDING.is_at_end() {
        timer.stop();
    }
}

/// Awaits each frame, then solves it. Between two passes the executor may run another task.
#[embassy_executor::task]
async fn calibrate(controller: &'static mut Controller) {
    let mut matcher = FpgaMatcher::new(Inbox, Inbox);
    let pairs = recording::pairs();
    for pair in 1..=pairs {
        if let Err(why) = matcher.receive(controller).await {
            error!("the matcher: {}", why);
            exit(false)
        }
        SOLVING.store(true, Ordering::Relaxed);
        let solved = solve(controller).await;
        SOLVING.store(false, Ordering::Relaxed);
        info!("pair {} of {}, solved and fused: {}", pair, pairs, solved);
    }
    let turns = TURNS.load(Ordering::Relaxed);
    let applied = controller.apply();
    info!("{} turns of the other task within pairs; applied: {}", turns, applied.is_ok());
    if let Ok(calibration) = &applied {
        load_rectifier(calibration);
    }
    exit(applied.is_ok() && turns > 0)
}

/// Stands for the board's rectifier, which loads the calibration in use at the start and each one that is applied.
fn load_rectifier(calibration: &Calibration<f32>) {
    info!("rectifier: generation {}, {}", calibration.generation, calibration.extrinsics);
}

/// Takes the pair, one step a turn; returns whether it was fused.
async fn solve(controller: &mut Controller) -> bool {
    loop {
        if let Some(outcome) = controller.advance_pair() {
            return outcome.fused.is_ok();
        }
        yield_now().await;
    }
}

/// Represents the rest of the firmware.
#[embassy_executor::task]
async fn other() {
    loop {
        if SOLVING.load(Ordering::Relaxed) {
            TURNS.fetch_add(1, Ordering::Relaxed);
        }
        yield_now().await;
    }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    static CONTROLLER: StaticCell<Controller> = StaticCell::new();
    let Ok(factory) = recording::factory() else { exit(false) };
    let controller = CONTROLLER.init_with(|| firmware_sim::start(factory.cameras));
    load_rectifier(&controller.in_use());
    let (Ok(calibrate), Ok(other)) = (calibrate(controller), other()) else { exit(false) };
    spawner.spawn(calibrate);
    spawner.spawn(other);
    // The first interrupt is pended by software and starts the timer.
    enable(Interrupt::TIMER0);
    cortex_m::peripheral::NVIC::pend(Interrupt::TIMER0);
}
