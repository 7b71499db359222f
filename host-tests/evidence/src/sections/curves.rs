//! Curves over the varied parameters of generated scenes.

use super::labels::label;
use crate::findings::Findings;
use crate::measurement::Measured;
use crate::sweep::{Sweep, SweepAxis, Trials};
use crate::verdict::{self, OURS};
use page::chart::curves::{self, Curve, Line, Scale};
use page::report::{Csv, Entry, Figure, Mark, Picture, Section};
use sim::stats;

/// The errors of a trial.
const PARTS: [&str; 2] = ["e_t, rad", "e_theta, rad"];

/// Axis, whether it is logarithmic, and caption of the figures of a sweep.
fn words(axis: SweepAxis) -> (Scale, &'static str) {
    let (name, log, caption) = match axis {
        SweepAxis::Matches => (
            "matches a pair",
            true,
            "One pair, 0.3 px of noise, no outliers, points 3 to 80 baselines away.",
        ),
        SweepAxis::Noise => (
            "noise of a coordinate, px",
            true,
            "One pair of 256 matches, no outliers, points 3 to 80 baselines away.",
        ),
        SweepAxis::Outliers => (
            "share of outliers",
            false,
            "One pair of 256 matches, 0.3 px of noise, points 3 to 80 baselines away. Half of the \
             outliers are anywhere, half within 60 px and 20 rows of the truth.",
        ),
        SweepAxis::Pairs => (
            "pairs fused",
            true,
            "Pairs of 256 matches, 10 % wrong, 0.3 px of noise, points 3 to 80 baselines away.",
        ),
        SweepAxis::Depth => (
            "nearest point, baselines",
            true,
            "One pair of 256 matches, 10 % wrong, 0.3 px of noise; the farthest point is ten times as \
             far as the nearest. 3: near, 30: far, 300: very far.",
        ),
        SweepAxis::Band => (
            "height of the band with matches, image heights",
            true,
            "One pair of 256 matches, 10 % wrong, 0.3 px of noise, all in a band across the middle of \
             the image.",
        ),
    };
    (Scale { name: name.into(), log }, caption)
}

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Error against matches, noise, outliers, pairs, depth and band");
    section.text(
        "Generated pairs from a rig 5 degrees off about all axes with t 5 degrees off. Curves are root mean \
         squares over the scenes in which a method has an estimate; the scenes are the same for all methods. A \
         curve ends where fewer than half of the scenes have an estimate; a third panel shows the share without \
         one, if any. The dashed black line is the Cramer-Rao bound of the true matches: no unbiased estimate has \
         a smaller error. The best rival is chosen anew at every point. The CSV files have the medians.",
    );
    for sweep in &findings.sweeps {
        section.figure(figure(findings, sweep));
        section.figure(multiples(findings, sweep));
    }
    section
}

/// Names and indices among the variants: ours, all rivals, the paper's method.
fn sides(findings: &Findings<'_>) -> [(&'static str, Vec<usize>, Line); 3] {
    let of = |method| verdict::of_method(findings.few, method);
    [
        ("robust (ours)", of(OURS), Line::Broad),
        ("best rival", verdict::rivals(findings.few), Line::Thin),
        ("paper, best setting", of("paper"), Line::Thin),
    ]
}

/// Each value of the sweep, with the least of a number of the methods `among`.
fn least(
    sweep: &Sweep,
    among: &[usize],
    of: impl Fn(&Measured<Trials>) -> Option<f64>,
) -> Vec<(f64, Option<f64>)> {
    let at =
        |at: usize| among.iter().filter_map(|&i| of(&sweep.trials[i][at])).min_by(f64::total_cmp);
    sweep.values.iter().enumerate().map(|(i, &x)| (x, at(i))).collect()
}

/// Share of the scenes without an estimate.
fn without(trials: &Measured<Trials>) -> Option<f64> {
    let trials = trials.as_ref().ok()?;
    stats::mean(trials.iter().map(|trial| f64::from(u8::from(trial.is_none()))))
}

fn bound(sweep: &Sweep, part: usize) -> Curve {
    let bound = sweep.bound.iter().map(|bound| bound.as_ref().ok().map(|b| b[part]));
    let points = sweep.values.iter().copied().zip(bound).collect();
    Curve { color: None, line: Line::Broken, points }
}

fn legend() -> Vec<Entry> {
    let names = ["robust (ours)", "best rival", "paper, best setting"];
    let entry = |(i, name): (usize, &&str)| Entry::new(Mark::Line, Some(curves::shade(i)), name);
    let bound = Entry::new(Mark::Dashes, None, "Cramer-Rao bound");
    names.iter().enumerate().map(entry).chain([bound]).collect()
}

/// The chart of an error: the bound, and the curves of ours, the best rival and the paper.
fn chart(findings: &Findings<'_>, sweep: &Sweep, part: usize) -> String {
    let sides = sides(findings);
    let curve = |(i, (_, among, line)): (usize, &(_, Vec<usize>, Line))| {
        let points = least(sweep, among, |trials| rms(trials, part));
        Curve { color: Some(curves::shade(i)), line: *line, points }
    };
    // Ours is drawn last, on top.
    let all = sides.iter().enumerate().map(curve).rev();
    let all: Vec<Curve> = [bound(sweep, part)].into_iter().chain(all).collect();
    curves::curves(PARTS[part], &words(sweep.axis).0, &all)
}

