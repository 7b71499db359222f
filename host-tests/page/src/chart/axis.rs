//! Axes with ticks: logarithmic, linear, or groups side by side.

use std::ops::Range;

/// Largest number of decades on a logarithmic axis.
const MAX_DECADES: f64 = 6.0;

/// Lengths of an axis, decades: below the first there are ticks between the powers of ten, below the second more ticks.
const FEW_DECADES: f64 = 2.2;
const ONE_DECADE: f64 = 1.0;

/// Least height of a bar above the start of its axis, decades.
const LEAST_BAR: f64 = 0.1;

/// Approximate number of ticks of [`Axis::linear`], and largest number of ticks of a linear axis and of decades with
/// ticks of a logarithmic axis.
const LINEAR_TICKS: f64 = 6.0;
const MOST_TICKS: i32 = 20;

/// Tolerance that keeps the ticks at both ends of a range, in steps or decades.
const ROUNDING: f64 = 1e-9;

/// A horizontal or vertical axis of a chart.
#[derive(Debug, Clone)]
pub struct Axis {
    /// Ends of the axis; their decimal logarithms if the axis is logarithmic.
    range: Range<f64>,
    /// Values and labels.
    ticks: Vec<(f64, String)>,
    log: bool,
}

impl Axis {
    /// Logarithmic, around all positive values, but over at most six decades below the largest, and a margin.
    pub fn log(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = log_extremes(values);
        let margin = (0.06 * (high - low)).max(0.1);
        let range = low - margin..high + margin;
        Self { ticks: log_ticks(&range), range, log: true }
    }

    /// Logarithmic, in whole decades around all positive values that are at most six decades below the largest. The
    /// least value is visibly above the start of the axis, where bars begin.
    pub fn decades(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = log_extremes(values);
        let range = (low - LEAST_BAR).floor()..high.ceil();
        Self { ticks: log_ticks(&range), range, log: true }
    }

    /// Linear, around all values.
    pub fn linear(values: impl Iterator<Item = f64>) -> Self {
        let known = extremes(values.filter(|x| x.is_finite())).filter(|(low, high)| low < high);
        let (low, high) = known.unwrap_or((0.0, 1.0));
        let margin = 0.03 * (high - low);
        let range = low - margin..high + margin;
        let ticks = linear_ticks(&range, (high - low) / LINEAR_TICKS);
        Self { range, ticks, log: false }
    }

    /// Linear, over a range, with about so many ticks.
    pub fn over(range: Range<f64>, ticks: f64) -> Self {
        let ticks = linear_ticks(&range, (range.end - range.start) / ticks);
        Self { range, ticks, log: false }
    }

    /// Groups of width 1, with their names in the middle.
    pub fn groups(names: &[&str]) -> Self {
        let left = (0_u32..).map(f64::from);
        let ticks: Vec<_> =
            left.zip(names).map(|(left, name)| (left + 0.5, (*name).to_owned())).collect();
        let end = ticks.last().map_or(1.0, |(middle, _)| middle + 0.5);
        Self { range: 0.0..end, ticks, log: false }
    }

    /// The least value shown.
    pub fn floor(&self) -> f64 {
        if self.log { 10_f64.powf(self.range.start) } else { self.range.start }
    }

    /// Whether the value can be drawn: finite, and positive on a logarithmic axis.
    pub fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }
}

/// Extremes of the logarithms of all positive values, at most [`MAX_DECADES`] apart.
fn log_extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logs = values.filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
    let (low, high) = extremes(logs).unwrap_or((-1.0, 0.0));
    (low.max(high - MAX_DECADES), high)
}

/// Round numbers within a range, at least `least` apart.
fn linear_ticks(range: &Range<f64>, least: f64) -> Vec<(f64, String)> {
    let step = nice_step(least);
    let first = (range.start / step - ROUNDING).ceil();
    (0..MOST_TICKS)
        .map(|i| (first + f64::from(i)) * step)
        .take_while(|tick| *tick <= range.end + ROUNDING * step)
        .map(|tick| (tick, label(tick)))
        .collect()
}

