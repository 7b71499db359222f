//! Simulates a generated flight, with the true extrinsics of every pair.

mod hardware;
mod io_stats;
mod log;
mod outcome;

use std::io::Write;

use anyhow::{Result, ensure};
use firmware_sim::{App, Controller, PairOutcome};
use page::run::timeline;
use rigs::data::tracked::Track;
use rigs::data::{Match, in_f64, ranges};
use sim::run::{Verdict, progress};
use sim::synth::{
    Disturbance, Motion, Rangefinder, Scenario, ScenarioKind, ScenarioPair, Scene, Witnesses, rig,
};
use sim::wire::Sender;
use stereo_selfcal::depth::{Tracks, Witnessed};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Camera, Cameras, Config, Extrinsics, FactoryCalibration, Intrinsics, Lens, Scalar, State,
};

use super::args::FlightArgs;
use super::polling::poll_until_idle;
use hardware::{Hardware, Power, Profile};
use io_stats::IoStats;
use log::Log;
use outcome::Outcome;

/// Deviation of the assembled rig from the factory extrinsics: `R` about x, y, z, `t` about y, z, degrees.
const ASSEMBLED_DEG: ([f64; 3], [f64; 2]) = ([0.8, -0.5, 0.6], [0.7, -0.4]);

/// Standard deviation of the rangefinder over the distance, and share of its readings that are of something nearer.
const RANGE_SD: f64 = 0.01;
const RANGE_NEARER: f64 = 0.1;

/// Move of the vehicle before every tenth pair.
const MOTION: Motion = Motion { travel: 4.0, turn_deg: 1.0 };

/// Numbers reserved for the tracks of one move, and moves after which the numbers repeat.
const TRACKS: u16 = 512;
const MOVES: u32 = 7;

/// The calibration after one pair of the flight.
struct Moment {
    /// `None` if no frame was received.
    verdict: Option<Verdict>,
    state: State,
    /// Error of the extrinsics in use, rad.
    error: Deviation<f64>,
    /// Reported standard deviation of the estimate, rad.
    sd: Option<Deviation<f64>>,
    /// RMS row offset with the extrinsics in use, px.
    rows_px: Option<f32>,
}

impl Moment {
    fn point(&self) -> timeline::TimelinePoint {
        timeline::TimelinePoint { error: self.error, sd: self.sd, state: self.state }
    }
}

/// Simulates the flight, prints its log and plots it.
///
/// # Errors
/// If a file cannot be written, or the state at the end is not locked.
pub(super) fn run(args: &FlightArgs, out: &mut impl Write) -> Result<()> {
    let scenario = scenario(args)?;
    log::heading(out, args, &scenario)?;
    let result = simulate(&scenario, args, out)?;
    let outcome = Outcome::of(&result.moments, scenario.turned_from());
    writeln!(out, "\n{outcome}")?;
    writeln!(out, "applied            {} times automatically", result.generation)?;
    writeln!(out, "{}", result.io_stats)?;
    let witnesses = [
        ("rangefinder", "readings", args.rangefinder, result.ranges),
        ("motion", "moves", args.motion, result.motions),
    ];
    for (name, what, _, [taken, waiting, refused]) in witnesses.iter().filter(|(.., on, _)| *on) {
        writeln!(out, "{name:19}{taken} {what} taken, {waiting} held back, {refused} refused")?;
    }
    let title = format!(
        "A flight: the right camera is knocked by {}° at pair {}",
        args.knock,
        scenario.turned_from()
    );
    let points: Vec<_> = result.moments.iter().map(Moment::point).collect();
    timeline::write_svg(&args.plot, &title, &points, scenario.turned_from())?;
    writeln!(out, "plot               {}", args.plot.display())?;
    let last = result.moments.last().map_or(State::Acquiring, |moment| moment.state);
    ensure!(last == State::Locked, "the flight ends {last}, not locked");
    Ok(())
}

