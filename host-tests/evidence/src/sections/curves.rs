//! Curves over the varied parameters of generated scenes.

use super::labels::label;
use crate::findings::Findings;
use crate::measurement::Measured;
use crate::sweep::{Sweep, SweepAxis, Trial};
use crate::verdict::{self, OURS};
use page::chart::curves::{self, Curve, Line, Scale};
use page::report::{Csv, Entry, Figure, Mark, Picture, Section};
use sim::stats;

/// Axis and caption of the figures of a sweep.
struct Words {
    x: &'static str,
    log: bool,
    caption: &'static str,
}

/// A number of a trial.
pub(super) type Of = fn(&Trial) -> f64;

const ERRORS: [(&str, Of); 2] = [("e_t, rad", |t| t.e_t), ("e_theta, rad", |t| t.e_theta)];
const OFFSETS: [(&str, Of); 2] =
    [("row offset, px", |t| t.row_px), ("reprojection error, px", |t| t.reprojection_px)];

fn words(axis: SweepAxis) -> Words {
    let (x, log, caption) = match axis {
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
    Words { x, log, caption }
}

pub(super) fn sections(findings: &Findings<'_>) -> Vec<Section> {
    let mut noise = Section::new("Rows and reprojection against matches and noise");
    noise.text(
        "These figures follow the supplement of the paper. Generated pairs without outliers, from a rig 5 \
         degrees off about all axes with t 5 degrees off: distance in px of the true, noise-free points from \
         their row after rectification by the estimate of one pair, and from their reprojection in each image.",
    );
    let mut sections = vec![noise];
    let mut errors = Section::new("Error against outliers, pairs, depth and band");
    errors.text(
        "The same rig. Curves are root mean squares over the scenes in which a method has an estimate; the \
         scenes are the same for all methods. A curve ends where fewer than half of the scenes have an \
         estimate; a third panel shows the share without one, if any. The dashed black line is the Cramer-Rao \
         bound of the true matches: no unbiased estimate has a smaller error. The best rival is chosen anew at \
         every point. The CSV files have the medians.",
    );
    for sweep in &findings.sweeps {
        let place = usize::from(!matches!(sweep.axis, SweepAxis::Matches | SweepAxis::Noise));
        if place == 0 {
            sections[0].figure(figure(findings, sweep, "px", &OFFSETS));
        }
        let all = [&mut sections[0], &mut errors];
        all.into_iter().nth(place).into_iter().for_each(|section| {
            section.figure(figure(findings, sweep, "rad", &ERRORS));
            section.figure(multiples(findings, sweep));
        });
    }
    sections.push(errors);
    sections
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

/// Each value of the sweep, with the least root mean square error of the methods `among`.
fn least(sweep: &Sweep, among: &[usize], of: Of) -> Vec<(f64, Option<f64>)> {
    let at = |at: usize| {
        let all = among.iter().filter_map(|&i| rms(&sweep.trials[i][at], of));
        all.min_by(f64::total_cmp)
    };
    sweep.values.iter().enumerate().map(|(i, &x)| (x, at(i))).collect()
}

/// Each value of the sweep, with the least share of scenes without an estimate of the methods `among`.
fn failures(sweep: &Sweep, among: &[usize]) -> Vec<(f64, Option<f64>)> {
    let share = |trials: &Measured<Vec<Option<Trial>>>| {
        let trials = trials.as_ref().ok()?;
        let [all, none] = [trials.len(), trials.iter().filter(|t| t.is_none()).count()]
            .map(|n| u32::try_from(n).map_or(f64::NAN, f64::from));
        Some(none / all.max(1.0))
    };
    let at = |at: usize| {
        let all = among.iter().filter_map(|&i| share(&sweep.trials[i][at]));
        all.min_by(f64::total_cmp)
    };
    sweep.values.iter().enumerate().map(|(i, &x)| (x, at(i))).collect()
}

fn bound(sweep: &Sweep, part: usize) -> Curve {
    let bound = sweep.bound.iter().map(|bound| bound.as_ref().ok().map(|b| b[part]));
    let points = sweep.values.iter().copied().zip(bound).collect();
    Curve { color: None, line: Line::Broken, points }
}

fn figure(findings: &Findings<'_>, sweep: &Sweep, unit: &str, parts: &[(&str, Of); 2]) -> Figure {
    let words = words(sweep.axis);
    let x = Scale { name: words.x.into(), log: words.log };
    let bounded = unit == "rad";
    let sides = sides(findings);
    let curve = |i: usize, line, points| Curve { color: Some(curves::shade(i)), line, points };
    let panel = |(part, (y, of)): (usize, &(&str, Of))| {
        let numbered = sides.iter().enumerate();
        let mut all: Vec<Curve> = numbered
            .map(|(i, (_, among, line))| curve(i, *line, least(sweep, among, *of)))
            .collect();
        if bounded {
            all.push(bound(sweep, part));
        }
        // Ours is drawn last, on top.
        all.reverse();
        (Picture::Svg(curves::curves(y, &x, &all)), format!("{y} over {}", words.x))
    };
    let mut panels: Vec<(Picture, String)> = parts.iter().enumerate().map(panel).collect();
    let numbered = sides.iter().enumerate().rev();
    let without: Vec<Curve> =
        numbered.map(|(i, (_, among, line))| curve(i, *line, failures(sweep, among))).collect();
    let solved =
        without.iter().flat_map(|curve| &curve.points).all(|(_, share)| *share == Some(0.0));
    if bounded && !solved {
        let title = "share of scenes without an estimate";
        panels.push((
            Picture::Svg(curves::shares(title, &x, &without)),
            format!("{title} over {}", words.x),
        ));
    }
    let numbered = sides.iter().enumerate();
    let entry = |(i, (name, ..)): (usize, &(&str, _, _))| {
        Entry::new(Mark::Line, Some(curves::shade(i)), name)
    };
    let mut legend: Vec<Entry> = numbered.map(entry).collect();
    if bounded {
        legend.push(Entry::new(Mark::Dashes, None, "Cramer-Rao bound"));
    }
    let scenes = sweep.trials.iter().flatten().flatten().map(Vec::len).max().unwrap_or(0);
    Figure {
        panels,
        legend,
        caption: format!(
            "{} {scenes} scenes a point: chance alone changes a curve by {:.0} % (1 sd).{} If curves coincide, \
             ours is on top.",
            words.caption,
            100.0 * chance(scenes),
            if solved { " All curves have an estimate in every scene." } else { "" },
        ),
        command: findings.request.command.clone(),
        numbers: numbers(
            findings,
            sweep,
            &format!("{}_{unit}", sweep.axis.name()),
            words.x,
            parts,
            bounded,
        ),
    }
}

/// Small multiples: `e_t` of each rival at its best setting, beside ours and the bound.
fn multiples(findings: &Findings<'_>, sweep: &Sweep) -> Figure {
    let words = words(sweep.axis);
    let x = Scale { name: words.x.into(), log: words.log };
    let of: Of = |trial| trial.e_t;
    let rivals = findings.methods.iter().map(|by| by.name()).filter(|name| *name != OURS);
    let curve = |i: usize, line, method: &str| {
        let points = least(sweep, &verdict::of_method(findings.few, method), of);
        Curve { color: Some(curves::shade(i)), line, points }
    };
    let mut numbers =
        Csv::new(&format!("{}_each", sweep.axis.name()), &[words.x, "method", "e_t, rad"]);
    for by in findings.methods {
        for (x, y) in least(sweep, &verdict::of_method(findings.few, by.name()), of) {
            let y = y.map_or(String::new(), |y| y.to_string());
            numbers.push([x.to_string(), by.name().to_owned(), y]);
        }
    }
    let panel = |name: &str| {
        let all = [curve(1, Line::Thin, name), curve(0, Line::Broad, OURS), bound(sweep, 0)];
        let title = format!("{}: e_t, rad", label(name));
        (Picture::Svg(curves::curves(&title, &x, &all)), title)
    };
    Figure {
        panels: rivals.map(panel).collect(),
        legend: vec![
            Entry::new(Mark::Line, Some(curves::shade(0)), "robust (ours)"),
            Entry::new(Mark::Line, Some(curves::shade(1)), "the method named"),
            Entry::new(Mark::Dashes, None, "Cramer-Rao bound"),
        ],
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

fn numbers(
    findings: &Findings<'_>,
    sweep: &Sweep,
    name: &str,
    x: &str,
    parts: &[(&str, Of); 2],
    bounded: bool,
) -> Csv {
    let [(a, of_a), (b, of_b)] = *parts;
    let [rms_a, rms_b] = [a, b].map(|name| format!("RMS {name}"));
    let [median_a, median_b] = [a, b].map(|name| format!("median {name}"));
    let heading =
        [x, "method", &rms_a, &rms_b, &median_a, &median_b, "trials", "without an estimate"];
    let mut csv = Csv::new(name, &heading);
    let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for (by, trials) in findings.few.iter().zip(&sweep.trials) {
        for (value, trials) in sweep.values.iter().zip(trials) {
            let count = trials.as_ref().map_or(0, Vec::len);
            let none = trials.as_ref().map_or(0, |t| t.iter().filter(|t| t.is_none()).count());
            csv.push([
                value.to_string(),
                by.name(),
                text(rms(trials, of_a)),
                text(rms(trials, of_b)),
                text(stats::median(numbers_of(trials, of_a))),
                text(stats::median(numbers_of(trials, of_b))),
                count.to_string(),
                none.to_string(),
            ]);
        }
    }
    for (value, bound) in sweep.values.iter().zip(&sweep.bound).filter(|_| bounded) {
        let bound = |part: usize| text(bound.as_ref().ok().map(|bound| bound[part]));
        let empty = String::new;
        let name = "Cramer-Rao bound".to_owned();
        csv.push([value.to_string(), name, bound(0), bound(1), empty(), empty(), empty(), empty()]);
    }
    csv
}

fn numbers_of(trials: &Measured<Vec<Option<Trial>>>, of: Of) -> Vec<f64> {
    trials.iter().flatten().flatten().map(of).collect()
}

/// RMS over the trials with an estimate; `None` if fewer than half of the trials have one.
pub(super) fn rms(trials: &Measured<Vec<Option<Trial>>>, of: Of) -> Option<f64> {
    let numbers = numbers_of(trials, of);
    if 2 * numbers.len() < trials.as_ref().map_or(0, Vec::len) {
        return None;
    }
    stats::rms(numbers)
}
