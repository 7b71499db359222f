//! The controller's main loop over the recording in its flash.

use cortex_m_rt::entry;
use defmt::{error, info, warn};
use defmt_semihosting as _;
use firmware_sim::baked::{self, FRAMES, NAME, PAIRS, Tape};
use firmware_sim::board::exit;
use firmware_sim::{App, CAPACITY, Event, PairOutcome, start};
use panic_probe as _;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::metrics::Deviation;

/// Largest errors of `t` and `R` that pass, rad: three times what the host's replay of the set ends at.
const BOUND: Deviation<f32> = Deviation { translation: 0.005, rotation: 0.002 };

#[entry]
fn main() -> ! {
    let (Ok(cameras), Ok(truth)) = (baked::cameras(), baked::truth()) else {
        error!("the recording is of no stereo rig");
        exit(false)
    };
    info!("{=str}: {} pairs from flash, room for {} matches each", NAME, PAIRS, CAPACITY);
    let mut controller = start(cameras);
    let tape = Tape::new(FRAMES);
    let mut app = App::new(tape.driver(), &mut controller);
    let mut taken_in = 0;
    loop {
        match app.poll() {
            Ok(Event::Idle) => break,
            Ok(Event::Frame { sequence, offered, taken }) => {
                info!("pair {}: {} of {} matches", sequence, taken, offered);
                taken_in += 1;
            }
            Ok(Event::Pair(pair)) => log(&pair),
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