fn scenario(args: &FlightArgs) -> Result<Scenario> {
    let named = Scenario::new(ScenarioKind::Flight, args.pairs.into());
    let (rotation, baseline) = ASSEMBLED_DEG;
    let scene = Scene { rig: rig(rotation, baseline)?, ..named.scene };
    let baseline_m = args.baseline.into();
    let rangefinder = Rangefinder { baseline_m, sd: RANGE_SD, nearer: RANGE_NEARER };
    let rangefinder = args.rangefinder.then_some(rangefinder);
    let witnesses = Witnesses { rangefinder, motion: args.motion.then_some(MOTION) };
    Ok(Scenario { scene, turn_deg: args.knock, witnesses, ..named })
}

/// Result of a flight.
#[derive(Default)]
struct FlightResult {
    moments: Vec<Moment>,
    /// Number of changes of the extrinsics in use.
    generation: u32,
    io_stats: IoStats,
    /// Readings of the rangefinder that were taken, held back, refused.
    ranges: [u32; 3],
    /// Moves that were taken, held back, refused.
    motions: [u32; 3],
}

fn simulate(scenario: &Scenario, args: &FlightArgs, out: &mut impl Write) -> Result<FlightResult> {
    // The vibration has its own random numbers, so the rest of the flight is the same without it.
    let calm =
        Scenario { disturbance: Disturbance::default(), ..scenario.clone() }.rigs(args.seed)?;
    let profile = if args.faults { Profile::BAD } else { Profile::GOOD };
    let sender = Sender::new(scenario.scene.size, [0.0])?;
    let mut hardware = Hardware::new(profile, sender, args.seed);
    let mut log = Log::default();
    let mut result = FlightResult::default();
    let bar = progress::over(scenario.pairs, "pairs");
    let mut pairs = (0_u32..).zip(scenario.frames(args.seed)?).zip(calm).peekable();
    while pairs.peek().is_some() {
        // One start of the controller, until the power is lost.
        let factory =
            FactoryCalibration::guess(cameras(scenario)?).with_baseline_m(args.baseline)?;
        // A guess confirms no depth, so the flight arms by its rows.
        let config = Config::robust().with_depth_limit_px(f32::INFINITY)?;
        let mut calibrator = Box::new(Controller::new(config, &factory));
        let mut store = hardware.store()?;
        let resumed = store.resume(&mut calibrator);
        if result.io_stats.start(resumed, calibrator.state()) {
            bar.suspend(|| log::resumed(out, resumed, &calibrator))?;
        }
        let mut tracks = Box::new(Tracks::new());
        let mut app = App::new(hardware.driver(), &mut calibrator).applying().tracking(&mut tracks);
        while let Some(((sequence, frame), calm)) = pairs.next() {
            let ScenarioPair { pair, witnessed, .. } = frame;
            let next = pairs.peek().map_or(&[][..], |((_, next), _)| &next.witnessed.tracks);
            hardware.send(sequence, &tracked(sequence, &pair.matches, &witnessed.tracks, next));
            let pair_outcome = poll_until_idle(&mut app)?.map(|processed| processed.pair);
            for reading in witnessed.readings.iter().filter(|_| pair_outcome.is_some()) {
                note(&mut result.ranges, app.push_range(&ranges::in_scalar(reading)).ok());
            }
            if let Some(motion) = pair_outcome.as_ref().and_then(|pair| pair.motion) {
                note(&mut result.motions, motion.ok());
            }
            let calibrator = app.calibrator();
            let judgement = pair_outcome.as_ref().map(|pair| pair.verdict);
            let verdict = pair_outcome.as_ref().map(verdict_of);
            bar.suspend(|| {
                if usize::try_from(sequence)? == scenario.turned_from() {
                    log::knock(out, scenario.turn_deg)?;
                }
                let proposal = calibrator.proposal();
                let judged = judgement.as_ref().zip(proposal.as_ref());
                log.note(out, sequence, verdict, calibrator.state(), judged)
            })?;
            result.record(calibrator, verdict, judgement.as_ref(), &calm);
            bar.inc(1);
            let (power, now) = (hardware.power(), Hardware::now(sequence));
            let kept = match power {
                // A controller that detects the failing supply saves at once.
                Power::Failing => store.save(calibrator, now).map(|()| None),
                _ => store.save_if_due(calibrator, now),
            };
            result.io_stats.note(&kept, calibrator.state());
            if power != Power::On {
                bar.suspend(|| log::power_lost(out, sequence, kept.is_err()))?;
                break;
            }
        }
        result.generation = app.calibrator().in_use().generation;
        result.io_stats.end(app.counters(), hardware.erasures());
        hardware.power_on();
    }
    bar.finish_and_clear();
    Ok(result)
}

