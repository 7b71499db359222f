//! How far the figure of another campaign may be off by chance.
//!
//! The limit is [`LIMIT`] standard errors of a campaign with as many runs. All tables have 1,974 figures: with other
//! seeds, one of them is beyond the limit by chance in every 8th campaign. The seeds are the same here, so an unchanged
//! estimator repeats every digit, and a changed one is compared over the same scenes.

/// Standard errors beyond which a difference is not chance.
const LIMIT: f64 = 4.0;

/// The standard error of a figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Chance {
    /// None: the figure is of recorded data.
    Exact,
    /// Relative to the figure; figures are compared by their logarithms.
    Relative(f64),
    /// As the figure.
    Absolute(f64),
    /// For a share of so many: binomial, `1 / (2 sqrt(n))` of the arcsine of its root.
    Share(f64),
    /// For a number of events: Poisson, 1/2 of its root.
    Count,
}

fn number(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::INFINITY, f64::from)
}

impl Chance {
    /// For a root mean square of `n` normal numbers: `sqrt(1 / (2 n))`.
    pub(super) fn rms(n: usize) -> Self {
        Self::Relative((0.5 / number(n)).sqrt())
    }

    /// For the median or the 95th percentile of the size of `n` normal numbers: at most `1.2 / sqrt(n)`.
    pub(super) fn quantile(n: usize) -> Self {
        Self::Relative(1.2 / number(n).sqrt())
    }

    /// For the largest of `n` Rayleigh numbers: `0.65 / ln n`, from Gumbel's distribution.
    pub(super) fn worst(n: usize) -> Self {
        Self::Relative(0.65 / number(n.max(2)).ln())
    }

    /// For a mean of `n` squared errors of five degrees of freedom over their covariance: their variance is 10.
    pub(super) fn nees(n: usize) -> Self {
        Self::Absolute((10.0 / number(n)).sqrt())
    }

    /// For a mean over `n` counts whose variance is their mean.
    pub(super) fn mean_count(mean: f64, n: usize) -> Self {
        Self::Absolute((mean / number(n)).sqrt())
    }

    /// Whether a figure differs from the committed one by no more than chance.
    ///
    /// * `rounding`: largest error of the committed figure as it is written.
    pub(super) fn explains(self, committed: f64, measured: f64, rounding: f64) -> bool {
        if committed.is_nan() || measured.is_nan() {
            return committed.is_nan() && measured.is_nan();
        }
        // The nearest number that is written like the committed one.
        let nearest = measured.clamp(committed - rounding, committed + rounding);
        let apart = |of: fn(f64) -> f64| (of(measured) - of(nearest)).abs();
        let same = measured.total_cmp(&nearest).is_eq();
        same || match self {
            Self::Exact => false,
            Self::Relative(sd) => apart(f64::ln) <= LIMIT * sd,
            Self::Absolute(sd) => apart(|x| x) <= LIMIT * sd,
            Self::Share(n) => apart(|p| p.clamp(0.0, 1.0).sqrt().asin()) <= LIMIT / 2.0 / n.sqrt(),
            Self::Count => apart(f64::sqrt) <= LIMIT / 2.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_of_four_standard_errors_are_chance_and_larger_ones_are_not() {
        let cases = [
            (Chance::rms(200), 1.0, [1.2, 0.83], [1.25, 0.8]),
            (Chance::quantile(24), 2.0, [5.0, 0.8], [5.5, 0.7]),
            (Chance::worst(24), 2.0, [4.5, 0.9], [4.6, 0.85]),
            (Chance::nees(200), 5.0, [5.85, 4.15], [5.95, 4.05]),
            (Chance::Share(1000.0), 0.984, [0.995, 0.965], [0.9999, 0.96]),
            (Chance::Share(200.0), 0.0, [0.015, 0.0], [0.025, 0.03]),
            (Chance::Count, 0.0, [4.0, 1.0], [5.0, 6.0]),
            (Chance::mean_count(10.0, 1000), 10.0, [10.3, 9.7], [10.5, 9.5]),
            (Chance::Exact, 3.0, [3.0, 3.0], [3.1, 2.9]),
        ];
        for (chance, committed, same, other) in cases {
            let explains = |measured| chance.explains(committed, measured, 0.0);
            assert!(same.into_iter().all(explains), "{chance:?}");
            assert!(!other.into_iter().any(explains), "{chance:?}");
        }
    }

    #[test]
    fn a_rounded_figure_stands_for_all_that_round_to_it() {
        assert!(Chance::Exact.explains(1.23, 1.2349, 0.005));
        assert!(!Chance::Exact.explains(1.23, 1.236, 0.005));
        assert!(Chance::Exact.explains(f64::NAN, f64::NAN, 0.0));
        assert!(!Chance::Count.explains(f64::NAN, 0.0, 0.0));
    }
}
