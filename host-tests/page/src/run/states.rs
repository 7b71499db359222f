//! The states of the calibrator, pair by pair.

use stereo_selfcal::State;

use crate::chart::palette::{self, Rgb, SERIES};
use crate::chart::{Axis, Plot, Point, Style, Svg};
use crate::report::{Entry, Mark};
use sim::run::{Step, Verdict};

const SIZE: Point = [640.0, 120.0];

/// All drawn states with their colours; other states are not drawn.
pub(super) const STATES: [(State, palette::Color); 4] = [
    (State::Acquiring, SERIES[7]),
    (State::Locked, SERIES[2]),
    (State::Suspect, SERIES[4]),
    (State::Lost, SERIES[1]),
];

/// A strip: for each pair a field in the colour of the state after it, with a cross over pairs that were not fused.
pub(super) fn strip(steps: &[Step]) -> String {
    let count = u32::try_from(steps.len()).unwrap_or(u32::MAX);
    let mut svg = Svg::new(SIZE);
    let axes = [Axis::over(0.0..f64::from(count.max(1)), 10.0), Axis::over(0.0..1.0, 1.0)];
    let mut plot = Plot::new(&mut svg, [[8.0, 8.0], [SIZE[0] - 8.0, SIZE[1] - 56.0]], axes);
    for (i, step) in (0..count).map(f64::from).zip(steps) {
        let state = step.estimate.map(|estimate| estimate.state);
        let color = STATES.iter().find(|(known, _)| Some(*known) == state);
        if let Some((_, color)) = color {
            plot.rectangle([[i, 0.15], [i + 1.0, 1.0]], Style::filled(color.light));
        }
        if !matches!(step.verdict, Verdict::Accepted(_)) {
            plot.cross([i + 0.5, 0.55], 6.0, Style::line(Rgb::BLACK, 2.0));
        }
    }
    plot.label_x("pairs so far", 13.0);
    svg.finish()
}

/// Legend of the colours.
pub(super) fn legend() -> Vec<Entry> {
    STATES
        .iter()
        .map(|(state, color)| Entry::new(Mark::Bars, Some(*color), &state.to_string()))
        .collect()
}