/// The matches of a pair with their tracks. The points of a move are in the pair before it too.
///
/// * `own`, `next`: tracks of the moves before this pair and before the next one.
fn tracked(sequence: u32, pair: &[Match], own: &[Track], next: &[Track]) -> Vec<(Match, u16)> {
    let first = |sequence: u32| 1 + TRACKS * u16::try_from(sequence % MOVES).unwrap_or(0);
    // No pair comes before the first.
    let own: &[Track] = if sequence == 0 { &[] } else { own };
    let track = |m: &Match| {
        let mut tracks = own.iter().zip(first(sequence)..);
        tracks.find(|([_, now], _)| now == m).map_or(0, |(_, track)| track)
    };
    let now = pair.iter().map(|m| (*m, track(m)));
    let before = next.iter().map(|[before, _]| *before).zip(first(sequence + 1)..);
    now.chain(before).collect()
}

/// Counts a range or a move.
///
/// * `outcome`: `None` if it was refused.
fn note([taken, waiting, refused]: &mut [u32; 3], outcome: Option<Witnessed>) {
    *match outcome {
        Some(Witnessed::Taken) => taken,
        Some(Witnessed::Waiting) => waiting,
        None => refused,
    } += 1;
}

impl FlightResult {
    /// Records the calibration after a pair, or after a missing one.
    ///
    /// * `calm`: the rig of the pair without its vibration.
    fn record(
        &mut self,
        calibrator: &Controller,
        verdict: Option<Verdict>,
        judgement: Option<&stereo_selfcal::Verdict<f32>>,
        calm: &Extrinsics<f64>,
    ) {
        let proposal = calibrator.proposal();
        let in_use = in_f64(&calibrator.in_use().extrinsics);
        self.moments.push(Moment {
            verdict,
            state: calibrator.state(),
            error: Deviation::between(&in_use, calm),
            sd: proposal.map(|p| Deviation {
                translation: p.sd.translation.to_f64(),
                rotation: p.sd.rotation.to_f64(),
            }),
            rows_px: judgement.map(|judgement| judgement.rows_px),
        });
    }
}

