//! The hypothesis that is reported, and the watch over it: has the rig moved by less than a single
//! pair can tell?

use nalgebra::Vector5;

use super::Lineage;
use super::filter::Filter;
use crate::information::Information;
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::robust::Judged;
use crate::scalar::Scalar;

/// What is left of a pair in the window after each further one: about 10 and 50 pairs long.
const SHORT: f64 = 0.9;
const LONG: f64 = 0.98;
const SHORT_PAIRS: u32 = 10;

/// A window is not of the champion if its optimum is further away, squared, in units of the scatter:
/// chance is 4e-5 a window.
const MAX_WINDOW: f64 = 28.0;

/// Cumulative sum of the surprises over what chance allows (mean 5, and 4 more a pair), and its limit.
const ALLOWED: f64 = 9.0;
const MAX_SUM: f64 = 60.0;

/// Pairs that the older ones are replaced by, at least.
const WARM_UP: u32 = 4;

/// The reported hypothesis with its watch.
#[derive(Debug, Clone)]
pub(super) struct Champion<T: Scalar> {
    pub(super) filter: Filter<T>,
    /// Over the pairs of late but the last one, and since the watch began, in the filter's frame.
    short: Moments<T>,
    /// Over the pairs of late, about the filter's pose.
    windows: [Window<T>; 2],
    cumulative: T,
    since: u32,
}

impl<T: Scalar> Champion<T> {
    pub(super) fn crowned(filter: Filter<T>) -> Self {
        let windows = [Window::EMPTY; 2];
        Self { filter, short: Moments::ZERO, windows, cumulative: T::ZERO, since: 0 }
    }

    /// With one more pair, and whether the pairs of late had to replace the older ones; `None` if it
    /// leads to no rig.
    pub(super) fn with(
        &self,
        judged: &Judged<T>,
        repeated: bool,
        lineage: &Lineage<T>,
    ) -> Option<(Self, bool)> {
        let filter = self.filter.with(judged, repeated, lineage)?;
        let mut next = Self { filter, ..self.clone() };
        if repeated {
            return Some((next, false));
        }
        next.short.add(self.filter.last());
        next.short = next.short.scaled(T::lit(SHORT));
        let moved = self.filter.pose().unknowns_to(next.filter.pose());
        let pair = judged.evidence.seen_at(next.filter.pose());
        for (window, decay) in next.windows.iter_mut().zip([SHORT, LONG]) {
            window.add(&pair, &moved, T::lit(decay));
        }
        let surprise = self.filter.surprise(judged, lineage).unwrap_or(T::ZERO);
        let excess = surprise / self.filter.scatter() - T::lit(ALLOWED);
        next.cumulative = (self.cumulative + excess).max(T::ZERO);
        next.since = self.since.saturating_add(1);
        if next.since < WARM_UP || !next.has_moved(lineage) {
            return Some((next, false));
        }
        let pairs = next.since.min(SHORT_PAIRS);
        let filter = next.filter.replaced(&next.short, pairs, lineage)?;
        Some((Self::crowned(filter), true))
    }

    /// Whether the pairs of late speak of another rig.
    fn has_moved(&self, lineage: &Lineage<T>) -> bool {
        let limit = T::lit(MAX_WINDOW) * self.filter.scatter();
        let far =
            |window: &Window<T>| window.distance(lineage).is_some_and(|distance| distance > limit);
        self.windows.iter().any(far) || self.cumulative > T::lit(MAX_SUM)
    }
}

/// Sums with falling weights over the pairs of late, about the filter's pose.
#[derive(Debug, Clone, Copy)]
struct Window<T> {
    sum: Quadratic<T>,
    /// What the slope of that sum scatters by: the weights enter twice.
    scatter: Information<T>,
}

impl<T: Scalar> Window<T> {
    const EMPTY: Self = Self { sum: Quadratic::ZERO, scatter: Information::ZERO };

    /// * `moved`: how the pose has moved.
    fn add(&mut self, pair: &Quadratic<T>, moved: &Vector5<T>, decay: T) {
        self.sum = self.sum.about(moved).scaled(decay);
        self.sum.add(pair);
        self.scatter = self.scatter.scaled(decay * decay);
        self.scatter.add(&pair.information);
    }

    /// Score at the pose, squared, over what it scatters by if that is the rig.
    fn distance(&self, lineage: &Lineage<T>) -> Option<T> {
        let score = self.sum.gradient;
        let mut scatter = self.scatter;
        scatter.add(&lineage.prior);
        let whitened = scatter.damped_step(T::ZERO, &score.into())?;
        Some(-whitened.dot(&score))
    }
}
