//! The hypothesis that is reported, and the watch over it: has the rig moved by less than a single
//! pair can tell?

use nalgebra::Vector5;

use super::Lineage;
use super::filter::{Advance, Filter};
use crate::codec::{Reader, Writer};
use crate::error::{Refusal, RestoreError};
use crate::information::Information;
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::robust::Evidence;
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
    /// What the slope of the pairs of late scatters by: the weights enter twice.
    short_scatter: Information<T>,
    /// Over more of them, about the filter's pose.
    long: Quadratic<T>,
    long_scatter: Information<T>,
    cumulative: T,
    since: u32,
}

impl<T: Scalar> Champion<T> {
    /// Numbers and words in a record.
    pub(super) const NUMBERS: usize = Filter::<T>::NUMBERS + 101;
    pub(super) const WORDS: usize = Filter::<T>::WORDS + 1;

    /// Of nobody yet: to be crowned.
    pub(super) const EMPTY: Self = Self {
        filter: Filter::EMPTY,
        short: Moments::ZERO,
        short_scatter: Information::ZERO,
        long: Quadratic::ZERO,
        long_scatter: Information::ZERO,
        cumulative: T::ZERO,
        since: 0,
    };

    /// Puts a hypothesis in the place of what was there.
    pub(super) fn crown(&mut self, filter: &Filter<T>) {
        self.filter = *filter;
        self.filter.reframe();
        self.begin_watch();
    }

    fn begin_watch(&mut self) {
        self.short = Moments::ZERO;
        self.short_scatter = Information::ZERO;
        self.long = Quadratic::ZERO;
        self.long_scatter = Information::ZERO;
        (self.cumulative, self.since) = (T::ZERO, 0);
    }

    pub(super) fn write(&self, to: &mut Writer<'_>) {
        self.filter.write(to);
        self.short.write(to);
        self.short_scatter.0.write(to);
        self.long.write(to);
        self.long_scatter.0.write(to);
        to.number(self.cumulative);
        to.word(self.since);
    }

    /// In the place of an empty one.
    pub(super) fn read(
        &mut self,
        from: &mut Reader<'_>,
        lineage: &Lineage<T>,
    ) -> Result<(), RestoreError> {
        self.filter.read(from, lineage)?;
        self.short.read(from)?;
        self.short_scatter.0.read(from)?;
        self.long.read(from)?;
        self.long_scatter.0.read(from)?;
        self.cumulative = from.size()?;
        self.since = from.word()?;
        Ok(())
    }

    /// Takes in one more pair; whether the pairs of late speak of another rig.
    ///
    /// * `surprise`: distance of the pair from the estimate, over the scatter of pairs.
    ///
    /// # Errors
    /// [`Refusal`], as [`Filter::next`]; the champion is as it was.
    #[inline(never)]
    pub(super) fn add(
        &mut self,
        evidence: &Evidence<T>,
        surprise: T,
        repeated: bool,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> Result<bool, Refusal> {
        let mut advance = Advance::NONE;
        self.filter.next(evidence, repeated, lineage, allowed, &mut advance)?;
        if !repeated {
            self.short.add(self.filter.last());
            self.short.scale(T::lit(SHORT));
        }
        let moved = self.filter.take(evidence, &advance, repeated, lineage);
        Ok(!repeated && self.watch(evidence, surprise, &moved, lineage))
    }

    /// * `moved`: how the pose has moved.
    #[inline(never)]
    fn watch(
        &mut self,
        evidence: &Evidence<T>,
        surprise: T,
        moved: &Vector5<T>,
        lineage: &Lineage<T>,
    ) -> bool {
        let pair = evidence.seen_at(self.filter.pose());
        let short = self.filter.see(&self.short).plus(&pair);
        let [decay, long_decay] = [T::lit(SHORT), T::lit(LONG)];
        self.long = self.long.about(moved).scaled(long_decay).plus(&pair);
        let scattered = |before: &Information<T>, decay: T| {
            let mut scatter = before.scaled(decay * decay);
            scatter.add(&pair.information);
            scatter
        };
        self.short_scatter = scattered(&self.short_scatter, decay);
        self.long_scatter = scattered(&self.long_scatter, long_decay);
        self.cumulative = (self.cumulative + surprise - T::lit(ALLOWED)).max(T::ZERO);
        self.since = self.since.saturating_add(1);
        self.since >= WARM_UP && self.has_moved(&short, lineage)
    }

    /// Lets the pairs of late replace the older ones; whether they lead to a rig that may be, or else
    /// nothing has changed.
    pub(super) fn renew(
        &mut self,
        lineage: &Lineage<T>,
        allowed: impl Fn(&RectifyingRotations<T>) -> Result<(), Refusal>,
    ) -> bool {
        let pairs = self.since.min(SHORT_PAIRS);
        let renewed = self.filter.replace(&self.short, pairs, lineage, allowed);
        if renewed {
            self.begin_watch();
        }
        renewed
    }

    /// Whether the pairs of late speak of another rig.
    ///
    /// * `short`: over them, about the filter's pose.
    fn has_moved(&self, short: &Quadratic<T>, lineage: &Lineage<T>) -> bool {
        let limit = T::lit(MAX_WINDOW) * self.filter.scatter();
        // Score at the pose, squared, over what it scatters by if that is the rig.
        let far = |window: &Quadratic<T>, scatter: &Information<T>| {
            let mut scatter = scatter.0;
            scatter.add_diagonal(lineage.prior);
            let distance = scatter.inverse_form(&window.gradient);
            distance.is_some_and(|distance| distance > limit)
        };
        far(short, &self.short_scatter)
            || far(&self.long, &self.long_scatter)
            || self.cumulative > T::lit(MAX_SUM)
    }
}