fn verdict_of(pair: &PairOutcome) -> Verdict {
    match pair.outcome {
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

    /// Runs the flight of a command line. Returns its result, the pair of the knock and the log.
    fn flight(arguments: &[&str]) -> (FlightResult, usize, String) {
        let cli = super::super::Cli::parse_from([&["firmware-sim", "flight"], arguments].concat());
        let Some(super::super::Command::Flight(args)) = cli.command else { panic!("no flight") };
        let scenario = scenario(&args).unwrap();
        let mut out = Vec::new();
        let result = simulate(&scenario, &args, &mut out).unwrap();
        (result, scenario.turned_from(), String::from_utf8(out).unwrap())
    }

    #[test]
    fn a_knock_is_detected_at_once_and_followed_within_three_pairs() {
        let (FlightResult { moments, .. }, knock, log) = flight(&["--pairs", "80"]);
        assert!(moments[10..knock].iter().all(|m| m.state == State::Locked), "{log}");
        assert_eq!(moments[knock].state, State::Suspect, "{log}");
        let took_over = |m: &Moment| m.verdict == Some(Verdict::Accepted(Fused::TookOver));
        assert!(moments[knock..knock + 3].iter().any(took_over), "{log}");
        assert!(moments[knock + 3..].iter().all(|m| m.state == State::Locked), "{log}");
        let Moment { error, sd, .. } = moments.last().unwrap();
        let sd = sd.unwrap();
        assert!(error.rotation < 5.0 * sd.rotation, "{error:?} {sd:?}");
        assert!(error.translation < 5.0 * sd.translation, "{error:?} {sd:?}");
    }

    #[test]
    fn with_faults_it_restores_the_estimate_and_ends_locked() {
        let mut total = [0; 4];
        for seed in ["1", "2", "3"] {
            let (FlightResult { moments, io_stats, .. }, _, log) =
                flight(&["--faults", "--seed", seed]);
            let lost = moments.iter().filter(|m| m.verdict.is_none()).count();
            assert!((10..120).contains(&lost), "{lost}: {log}");
            // A start without a restored state would be acquiring again.
            let first_lock = moments.iter().position(|m| m.state == State::Locked).unwrap();
            let forgot = |m: &Moment| m.state == State::Acquiring;
            assert!(!moments[first_lock..].iter().any(forgot), "{log}");
            let Moment { state, error, sd, .. } = moments.last().unwrap();
            let sd = sd.unwrap();
            assert_eq!(*state, State::Locked, "{log}");
            assert!(error.rotation < 5.0 * sd.rotation, "{error:?} {sd:?}");
            assert!(error.translation < 5.0 * sd.translation, "{error:?} {sd:?}");
            let counts = [io_stats.starts, io_stats.resumed, io_stats.torn, io_stats.saves];
            total.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        }
        let [starts, resumed, torn, saves] = total;
        assert!(starts > 10 && resumed > 8 && torn > 2 && saves > 20, "{total:?}");
    }

    #[test]
    fn a_rangefinder_makes_the_predicted_depth_errors_ten_times_smaller_and_near_hits_are_held_back_or_refused()
     {
        let depth_error = |log: &str| -> f64 {
            let line = log.lines().rfind(|line| line.contains("fused")).unwrap();
            assert!(line.contains("yes"), "not armed: {line}");
            line.split_whitespace().nth(3).unwrap().parse().unwrap()
        };
        let (_, _, without) = flight(&["--pairs", "160"]);
        let (FlightResult { ranges: [taken, waiting, refused], moments, .. }, _, with) =
            flight(&["--pairs", "160", "--rangefinder"]);
        assert!(depth_error(&with) < 0.1 * depth_error(&without), "{without}{with}");
        assert!(taken >= 10 && waiting + refused >= 1, "{taken}, {waiting}, {refused}");
        let error = moments.last().unwrap().error.rotation.to_degrees();
        assert!(error < 0.05, "{error}");
    }

    #[test]
    fn tracks_of_the_matcher_tell_the_yaw_as_ranges_do() {
        let (FlightResult { motions: [taken, ..], moments, .. }, _, log) =
            flight(&["--pairs", "160", "--motion"]);
        assert!(taken >= 8, "{taken}: {log}");
        let error = moments.last().unwrap().error.rotation.to_degrees();
        assert!(error < 0.05, "{error}: {log}");
        let (FlightResult { motions, .. }, ..) = flight(&["--pairs", "40"]);
        assert_eq!(motions, [0; 3]);
    }

    #[test]
    fn the_log_has_a_line_for_every_change_and_every_fiftieth_pair() {
        let (FlightResult { moments, .. }, knock, log) = flight(&["--pairs", "60"]);
        let numbers: Vec<usize> =
            log.lines().filter_map(|line| line.get(..4)?.trim().parse().ok()).collect();
        assert!(numbers.contains(&50) && numbers.contains(&knock), "{log}");
        for (i, two) in moments.windows(2).enumerate() {
            assert!(two[0].state == two[1].state || numbers.contains(&(i + 1)), "{i}: {log}");
        }
        assert!(numbers.len() < 25, "{log}");
    }
}
