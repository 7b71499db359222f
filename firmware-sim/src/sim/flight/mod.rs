//! A generated flight in the matcher's place, with the truth of every pair.

mod hardware;
mod log;
mod outcome;
mod service;

use std::io::Write;

use anyhow::{Result, ensure};
use firmware_sim::{App, Controller, PairOutcome};
use host_tests::data::in_f64;
use host_tests::run::{Verdict, progress, timeline};
use host_tests::synth::{Scenario, ScenarioKind, ScenarioPair, Scene, rig};
use host_tests::wire::Sender;
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Camera, Cameras, Extrinsics, Health, Intrinsics, Lens, Scalar, State};

use super::args::FlightArgs;
use super::drive::attend;
use hardware::{Hardware, Power, Profile};
use log::Log;
use outcome::Outcome;
use service::Service;

/// How far the assembled rig is from the factory extrinsics: `R` about x, y, z, `t` about y, z, degrees.
const ASSEMBLED_DEG: ([f64; 3], [f64; 2]) = ([0.8, -0.5, 0.6], [0.7, -0.4]);

/// One pair of the flight, after it.
struct Moment {
    /// `None` where no frame came through.
    became: Option<Verdict>,
    state: State,
    /// Error of what is in use, rad.
    error: Deviation<f64>,
    /// Reported standard deviations of the estimate, rad.
    sd: Option<Deviation<f64>>,
    /// RMS row offset in use, px.
    in_use_px: Option<f32>,
}

/// Flies, prints what happens, and plots it.
///
/// # Errors
/// If a file cannot be written, or the flight does not end locked.
pub(super) fn run(args: &FlightArgs, out: &mut impl Write) -> Result<()> {
    let scenario = scenario(args)?;
    log::heading(out, args, &scenario)?;
    let flown = fly(&scenario, args, out)?;
    let outcome = Outcome::of(&flown.moments, scenario.turned_from());
    writeln!(out, "\n{outcome}")?;
    writeln!(out, "applied            {} times by itself", flown.generation)?;
    writeln!(out, "{}", flown.service)?;
    let title = format!(
        "flight of {} pairs, knock of {} degrees, seed {}",
        args.pairs, args.knock, args.seed
    );
    timeline::write_svg(&args.plot, &title, &flown.timeline, scenario.turned_from())?;
    writeln!(out, "plot               {}", args.plot.display())?;
    let last = flown.moments.last().map_or(State::Acquiring, |moment| moment.state);
    ensure!(last == State::Locked, "the flight ends {last}, not locked");
    Ok(())
}

fn scenario(args: &FlightArgs) -> Result<Scenario> {
    let named = Scenario::new(ScenarioKind::Flight, args.pairs.into());
    let (rotation, baseline) = ASSEMBLED_DEG;
    let scene = Scene { rig: rig(rotation, baseline)?, ..named.scene };
    Ok(Scenario { scene, turn_deg: args.knock, ..named })
}

/// What came of a flight.
#[derive(Default)]
struct Flown {
    moments: Vec<Moment>,
    timeline: Vec<timeline::TimelinePoint>,
    /// Changes of what is in use.
    generation: u32,
    service: Service,
}

fn fly(scenario: &Scenario, args: &FlightArgs, out: &mut impl Write) -> Result<Flown> {
    // Vibration is drawn apart: without it the flight is the same.
    let calm = Scenario { vibration_deg: 0.0, ..scenario.clone() }.rigs(args.seed)?;
    let profile = if args.faults { Profile::BAD } else { Profile::GOOD };
    let sender = Sender::new(scenario.scene.size, [0.0])?;
    let mut hardware = Hardware::new(profile, sender, args.seed);
    let mut log = Log::new(args.baseline);
    let mut flown = Flown::default();
    let mut buffer = [0; Controller::SNAPSHOT_BYTES];
    let bar = progress::over(scenario.pairs, "pairs");
    let mut pairs = (0_u32..).zip(scenario.frames(args.seed)?).zip(calm).peekable();
    while pairs.peek().is_some() {
        // From power on to power off.
        let mut calibrator = Box::new(firmware_sim::start_automatic(cameras(scenario)?));
        let mut persistence = hardware.persistence()?;
        let resumed = persistence.resume(&mut calibrator, &mut buffer);
        if flown.service.begin(&resumed, calibrator.state()) {
            bar.suspend(|| log::resumed(out, &resumed, &calibrator))?;
        }
        let mut app = App::new(hardware.driver(), &mut calibrator);
        for ((sequence, frame), calm) in pairs.by_ref() {
            let ScenarioPair { scene, pair } = frame;
            hardware.send(sequence, &pair.matches);
            let done = attend(&mut app)?.map(|driven| driven.pair);
            let calibrator = app.calibrator();
            let health = done.as_ref().and_then(|done| done.health);
            let became = done.as_ref().map(verdict);
            bar.suspend(|| {
                if usize::try_from(sequence)? == scenario.turned_from() {
                    log::knock(out, scenario.turn_deg)?;
                }
                log.note(out, sequence, became, calibrator.state(), health.as_ref())
            })?;
            flown.note(calibrator, became, health.as_ref(), &scene.rig, &calm);
            bar.inc(1);
            let (power, now) = (hardware.power(), Hardware::now(sequence));
            let kept = match power {
                // What a controller does that sees its supply go down.
                Power::Failing => persistence.save(calibrator, now, &mut buffer).map(|()| None),
                _ => persistence.save_if_due(calibrator, now, &mut buffer),
            };
            flown.service.note(&kept, calibrator.state());
            if power != Power::On {
                bar.suspend(|| log::power_lost(out, sequence, kept.is_err()))?;
                break;
            }
        }
        flown.generation = app.calibrator().generation();
        flown.service.end(app.counters(), persistence.store().wear());
        hardware.power_on();
    }
    bar.finish_and_clear();
    Ok(flown)
}

