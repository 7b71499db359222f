//! Axes that know their ticks: logarithmic, linear, or groups side by side.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// Decades that a logarithmic axis shows at most.
const MAX_DECADES: f64 = 6.0;

/// Below so many decades there are ticks between the powers of ten, and below this more of them.
const FEW_DECADES: f64 = 2.2;
const ONE_DECADE: f64 = 1.0;

/// One direction of a chart.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    /// In logarithms, if logarithmic.
    range: Range<f64>,
    /// Where they stand, and what they say.
    ticks: Vec<(f64, String)>,
    log: bool,
}

impl Axis {
    /// Logarithmic, around all positive values.
    pub(super) fn log(values: impl Iterator<Item = f64>) -> Self {
        let logs = values.filter(|x| *x > 0.0 && x.is_finite()).map(f64::log10);
        let (low, high) = extremes(logs).unwrap_or((-1.0, 0.0));
        let low = low.max(high - MAX_DECADES);
        let margin = (0.06 * (high - low)).max(0.1);
        let range = low - margin..high + margin;
        Self { ticks: log_ticks(&range), range, log: true }
    }

    /// Logarithmic, in whole decades around all positive values: bars begin at a power of ten.
    pub(super) fn decades(values: impl Iterator<Item = f64>) -> Self {
        let Self { range, .. } = Self::log(values);
        let range = range.start.floor()..range.end.ceil();
        Self { ticks: log_ticks(&range), range, log: true }
    }

    /// Linear, around all values.
    pub(super) fn linear(values: impl Iterator<Item = f64>) -> Self {
        let known = extremes(values.filter(|x| x.is_finite())).filter(|(low, high)| low < high);
        let (low, high) = known.unwrap_or((0.0, 1.0));
        let step = nice_step((high - low) / 6.0);
        let margin = 0.03 * (high - low);
        let range = low - margin..high + margin;
        let first = (range.start / step).ceil();
        let ticks = (0..20)
            .map(|i| (first + f64::from(i)) * step)
            .filter(|tick| range.contains(tick))
            .map(|tick| (tick, label(tick)))
            .collect();
        Self { range, ticks, log: false }
    }

    /// Groups, each one wide, their names in the middle.
    pub(super) fn groups(names: &[&str]) -> Self {
        let left = (0_u32..).map(f64::from);
        let ticks: Vec<_> =
            left.zip(names).map(|(left, name)| (left + 0.5, (*name).to_owned())).collect();
        let end = ticks.last().map_or(1.0, |(middle, _)| middle + 0.5);
        Self { range: 0.0..end, ticks, log: false }
    }

    /// The least value shown.
    pub(super) fn floor(&self) -> f64 {
        if self.log { 10_f64.powf(self.range.start) } else { self.range.start }
    }

    /// Whether the value has a place on the axis.
    pub(super) fn shows(&self, value: f64) -> bool {
        value.is_finite() && (!self.log || value > 0.0)
    }
}

/// Powers of ten, with what is between them where there are few.
fn log_ticks(range: &Range<f64>) -> Vec<(f64, String)> {
    let steps: &[f64] = match range.end - range.start {
        decades if decades < ONE_DECADE => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        decades if decades < FEW_DECADES => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    // A hair wider, so that rounding does not lose the ticks at both ends.
    let wide = range.start - 1e-9..range.end + 1e-9;
    (0..20)
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

/// The next of 1, 2, 5, 10 and so on.
fn nice_step(least: f64) -> f64 {
    let decade = 10_f64.powf(least.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * decade);
    steps.into_iter().find(|&step| step >= least).unwrap_or(least)
}

/// Ticks have few digits: what is beyond is rounding.
fn label(tick: f64) -> String {
    format!("{}", (tick * 1e9).round() / 1e9)
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        let value = if self.log { value.log10() } else { *value };
        let Range { start: low, end: high } = self.range;
        let share = ((value.clamp(low, high) - low) / (high - low)).clamp(0.0, 1.0);
        let length = f64::from(end - start);
        #[expect(clippy::cast_possible_truncation, reason = "between start and end")]
        let offset = (share * length).round() as i32;
        start + offset
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(at, _)| *at).collect()
    }

    fn range(&self) -> Range<f64> {
        let Range { start, end } = self.range;
        if self.log { 10_f64.powf(start)..10_f64.powf(end) } else { start..end }
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let here = |(at, _): &&(f64, String)| at.total_cmp(value).is_eq();
        self.ticks.iter().find(here).map_or(String::new(), |(_, label)| label.clone())
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
    fn what_lies_beyond_is_drawn_at_the_border() {
        let axis = Axis::log([0.01, 1.0].into_iter());
        assert_eq!(axis.map(&0.0, (0, 100)), 0);
        assert_eq!(axis.map(&1e9, (0, 100)), 100);
        assert_eq!(axis.map(&0.1, (0, 100)), 50);
    }
}
