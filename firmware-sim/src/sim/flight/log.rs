//! A line for every pair that changes something, and for every fiftieth.

use std::io::Write;

use anyhow::Result;
use firmware_sim::Controller;
use host_tests::run::Verdict;
use host_tests::synth::Scenario;
use stereo_selfcal::store::ResumeError;
use stereo_selfcal::{Arming, Band, Doubt, Fused, Health, State};

use super::super::args::FlightArgs;
use super::super::words;

/// Pairs from one line to the next if nothing changes.
const EVERY: u32 = 50;

/// What flies.
pub(super) fn heading(out: &mut impl Write, args: &FlightArgs, scenario: &Scenario) -> Result<()> {
    let scene = &scenario.scene;
    writeln!(out, "Firmware simulation: a generated flight over SPI into the calibrator")?;
    writeln!(
        out,
        "flight     {} pairs of {} matches, {:.0} % of them wrong, {} px noise; seed {}",
        args.pairs,
        scene.matches,
        100.0 * scene.outliers,
        scene.noise_px,
        args.seed
    )?;
    writeln!(
        out,
        "rig        {} m baseline; knock of {} deg in mid flight, {} deg RMS of vibration",
        args.baseline, args.knock, scenario.vibration_deg
    )?;
    writeln!(
        out,
        "preset     robust, applied by itself while locked; f32, 1/256 px on the wire\n"
    )?;
    writeln!(
        out,
        "pair  {:<9}  {:<11}  {:<15}  {:<9}  {:<15}  {:<11}  {:>5}  {:<27}  {:<14}  what",
        "state",
        "band",
        "rows px use>new",
        "fit",
        "sigma deg R, t",
        "weakest",
        "cover",
        "depth error m, 1 2 5 10 m",
        "arm"
    )?;
    Ok(())
}

/// Between the pair before and the pair after.
pub(super) fn knock(out: &mut impl Write, degrees: f64) -> Result<()> {
    Ok(writeln!(out, "      -- the right camera is knocked: {degrees} deg --")?)
}

/// Right after a pair.
pub(super) fn power_lost(out: &mut impl Write, pair: u32, in_a_save: bool) -> Result<()> {
    let when = if in_a_save { ", during a save" } else { "" };
    Ok(writeln!(out, "      -- power is lost after pair {pair}{when} --")?)
}

/// After power has come back.
pub(super) fn resumed<E: std::fmt::Debug>(
    out: &mut impl Write,
    resumed: &Result<bool, ResumeError<E>>,
    calibrator: &Controller,
) -> Result<()> {
    let pairs = calibrator.proposal().map_or(0, |p| p.pairs);
    let what = match resumed {
        Ok(true) => format!("{pairs} pairs are taken up from flash"),
        Ok(false) => "nothing in flash yet".into(),
        Err(why) => format!("nothing is taken up: {why}"),
    };
    Ok(writeln!(out, "      -- power is back: {what} --")?)
}

/// What a line is written about when it changes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    became: Option<Verdict>,
    state: State,
    health: Option<(Band, Arming, Option<Doubt>)>,
}

/// Remembers what was written last.
pub(super) struct Log {
    baseline_m: f32,
    last: Option<Key>,
}

impl Log {
    pub(super) fn new(baseline_m: f32) -> Self {
        Self { baseline_m, last: None }
    }

    /// Writes a line if there is something to say.
    pub(super) fn note(
        &mut self,
        out: &mut impl Write,
        pair: u32,
        became: Option<Verdict>,
        state: State,
        health: Option<&Health<f32>>,
    ) -> Result<()> {
        let health_key = health.map(|h| (h.band, h.arming, h.doubt));
        let key = Key { became, state, health: health_key };
        let plain = matches!(became, None | Some(Verdict::Accepted(Fused::Added)));
        if self.last == Some(key) && plain && !pair.is_multiple_of(EVERY) {
            return Ok(());
        }
        self.last = Some(key);
        write!(out, "{pair:>4}  {:<9}  ", state.to_string())?;
        match health {
            Some(h) => self.health(out, h)?,
            None => write!(out, "{:<120}  ", "-")?,
        }
        match became {
            Some(became) => write!(out, "{became}")?,
            None => write!(out, "no frame came through")?,
        }
        if let Some(doubt) = health.and_then(|h| h.doubt) {
            write!(out, "; {}", words::doubt(doubt))?;
        }
        Ok(writeln!(out)?)
    }

    fn health(&self, out: &mut impl Write, h: &Health<f32>) -> Result<()> {
        let weakest = h.weakest.map_or("-".into(), |(direction, sd)| {
            format!("{} {:.4}", words::direction(direction), sd.to_degrees())
        });
        let [r, t] = [h.sd.rotation, h.sd.translation].map(f32::to_degrees);
        let errors = h.depth_errors(self.baseline_m);
        let errors = errors.map_or("-".into(), |all| all.map(|m| format!("{m:.3}")).join(" "));
        let rows = format!("{:.3} > {:.3}", h.in_use_px, h.proposed_px);
        write!(
            out,
            "{:<11}  {rows:<15}  {:<9}  {:<15}  {weakest:<11}  {:>3.0} %  {errors:<27}  {:<14}  ",
            words::band(h.band),
            format!("{} > {}", h.fit_in_use, h.fit_proposed),
            format!("{r:.4} {t:.4}"),
            100.0 * h.coverage,
            words::arming(h.arming),
        )?;
        Ok(())
    }
}