impl Flown {
    /// After a pair, or where one should have been.
    ///
    /// * `rig`, `calm`: the rig of the pair, with and without its vibration.
    fn note(
        &mut self,
        calibrator: &Controller,
        became: Option<Verdict>,
        health: Option<&Health<f32>>,
        rig: &Extrinsics<f64>,
        calm: &Extrinsics<f64>,
    ) {
        let proposal = calibrator.proposal();
        let in_use = in_f64(calibrator.in_use());
        self.moments.push(Moment {
            became,
            state: calibrator.state(),
            error: Deviation::between(&in_use, calm),
            sd: proposal.map(|p| Deviation {
                translation: p.sd.translation.to_f64(),
                rotation: p.sd.rotation.to_f64(),
            }),
            in_use_px: health.map(|h| h.in_use_px),
        });
        self.timeline.push(timeline::TimelinePoint {
            truth: *rig,
            in_use,
            proposed: proposal.as_ref().map(Into::into),
            state: calibrator.state(),
        });
    }
}

fn verdict(done: &PairOutcome) -> Verdict {
    match done.outcome {
        Ok((_, fused)) => fused.map_or_else(Verdict::Refused, Verdict::Accepted),
        Err(why) => Verdict::Failed(why),
    }
}

/// Both cameras of the scene.
fn cameras(scenario: &Scenario) -> Result<Cameras<f32>> {
    let scene = &scenario.scene;
    let principal = scene.size.map(|n| f32::from(n - 1) / 2.0);
    let focal = [f32::lit(scene.focal); 2];
    let camera = Camera::try_new(Intrinsics { focal, principal, size: scene.size }, Lens::Pinhole)?;
    Ok(Cameras { left: camera, right: camera })
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use stereo_selfcal::Fused;

    /// The flight of the command line, and its log.
    fn flown(arguments: &[&str]) -> (Flown, usize, String) {
        let cli = super::super::Cli::parse_from([&["firmware-sim", "flight"], arguments].concat());
        let Some(super::super::Command::Flight(args)) = cli.command else { panic!("no flight") };
        let scenario = scenario(&args).unwrap();
        let mut out = Vec::new();
        let flown = fly(&scenario, &args, &mut out).unwrap();
        (flown, scenario.turned_from(), String::from_utf8(out).unwrap())
    }

    #[test]
    fn a_knock_is_noticed_at_once_and_the_new_rig_in_use_three_pairs_later() {
        let (Flown { moments, .. }, knock, log) = flown(&["--pairs", "80"]);
        assert!(moments[10..knock].iter().all(|m| m.state == State::Locked), "{log}");
        assert_eq!(moments[knock].state, State::Suspect, "{log}");
        let took_over = |m: &Moment| m.became == Some(Verdict::Accepted(Fused::TookOver));
        assert!(moments[knock..knock + 3].iter().any(took_over), "{log}");
        assert!(moments[knock + 3..].iter().all(|m| m.state == State::Locked), "{log}");
        let Moment { error, sd, .. } = moments.last().unwrap();
        let sd = sd.unwrap();
        assert!(error.rotation < 5.0 * sd.rotation, "{error:?} {sd:?}");
        assert!(error.translation < 5.0 * sd.translation, "{error:?} {sd:?}");
    }

    #[test]
    fn with_faults_everywhere_it_resumes_what_it_had_learnt_and_ends_locked() {
        let mut total = [0; 4];
        for seed in ["1", "2", "3"] {
            let (Flown { moments, service, .. }, _, log) = flown(&["--faults", "--seed", seed]);
            let lost = moments.iter().filter(|m| m.became.is_none()).count();
            assert!((10..120).contains(&lost), "{lost}: {log}");
            // A start that took nothing up would be acquiring again.
            let first_lock = moments.iter().position(|m| m.state == State::Locked).unwrap();
            let forgot = |m: &Moment| m.state == State::Acquiring;
            assert!(!moments[first_lock..].iter().any(forgot), "{log}");
            let Moment { state, error, sd, .. } = moments.last().unwrap();
            let sd = sd.unwrap();
            assert_eq!(*state, State::Locked, "{log}");
            assert!(error.rotation < 5.0 * sd.rotation, "{error:?} {sd:?}");
            assert!(error.translation < 5.0 * sd.translation, "{error:?} {sd:?}");
            let counts = [service.starts, service.resumed, service.torn, service.saves];
            total.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let [starts, resumed, torn, saves] = total;
        assert!(starts > 10 && resumed > 8 && torn > 2 && saves > 20, "{total:?}");
    }

    #[test]
    fn the_log_has_a_line_for_every_change_and_every_fiftieth_pair() {
        let (Flown { moments, .. }, knock, log) = flown(&["--pairs", "60"]);
        let numbers: Vec<usize> =
            log.lines().filter_map(|line| line.get(..4)?.trim().parse().ok()).collect();
        assert!(numbers.contains(&50) && numbers.contains(&knock), "{log}");
        for (i, two) in moments.windows(2).enumerate() {
            assert!(two[0].state == two[1].state || numbers.contains(&(i + 1)), "{i}: {log}");
        }
        assert!(numbers.len() < 25, "{log}");
    }
}
