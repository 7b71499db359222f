//! The states of the calibrator, pair by pair.

use anyhow::Result;
use plotters::prelude::*;
use stereo_selfcal::State;

use crate::chart::palette::{self, SERIES};
use crate::evidence::report::{Entry, Sample};
use crate::run::{Step, Verdict};

const SIZE: (u32, u32) = (640, 120);

/// All states that are drawn, with their colours; none is drawn as nothing.
const STATES: [(State, palette::Color); 4] = [
    (State::Acquiring, SERIES[7]),
    (State::Locked, SERIES[2]),
    (State::Suspect, SERIES[4]),
    (State::Lost, SERIES[1]),
];

/// A strip: a field a pair in the colour of the state after it, a cross over pairs that were not taken in.
pub(super) fn strip(steps: &[Step]) -> Result<String> {
    let count = u32::try_from(steps.len())?;
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        let mut chart = ChartBuilder::on(&root)
            .margin(8)
            .x_label_area_size(48)
            .build_cartesian_2d(0.0..f64::from(count.max(1)), 0.0..1.0)?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_y_axis()
            .x_labels(10)
            .x_label_formatter(&|x| format!("{x:.0}"))
            .x_desc("pairs so far")
            .label_style(("sans-serif", 16))
            .draw()?;
        for (i, step) in (0..count).map(f64::from).zip(steps) {
            let state = step.estimate.map(|estimate| estimate.state);
            let color = STATES.iter().find(|(known, _)| Some(*known) == state);
            if let Some((_, color)) = color {
                let field = [(i, 0.15), (i + 1.0, 1.0)];
                chart.draw_series([Rectangle::new(field, color.light.filled())])?;
            }
            if !matches!(step.verdict, Verdict::Accepted(_)) {
                let cross = Cross::new((i + 0.5, 0.55), 6, BLACK.stroke_width(2));
                chart.draw_series([cross])?;
            }
        }
        root.present()?;
    }
    Ok(svg)
}

/// What the colours stand for.
pub(super) fn legend() -> Vec<Entry> {
    STATES
        .iter()
        .map(|(state, color)| Entry::new(Sample::Bar, Some(*color), &state.to_string()))
        .collect()
}
