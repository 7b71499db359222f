//! Prints a line for every pair that changes the state, result or reasons, for every pair whose result is not that it
//! was added, and for every fiftieth pair.

use std::io::Write;

use anyhow::Result;
use firmware_sim::Controller;
use sim::run::Verdict;
use sim::synth::Scenario;
use stereo_selfcal::{Fused, Proposal, Reasons, RestoreError, State};

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
    writeln!(
        out,
        "preset     robust, automatic apply while locked, arming by rows alone; f32, 1/256 px on the wire\n"
    )?;
    writeln!(
        out,
        "pair  {:<9}  {:>7}  {:>8}  {:>5}  {:<15}  {:<11}  {:<16}  {:<5}  what",
        "state", "rows px", "depth px", "cover", "sigma deg R, t", "weakest", "arm", "apply"
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
    reasons: Option<Reasons>,
}

/// The calibrator's verdict; [`Verdict`] is the result of a pair.
type Judgement = stereo_selfcal::Verdict<f32>;

/// Prints the lines, and keeps the last one for comparison.
#[derive(Default)]
pub(super) struct Log {
    last: Option<Key>,
}

impl Log {
    /// Prints a line if something has changed since the last line, if the pair was received but not added, or if the
    /// number of the pair is a multiple of [`INTERVAL`].
    pub(super) fn note(
        &mut self,
        out: &mut impl Write,
        pair: u32,
        verdict: Option<Verdict>,
        state: State,
        judged: Option<(&Judgement, &Proposal<f32>)>,
    ) -> Result<()> {
        let reasons = judged.map(|(judgement, _)| judgement.reasons);
        let key = Key { verdict, state, reasons };
        let plain = matches!(verdict, None | Some(Verdict::Accepted(Fused::Added)));
        if self.last == Some(key) && plain && !pair.is_multiple_of(INTERVAL) {
            return Ok(());
        }
        self.last = Some(key);
        write!(out, "{pair:>4}  {:<9}  ", state.to_string())?;
        match judged {
            Some((judgement, proposal)) => judged_as(out, judgement, proposal)?,
            None => write!(out, "{:<79}  ", "-")?,
        }
        match verdict {
            Some(verdict) => write!(out, "{verdict}")?,
            None => write!(out, "no frame received")?,
        }
        if let Some(doubt) = reasons.and_then(labels::doubt) {
            write!(out, "; {doubt}")?;
        }
        Ok(writeln!(out)?)
    }
}

fn judged_as(out: &mut impl Write, judgement: &Judgement, proposal: &Proposal<f32>) -> Result<()> {
    let (direction, sd) = proposal.weakest();
    let weakest = format!("{} {:.4}", labels::direction(direction), sd.to_degrees());
    let [r, t] = [proposal.sd.rotation, proposal.sd.translation].map(f32::to_degrees);
    write!(
        out,
        "{:>7.2}  {:>8.2}  {:>5.2}  {:<15}  {weakest:<11}  {:<16}  {:<5}  ",
        judgement.rows_px,
        judgement.depth_px,
        judgement.coverage,
        format!("{r:.4} {t:.4}"),
        labels::arming(judgement),
        if judgement.should_apply { "yes" } else { "-" },
    )?;
    Ok(())
}
