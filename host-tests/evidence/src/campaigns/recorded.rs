//! Campaign of the recorded data sets. Its cases are arguments of `selfcal replay`.

use anyhow::Result;
use rigs::data::{Dataset, TurnedView};
use sim::run::{LensTracking, Method, Start, replay};
use stereo_selfcal::Config;
use stereo_selfcal::paper::Settings;

use super::chance::Chance;
use super::figures::{Figure, count};
use super::{Campaign, Measure, Request, Row};

/// Angle of the turned view, degrees.
const TURN_DEG: f64 = 5.0;

/// Data sets, and whether the left view is turned up.
const SETS: [(&str, bool); 6] = [
    ("opencv_chess_corners", false),
    ("opencv_chess_sift", false),
    ("opencv_chess_sift", true),
    ("motorcycle_sift", true),
    ("aloe_sift", true),
    ("oak_sift", false),
];

const COLUMNS: &str =
    "pairs, accepted, locked, e_t, e_R, sd t, sd R, rows before px, rows after px";

pub(super) fn campaigns() -> Vec<Campaign> {
    let (lens, measure) = (LensTracking::Report, Measure::Rows(rows));
    vec![Campaign {
        name: "recorded",
        trials: 1,
        seeds: &[0],
        lens,
        columns: COLUMNS,
        quick: Some(""),
        worst_first: None,
        measure,
        chart: None,
    }]
}

fn rows(request: &Request) -> Result<Vec<Row>> {
    let presets: [(_, Method); 2] =
        [("robust", Config::robust().into()), ("paper", Settings::DEFAULT.into())];
    let all = SETS
        .iter()
        .flat_map(|set| presets.map(|(name, preset)| (*set, format!("--preset {name}"), preset)));
    let compensated = LensTracking::Compensate.config().into();
    let compensated = (("oak_sift", false), "--lens compensate".to_owned(), compensated);
    let mut rows = Vec::new();
    for ((set, turned), options, method) in all.chain([compensated]) {
        let view = if turned { " --view top" } else { "" };
        let case = format!("{set}{view} {options}");
        if request.takes(&case) {
            rows.push(Row { figures: figures(set, turned, method)?, case });
        }
    }
    Ok(rows)
}

fn figures(name: &str, turned: bool, method: Method) -> Result<Vec<Figure>> {
    let set = Dataset::load(&Dataset::shipped().join(name))?;
    let set = if turned { TurnedView::Top.turn(&set, TURN_DEG)? } else { set };
    let run = replay::<f32>(&set, method, Start::usual(&set.meta)?, |_| ())?;
    let summary = run.summary(&set)?;
    let locked = f64::from(u8::from(summary.state.starts_with("locked")));
    let values = [
        Some(count(summary.pairs)),
        Some(count(summary.accepted)),
        Some(locked),
        summary.e_t,
        summary.e_theta,
        summary.sd_translation,
        summary.sd_rotation,
        summary.rms_px_before,
        summary.rms_px_after,
    ];
    let figure = |(name, value): (&'static str, Option<f64>)| Figure {
        name,
        value: value.unwrap_or(f64::NAN),
        chance: Chance::Exact,
    };
    Ok(COLUMNS.split(", ").zip(values).map(figure).collect())
}
