//! The controller's main loop over the recording in its flash. In the middle of it power is lost, and what
//! was learnt until then is taken up again.

use core::time::Duration;

use cortex_m_rt::entry;
use defmt::{error, info, warn};
use defmt_semihosting as _;
use firmware_sim::baked::{self, FRAMES, NAME, PAIRS, Tape};
use firmware_sim::board::{NorFlash, exit, reset};
use firmware_sim::{App, CAPACITY, Controller, Event, PairOutcome, start};
use panic_probe as _;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::store::{Persistence, SavePolicy, Store};

/// Largest errors of `t` and `R` that pass, rad: three times what the host's replay of the set ends at.
const BOUND: Deviation<f32> = Deviation { translation: 0.005, rotation: 0.002 };

/// Pairs after which power is lost.
const BEFORE_THE_BREAK: u32 = 8;

/// Time between two pairs.
const PERIOD: Duration = Duration::from_millis(50);

/// Room for all that is learnt.
const RECORD: usize = Controller::SNAPSHOT_BYTES;

#[entry]
fn main() -> ! {
    let (Ok(cameras), Ok(truth)) = (baked::cameras(), baked::truth()) else {
        error!("the recording is of no stereo rig");
        exit(false)
    };
    let Some(mut persistence) = persistence() else {
        error!("the flash holds no store");
        exit(false)
    };
    let mut buffer = [0; RECORD];
    let mut controller = start(cameras);
    let tape = Tape::new(FRAMES);
    let resumed = match persistence.resume(&mut controller, &mut buffer) {
        Ok(resumed) => resumed,
        Err(why) => {
            warn!("nothing is taken up from flash: {}", why);
            false
        }
    };
    let first = if resumed {
        let pairs = controller.proposal().map_or(0, |p| p.pairs);
        info!("power is back: {} pairs from flash, {}", pairs, controller.state());
        // The matcher has gone on.
        tape.skip_frames(BEFORE_THE_BREAK);
        BEFORE_THE_BREAK
    } else {
        info!("{=str}: {} pairs, room for {} matches each", NAME, PAIRS, CAPACITY);
        0
    };
    let mut app = App::new(tape.driver(), &mut controller);
    let mut taken_in = first;
    loop {
        match app.poll() {
            Ok(Event::Idle) => break,
            Ok(Event::Frame { sequence, offered, taken }) => {
                info!("pair {}: {} of {} matches", sequence, taken, offered);
                taken_in += 1;
            }
            Ok(Event::Pair(pair)) => {
                log(&pair);
                keep(&mut persistence, app.calibrator(), taken_in, &mut buffer);
                if !resumed && taken_in == BEFORE_THE_BREAK {
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
    if taken_in != PAIRS {
        error!("{} frames were read; the link: {}", taken_in, app.counters());
        exit(false)
    }
    match app.apply() {
        Ok(applied) => exit(judge(&applied, &truth)),
        Err(why) => {
            error!("not applied: {}", why);
            exit(false)
        }
    }
}

/// What is learnt goes into the board's flash, once a second at most.
fn persistence() -> Option<Persistence<NorFlash, f32>> {
    let store = Store::open(NorFlash::take()?, 0..NorFlash::SIZE, NorFlash::PAGE).ok()?;
    let policy = SavePolicy::new().with_shortest_interval(Duration::from_secs(1)).ok()?;
    Some(Persistence::new(store, policy))
}

fn keep(
    persistence: &mut Persistence<NorFlash, f32>,
    controller: &Controller,
    pairs: u32,
    buffer: &mut [u8],
) {
    match persistence.save_if_due(controller, PERIOD * pairs, buffer) {
        Ok(Some(why)) => info!("  saved: {}", why),
        Ok(None) => (),
        Err(why) => warn!("  not saved: {}", why),
    }
}

fn log(pair: &PairOutcome) {
    match pair.outcome {
        Ok((report, fused)) => {
            let [before, after] = [report.rms_px_before, report.rms_px_after];
            info!("  {} passes, rows {} px -> {} px: {}", report.passes, before, after, fused);
        }
        Err(why) => warn!("  not solved: {}", why),
    }
    if let Some(health) = pair.health {
        let [used, proposed] = [health.in_use_px, health.proposed_px];
        info!("  rows as in use {} px, as proposed {} px", used, proposed);
    }
}

/// Whether what is in use is what the data set holds for true.
fn judge(applied: &Extrinsics<f32>, truth: &Extrinsics<f32>) -> bool {
    let error = Deviation::between(applied, truth);
    let good = error.translation <= BOUND.translation && error.rotation <= BOUND.rotation;
    info!("R = {}, t = {}", applied.rotation_row_major(), parts(applied));
    info!("applied: off by {} rad in t, {} rad in R", error.translation, error.rotation);
    if !good {
        error!("more than {} rad in t, {} rad in R", BOUND.translation, BOUND.rotation);
    }
    good
}

fn parts(extrinsics: &Extrinsics<f32>) -> [f32; 3] {
    let t = extrinsics.translation();
    [t.x, t.y, t.z]
}
