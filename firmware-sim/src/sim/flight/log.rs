//! Prints a line for every pair that changes the state, verdict or health, for every pair whose verdict is not that it
//! was added, and for every fiftieth pair.

use std::io::Write;

use anyhow::Result;
use firmware_sim::Controller;
use sim::run::Verdict;
use sim::synth::Scenario;
use stereo_selfcal::{Band, Fused, Health, Proposal, Reasons, RestoreError, State};

use super::super::args::FlightArgs;
use super::super::labels;

/// Largest number of pairs between two lines.
const INTERVAL: u32 = 50;

/// Prints the scenario.
pub(super) fn heading(out: &mut impl Write, args: &FlightArgs, scenario: &Scenario) -> Result<()> {
    let scene = &scenario.scene;
    writeln!(out, "Firmware simulation: a generated flight over SPI into the calibrator")?;
    writeln!(
        out,
        "flight     {} pairs of {} matches, {:.0} % outliers, {} px noise; seed {}",
        args.pairs,
        scene.matches,
        100.0 * scene.outliers,
        scene.noise_px,
        args.seed
    )?;
    writeln!(
        out,
        "rig        {} m baseline; knock of {} deg in mid flight, {} deg RMS of vibration",
        args.baseline, args.knock, scenario.disturbance.vibration_deg
    )?;
    writeln!(out, "preset     robust, automatic apply while locked; f32, 1/256 px on the wire\n")?;
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

/// Prints the knock, between the pairs before and after it.
pub(super) fn knock(out: &mut impl Write, degrees: f64) -> Result<()> {
    Ok(writeln!(out, "      -- the right camera is knocked: {degrees} deg --")?)
}

/// Prints a loss of power after a pair.
pub(super) fn power_lost(out: &mut impl Write, pair: u32, in_a_save: bool) -> Result<()> {
    let when = if in_a_save { ", during a save" } else { "" };
    Ok(writeln!(out, "      -- power is lost after pair {pair}{when} --")?)
}

/// Prints the restart after a loss of power.
pub(super) fn resumed(
    out: &mut impl Write,
    resumed: Result<bool, RestoreError>,
    calibrator: &Controller,
) -> Result<()> {
    let pairs = calibrator.proposal().map_or(0, |p| p.pairs);
    let what = match resumed {
        Ok(true) => format!("{pairs} pairs restored from flash"),
        Ok(false) => "flash is empty".into(),
        Err(why) => format!("nothing restored: {why}"),
    };
    Ok(writeln!(out, "      -- power is back: {what} --")?)
}

/// A line is printed when one of these changes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    verdict: Option<Verdict>,
    state: State,
    health: Option<(Band, Reasons)>,
}

/// Prints the lines, and keeps the last one for comparison.
pub(super) struct Log {
    baseline_m: f32,
    last: Option<Key>,
}

impl Log {
    pub(super) fn new(baseline_m: f32) -> Self {
        Self { baseline_m, last: None }
    }

    /// Prints a line if something has changed since the last line, if the pair was received but not added, or if the
    /// number of the pair is a multiple of [`INTERVAL`].
    pub(super) fn note(
        &mut self,
        out: &mut impl Write,
        pair: u32,
        verdict: Option<Verdict>,
        state: State,
        judged: Option<(&Health<f32>, &Proposal<f32>)>,
    ) -> Result<()> {
        let health = judged.map(|(health, _)| health);
        let health_key = health.map(|h| (h.band, h.reasons));
        let key = Key { verdict, state, health: health_key };
        let plain = matches!(verdict, None | Some(Verdict::Accepted(Fused::Added)));
        if self.last == Some(key) && plain && !pair.is_multiple_of(INTERVAL) {
            return Ok(());
        }
        self.last = Some(key);
        write!(out, "{pair:>4}  {:<9}  ", state.to_string())?;
        match judged {
            Some((health, proposal)) => self.health(out, health, proposal)?,
            None => write!(out, "{:<120}  ", "-")?,
        }
        match verdict {
            Some(verdict) => write!(out, "{verdict}")?,
            None => write!(out, "no frame received")?,
        }
        if let Some(doubt) = health.and_then(|h| labels::doubt(h.reasons)) {
            write!(out, "; {doubt}")?;
        }
        Ok(writeln!(out)?)
    }

    fn health(
        &self,
        out: &mut impl Write,
        h: &Health<f32>,
        proposal: &Proposal<f32>,
    ) -> Result<()> {
        let weakest = proposal.weakest().map_or("-".into(), |(direction, sd)| {
            format!("{} {:.4}", labels::direction(direction), sd.to_degrees())
        });
        let [r, t] = [proposal.sd.rotation, proposal.sd.translation].map(f32::to_degrees);
        let errors = h.depth_errors(self.baseline_m);
        let errors = errors.map_or("-".into(), |all| all.map(|m| format!("{m:.3}")).join(" "));
        let rows = format!("{:.3} > {:.3}", h.in_use_px, h.proposed_px);
        write!(
            out,
            "{:<11}  {rows:<15}  {:<9}  {:<15}  {weakest:<11}  {:>3.0} %  {errors:<27}  {:<14}  ",
            labels::band(h.band),
            format!("{} > {}", h.fit_in_use, h.fit_proposed),
            format!("{r:.4} {t:.4}"),
            100.0 * h.coverage,
            labels::arming(h),
        )?;
        Ok(())
    }
}