/// The chart of `e_t` and its legend.
pub(super) fn of_document(
    findings: &Findings<'_>,
    axis: SweepAxis,
) -> Option<(String, Vec<Entry>)> {
    let sweep = findings.sweeps.iter().find(|sweep| sweep.axis == axis)?;
    Some((chart(findings, sweep, 0), legend()))
}

fn figure(findings: &Findings<'_>, sweep: &Sweep) -> Figure {
    let (x, caption) = words(sweep.axis);
    let panel = |part: usize| {
        let title = format!("{} over {}", PARTS[part], x.name);
        (Picture::Svg(chart(findings, sweep, part)), title)
    };
    let mut panels = vec![panel(0), panel(1)];
    let sides = sides(findings);
    let curve = |(i, (_, among, line)): (usize, &(_, Vec<usize>, Line))| Curve {
        color: Some(curves::shade(i)),
        line: *line,
        points: least(sweep, among, without),
    };
    let shares: Vec<Curve> = sides.iter().enumerate().map(curve).rev().collect();
    let solved =
        shares.iter().flat_map(|curve| &curve.points).all(|(_, share)| *share == Some(0.0));
    if !solved {
        let title = "share of scenes without an estimate";
        let svg = curves::shares(title, &x, &shares);
        panels.push((Picture::Svg(svg), format!("{title} over {}", x.name)));
    }
    let scenes = sweep.trials.iter().flatten().flatten().map(Vec::len).max().unwrap_or(0);
    Figure {
        panels,
        legend: legend(),
        caption: format!(
            "{caption} {scenes} scenes a point: chance alone changes a curve by {:.0} % (1 sd).{} If curves \
             coincide, ours is on top.",
            100.0 * chance(scenes),
            if solved { " All curves have an estimate in every scene." } else { "" },
        ),
        command: findings.request.command.clone(),
        numbers: numbers(findings, sweep, &x.name),
    }
}

/// Small multiples: `e_t` of each rival at its best setting, beside ours and the bound.
fn multiples(findings: &Findings<'_>, sweep: &Sweep) -> Figure {
    let (x, _) = words(sweep.axis);
    let points = |method: &str| {
        least(sweep, &verdict::of_method(findings.few, method), |trials| rms(trials, 0))
    };
    let name = format!("{}_each", sweep.axis.name());
    let mut numbers = Csv::new(&name, &[&x.name, "method", "e_t, rad"]);
    for by in findings.methods {
        for (x, y) in points(by.name()) {
            let y = y.map_or(String::new(), |y| y.to_string());
            numbers.push([x.to_string(), by.name().to_owned(), y]);
        }
    }
    let curve =
        |i, line, name: &str| Curve { color: Some(curves::shade(i)), line, points: points(name) };
    let panel = |name: &str| {
        let all = [curve(1, Line::Thin, name), curve(0, Line::Broad, OURS), bound(sweep, 0)];
        let title = format!("{}: e_t, rad", label(name));
        (Picture::Svg(curves::curves(&title, &x, &all)), title)
    };
    let mut legend = legend();
    legend.splice(1..3, [Entry::new(Mark::Line, Some(curves::shade(1)), "the method named")]);
    let rivals = findings.methods.iter().map(|by| by.name()).filter(|name| *name != OURS);
    Figure {
        panels: rivals.map(panel).collect(),
        legend,
        caption: "The same scenes, one panel a method, at the best of its settings in each point."
            .into(),
        command: findings.request.command.clone(),
        numbers,
    }
}

/// Relative standard error of a root mean square over so many scenes with one degree of freedom each.
fn chance(scenes: usize) -> f64 {
    (0.5 / f64::from(u32::try_from(scenes.max(1)).unwrap_or(u32::MAX))).sqrt()
}

fn numbers(findings: &Findings<'_>, sweep: &Sweep, x: &str) -> Csv {
    let [t, r] = PARTS;
    let [rms_t, rms_r] = [t, r].map(|name| format!("RMS {name}"));
    let [median_t, median_r] = [t, r].map(|name| format!("median {name}"));
    let heading =
        [x, "method", &rms_t, &rms_r, &median_t, &median_r, "trials", "without an estimate"];
    let mut csv = Csv::new(&format!("{}_rad", sweep.axis.name()), &heading);
    let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (by, trials) in findings.few.iter().zip(&sweep.trials) {
        for (value, trials) in sweep.values.iter().zip(trials) {
            let count = trials.as_ref().map_or(0, Vec::len);
            csv.push([
                value.to_string(),
                by.name(),
                text(rms(trials, 0)),
                text(rms(trials, 1)),
                text(stats::median(errors(trials, 0))),
                text(stats::median(errors(trials, 1))),
                count.to_string(),
                (count - errors(trials, 0).len()).to_string(),
            ]);
        }
    }
    for (value, bound) in sweep.values.iter().zip(&sweep.bound) {
        let bound = |part: usize| text(bound.as_ref().ok().map(|bound| bound[part]));
        let empty = String::new;
        let name = "Cramer-Rao bound".to_owned();
        csv.push([value.to_string(), name, bound(0), bound(1), empty(), empty(), empty(), empty()]);
    }
    csv
}

fn errors(trials: &Measured<Trials>, part: usize) -> Vec<f64> {
    trials.iter().flatten().flatten().map(|errors| errors[part]).collect()
}

/// RMS over the trials with an estimate; `None` if fewer than half of the trials have one.
pub(super) fn rms(trials: &Measured<Trials>, part: usize) -> Option<f64> {
    let errors = errors(trials, part);
    if 2 * errors.len() < trials.as_ref().map_or(0, Vec::len) {
        return None;
    }
    stats::rms(errors)
}
