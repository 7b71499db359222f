//! Curves over the varied parameters of generated scenes.

use super::labels::{label, line};
use crate::chart::curves::{self, Curve, Line, Scale};
use crate::evidence::findings::Findings;
use crate::evidence::measurement::Measured;
use crate::evidence::report::{Csv, Entry, Figure, Picture, Sample, Section};
use crate::evidence::sweep::{Sweep, SweepAxis, Trial};

/// Words of a curve.
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
        "The supplement of the paper. Generated pairs without outliers, from a rig 5 degrees off about \
         all axes with t 5 degrees off: how many pixels the true points, without their noise, lie off \
         their row once rectified by the estimate of one pair, and off their reprojection in each image.",
    );
    let mut sections = vec![noise];
    let mut errors = Section::new("Error against outliers, pairs, depth and band");
    errors.text(
        "The same rig. Curves are root mean squares over the same scenes for all methods, of those in \
         which a method has an estimate; the CSV files have the numbers of failures and the medians. \
         The broken black line is the Cramer-Rao bound of the true matches: no unbiased estimate errs less.",
    );
    for sweep in &findings.sweeps {
        if matches!(sweep.axis, SweepAxis::Matches | SweepAxis::Noise) {
            sections[0].figure(figure(findings, sweep, "px", &OFFSETS));
            sections[0].figure(figure(findings, sweep, "rad", &ERRORS));
        } else {
            errors.figure(figure(findings, sweep, "rad", &ERRORS));
        }
    }
    sections.push(errors);
    sections
}

fn figure(findings: &Findings<'_>, sweep: &Sweep, unit: &str, parts: &[(&str, Of); 2]) -> Figure {
    let words = words(sweep.axis);
    let x = Scale { name: words.x.into(), log: words.log };
    let bounded = unit == "rad";
    let panel = |(part, (y, of)): (usize, &(&str, Of))| {
        let mut curves: Vec<Curve> = findings
            .methods
            .iter()
            .zip(&sweep.trials)
            .map(|(by, trials)| {
                let points = sweep.values.iter().zip(trials).map(|(&x, t)| (x, rms(t, *of)));
                let color = Some(findings.color(by.name()));
                Curve { color, line: line(by.name()), points: points.collect() }
            })
            .collect();
        if bounded {
            let bound = sweep.bound.iter().map(|bound| bound.as_ref().ok().map(|b| b[part]));
            let points = sweep.values.iter().copied().zip(bound).collect();
            curves.push(Curve { color: None, line: Line::Broken, points });
        }
        // Ours on top.
        curves.reverse();
        let svg = curves::curves(y, &x, &curves);
        (Picture::Svg(svg), format!("{y} over {}", words.x))
    };
    let mut legend: Vec<Entry> = findings
        .methods
        .iter()
        .map(|by| Entry::new(Sample::Line, Some(findings.color(by.name())), &label(by.name())))
        .collect();
    if bounded {
        legend.push(Entry::new(Sample::Dashes, None, "Cramer-Rao bound"));
    }
    let scenes = sweep.trials.iter().flatten().flatten().map(Vec::len).max().unwrap_or(0);
    Figure {
        panels: parts.iter().enumerate().map(panel).collect(),
        legend,
        caption: format!(
            "{} {scenes} scenes a point: by chance alone a curve is off by {:.0} % (1 sd). Where curves \
             coincide, ours is on top.",
            words.caption,
            100.0 * chance(scenes),
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

/// Relative standard error of a root mean square over so many scenes, of one degree of freedom each.
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
    for (by, trials) in findings.methods.iter().zip(&sweep.trials) {
        for (value, trials) in sweep.values.iter().zip(trials) {
            let count = trials.as_ref().map_or(0, Vec::len);
            let none = trials.as_ref().map_or(0, |t| t.iter().filter(|t| t.is_none()).count());
            csv.push([
                value.to_string(),
                by.name().to_owned(),
                text(rms(trials, of_a)),
                text(rms(trials, of_b)),
                text(median(trials, of_a)),
                text(median(trials, of_b)),
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

pub(super) fn rms(trials: &Measured<Vec<Option<Trial>>>, of: Of) -> Option<f64> {
    let numbers = numbers_of(trials, of);
    let count = f64::from(u32::try_from(numbers.len()).ok()?);
    let squares: f64 = numbers.iter().map(|x| x * x).sum();
    (count > 0.0).then(|| (squares / count).sqrt())
}

fn median(trials: &Measured<Vec<Option<Trial>>>, of: Of) -> Option<f64> {
    let mut numbers = numbers_of(trials, of);
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}
