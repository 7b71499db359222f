//! The controller's main loop over the recording in its flash. After [`PAIRS_BEFORE_RESET`] pairs a reset simulates a
//! loss of power, and the firmware restores its estimate from the flash store.

use core::time::Duration;

use cortex_m_rt::entry;
use defmt::{error, info, warn};
use defmt_semihosting as _;
use firmware_sim::board::{NorFlash, exit, reset};
use firmware_sim::recording::{self, FRAMES, ReplayBus};
use firmware_sim::{App, CAPACITY, Controller, Event, PairOutcome};
use panic_probe as _;
use static_cell::StaticCell;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::store::{SavePolicy, Store};
use stereo_selfcal::{Cameras, Config, Extrinsics, FactoryCalibration, Verdict};

/// Bounds on the errors of `t` and `R`, rad: about three times the errors of the host's replay.
const BOUND: Deviation<f32> = Deviation { translation: 0.005, rotation: 0.002 };

/// Number of pairs before the loss of power.
const PAIRS_BEFORE_RESET: u32 = 8;

/// Time between two pairs.
const PERIOD: Duration = Duration::from_millis(50);

/// `init_with` constructs the calibrator in place, because a `const` initial value would take as much flash as the
/// calibrator.
static CONTROLLER: StaticCell<Controller> = StaticCell::new();

#[entry]
fn main() -> ! {
    let Ok(FactoryCalibration { cameras, extrinsics: truth, .. }) = recording::factory() else {
        error!("the cameras or extrinsics of the recording are invalid");
        exit(false)
    };
    let pairs = recording::pairs();
    let Some(mut store) = store() else {
        error!("the flash store cannot be opened");
        exit(false)
    };
    let Some(factory) = factory(&mut store, cameras) else {
        error!("no factory calibration in flash");
        exit(false)
    };
    let controller = CONTROLLER.init_with(|| Controller::new(Config::robust(), &factory));
    let bus = ReplayBus::new(FRAMES);
    let resumed = match store.resume(controller) {
        Ok(resumed) => resumed,
        Err(why) => {
            warn!("nothing restored from flash: {}", why);
            false
        }
    };
    let first = if resumed {
        let kept = controller.proposal().map_or(0, |p| p.pairs);
        info!("power is back: {} pairs from flash, {}", kept, controller.state());
        // The matcher sent these frames before the loss of power.
        (0..PAIRS_BEFORE_RESET).for_each(|_| _ = bus.skip_frame());
        PAIRS_BEFORE_RESET
    } else {
        info!("a recording of {} pairs, up to {} matches each", pairs, CAPACITY);
        0
    };
    let mut app = App::new(bus.driver(), controller);
    let mut received = first;
    loop {
        match app.poll() {
            Ok(Event::Idle) => break,
            Ok(Event::Frame { sequence, offered, taken }) => {
                info!("pair {}: {} of {} matches", sequence, taken, offered);
                received += 1;
            }
            Ok(Event::Pair(pair)) => {
                log(&pair);
                keep(&mut store, app.calibrator(), received);
                if !resumed && received == PAIRS_BEFORE_RESET {
                    info!("power is lost");
                    reset()
                }
            }
            Ok(Event::StateChanged { before, after }) => info!("{} -> {}", before, after),
            Ok(_) => (),
            Err(why) => {
                error!("the matcher: {}", why);
                exit(false)
            }
        }
    }
    if received != pairs {
        error!("{} frames were read; the link: {}", received, app.counters());
        exit(false)
    }
    match app.apply() {
        Ok(applied) => exit(is_accurate(&applied.extrinsics, &truth)),
        Err(why) => {
            error!("not applied: {}", why);
            exit(false)
        }
    }
}

/// The store in the board's flash; it saves the estimate at most once per second.
fn store() -> Option<Store<NorFlash, f32>> {
    let policy = SavePolicy::new(Duration::from_secs(1));
    let middle = NorFlash::SIZE / 2;
    Store::open(NorFlash::take()?, 0..middle, middle..NorFlash::SIZE, policy).ok()
}

/// The factory calibration in flash. In place of the production line, the first start saves a guess.
fn factory(
    store: &mut Store<NorFlash, f32>,
    cameras: Cameras<f32>,
) -> Option<FactoryCalibration<f32>> {
    let guess = FactoryCalibration::guess(cameras);
    if store.load_factory() == Ok(None) {
        store.save_factory(&guess).ok()?;
    }
    store.load_factory().ok()?
}

fn keep(store: &mut Store<NorFlash, f32>, controller: &Controller, pairs: u32) {
    match store.save_if_due(controller, PERIOD * pairs) {
        Ok(Some(why)) => info!("  saved: {}", why),
        Ok(None) => (),
        Err(why) => warn!("  not saved: {}", why),
    }
}

fn log(pair: &PairOutcome) {
    match pair.outcome {
        Ok((report, fused)) => {
            let [before, after] = [report.rms_px_before, report.rms_px_after];
            info!(
                "  {} passes, row offset {} px -> {} px: {}",
                report.passes, before, after, fused
            );
        }
        Err(why) => warn!("  not solved: {}", why),
    }
    let Verdict { rows_px, depth_px, coverage, may_arm, .. } = pair.verdict;
    info!(
        "  rows {} px, depth {} px, coverage {}, may arm: {}",
        rows_px, depth_px, coverage, may_arm
    );
}

/// Whether the applied extrinsics are within [`BOUND`] of the true ones.
fn is_accurate(applied: &Extrinsics<f32>, truth: &Extrinsics<f32>) -> bool {
    let error = Deviation::between(applied, truth);
    let accurate = error.translation <= BOUND.translation && error.rotation <= BOUND.rotation;
    info!("R = {}, t = {}", applied.rotation_row_major(), translation(applied));
    info!("applied: error {} rad in t, {} rad in R", error.translation, error.rotation);
    if !accurate {
        error!("the error is above {} rad in t, {} rad in R", BOUND.translation, BOUND.rotation);
    }
    accurate
}

fn translation(extrinsics: &Extrinsics<f32>) -> [f32; 3] {
    let t = extrinsics.translation();
    [t.x, t.y, t.z]
}