/// Powers of ten, with steps between them if there are few.
fn log_ticks(range: &Range<f64>) -> Vec<(f64, String)> {
    let steps: &[f64] = match range.end - range.start {
        decades if decades < ONE_DECADE => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        decades if decades < FEW_DECADES => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let wide = range.start - ROUNDING..range.end + ROUNDING;
    (0..MOST_TICKS)
        .map(|i| range.start.floor() + f64::from(i))
        .flat_map(|decade| steps.iter().map(move |step| step * 10_f64.powf(decade)))
        .filter(|tick| wide.contains(&tick.log10()))
        .map(|tick| (tick, label(tick)))
        .collect()
}

fn extremes(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |so_far, x| {
        let (low, high) = so_far.unwrap_or((x, x));
        Some((low.min(x), high.max(x)))
    })
}

/// The least number of the series 1, 2, 5, 10, ... (times any power of ten) that is `least` or more.
fn nice_step(least: f64) -> f64 {
    let decade = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
    steps.into_iter().find(|&step| step >= least).unwrap_or(least)
}

/// Text of a tick, with at most nine decimals; further decimals are rounding errors.
fn label(tick: f64) -> String {
    format!("{}", (tick * 1e9).round() / 1e9)
}

impl Axis {
    /// Position of a value between the ends of the axis, px; a value beyond the range is at the nearer end.
    pub fn place(&self, value: f64, [start, end]: [f64; 2]) -> f64 {
        let value = if self.log { value.log10() } else { value };
        let Range { start: low, end: high } = self.range;
        start + (value.clamp(low, high) - low) / (high - low) * (end - start)
    }

    /// Values of the ticks, and their labels.
    pub fn ticks(&self) -> &[(f64, String)] {
        &self.ticks
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        assert_eq!(labels(&Axis::log([0.0004, 0.3].into_iter())), ["0.001", "0.01", "0.1"]);
        let narrow = Axis::log([0.012, 0.3].into_iter());
        assert_eq!(labels(&narrow), ["0.01", "0.02", "0.05", "0.1", "0.2"]);
        let narrowest = Axis::log([0.0027, 0.0042].into_iter());
        assert_eq!(labels(&narrowest), ["0.003", "0.004", "0.005"]);
        let bars = Axis::decades([0.0027, 0.0042].into_iter());
        assert_eq!(labels(&bars), ["0.001", "0.002", "0.005", "0.01"]);
        let linear = Axis::linear([0.0, 0.6].into_iter());
        assert_eq!(labels(&linear), ["0", "0.1", "0.2", "0.3", "0.4", "0.5", "0.6"]);
        assert_eq!(labels(&Axis::groups(&["top", "left"])), ["top", "left"]);
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "ends and middle of the axis")]
    fn values_beyond_the_axis_are_placed_at_its_ends() {
        let axis = Axis::log([0.01, 1.0].into_iter());
        let places = [0.0, 1e9, 0.1].map(|value| axis.place(value, [0.0, 100.0]));
        assert_eq!(places, [0.0, 100.0, 50.0]);
        let downwards = Axis::over(-1.0..1.0, 4.0);
        assert_eq!(downwards.place(0.5, [100.0, 0.0]), 25.0);
        assert_eq!(labels(&downwards), ["-1", "-0.5", "0", "0.5", "1"]);
    }

    #[test]
    fn a_logarithmic_axis_has_six_decades_at_most_and_one_without_values() {
        let labels_of = |values: [f64; 2]| labels(&Axis::decades(values.into_iter())).join(" ");
        assert_eq!(labels_of([0.002, 4.0]), "0.001 0.01 0.1 1 10");
        assert_eq!(labels_of([1e-12, 0.5]).split(' ').count(), 8);
        assert_eq!(labels_of([0.0, f64::NAN]), "0.01 0.02 0.05 0.1 0.2 0.5 1");
    }

    #[test]
    #[expect(clippy::float_cmp, reason = "whole numbers")]
    fn steps_are_round_numbers() {
        assert_eq!([5.0, 5.1, 19.0, 200.0, 201.0].map(nice_step), [5.0, 10.0, 20.0, 200.0, 500.0]);
    }
}
