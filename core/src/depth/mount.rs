//! Knowledge of mount yaw and lens beside the sums of the pairs, and its changes.
//!
//! A fused estimate of the rows is one measurement of the sum, from any number of pairs: it is applied to the prior on
//! each read, and becomes part of the prior when its sums are dropped.
//!
//! A knock may be in the sums for many pairs before it is detected. So the lens is learnt from the rows of [`ROWS_LAG`]
//! pairs ago or more, and a later difference of the rows beyond chance is a turn of the mount.

use super::yaw::YawEstimate;
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::{
    LENS_FOUND, REFUTED_FACTORY_YAW, ROWS_LAG, SCENE_YAW_RAD, TURNED_DOUBT, WITNESS_RAD,
    WITNESS_SUPPORT,
};

/// Knowledge of mount yaw and lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MountYaw<T> {
    /// Whether a calibration measured the factory extrinsics. This belongs to the rig: a reset keeps it.
    calibrated: bool,
    /// Part of the mount yaw that rests on the factory calibration alone, 0 to 1.
    claimed: T,
    /// Whether rows have refuted the factory calibration.
    refuted: bool,
    /// Whether the rig has changed before the present sums.
    changed: bool,
    /// Estimate before the sums; `None`: the prior of the configuration.
    known: Option<YawEstimate<T>>,
    /// Measurements by witnesses in agreement with it, one after the other, up to [`WITNESS_SUPPORT`]. After a restart
    /// so many, if there were any.
    support: u8,
    /// Measurements by witnesses that contradict it.
    waiting: Option<Measurements<T>>,
    earlier: EarlierRows<T>,
}

/// Measurements that agree with each other, one after the other: their mean, its variance, and their number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Measurements<T> {
    yaw: T,
    variance: T,
    count: u8,
}

impl<T: Scalar> Measurements<T> {
    /// With one more; `None` where it does not agree.
    fn confirmed(&self, yaw: T, variance: T) -> Option<Self> {
        let total = self.variance + variance;
        let off = yaw - self.yaw;
        (total > T::ZERO && !is_apart(off, total)).then(|| Self {
            yaw: self.yaw + off * (self.variance / total),
            variance: self.variance * variance / total,
            count: self.count.saturating_add(1),
        })
    }
}

/// The rows as they were: every [`ROWS_LAG`] pairs the newer ones become the older ones. Not part of the record.
#[derive(Debug, Clone, Copy, PartialEq)]
struct EarlierRows<T> {
    older: Option<RowsYaw<T>>,
    newer: Option<RowsYaw<T>>,
    /// Pairs since the newer rows.
    pairs: u16,
}

impl<T: Scalar> EarlierRows<T> {
    const NONE: Self = Self { older: None, newer: None, pairs: 0 };
}

/// Effect of a witness's measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Witnessed {
    /// It is part of the estimate.
    Taken,
    /// It contradicts the yaw so far, and waits for others that agree with it.
    Waiting,
}

/// A turn about the factory extrinsics that rows show, rad, and its variance, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowsYaw<T> {
    pub(crate) turn: T,
    pub(crate) variance: T,
}

impl<T: Scalar> MountYaw<T> {
    /// Knowledge of a rig without a factory calibration.
    pub(crate) const UNKNOWN: Self = Self {
        calibrated: false,
        claimed: T::ONE,
        refuted: false,
        changed: false,
        known: None,
        support: 0,
        waiting: None,
        earlier: EarlierRows::NONE,
    };

    /// Knowledge of factory extrinsics that a calibration has measured.
    pub(crate) const CALIBRATED: Self = Self { calibrated: true, ..Self::UNKNOWN };

    /// Forgets the measurements of pairs and witnesses.
    pub(crate) fn reset(&mut self) {
        *self = Self { calibrated: self.calibrated, ..Self::UNKNOWN };
    }

    /// Estimate with the rows of the pairs.
    #[inline(never)]
    pub(crate) fn with_rows(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        let rows = rows.of_scene(context);
        self.before(&rows, context).with_rows(rows.turn, rows.variance)
    }

    /// Part of an error of the rows that the mount yaw takes up, 0 to 1.
    pub(crate) fn gain(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> T {
        let rows = rows.of_scene(context);
        self.before(&rows, context).gain_of_rows(rows.variance)
    }

    /// Estimate before the rows: since the earlier ones the mount has turned by the difference beyond chance.
    fn before(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        match self.earlier.older {
            Some(older) => {
                let then = self.at(&older, context);
                then.turned(then.excess(rows.turn, rows.variance))
            }
            None => self.before_any(rows, context),
        }
    }

    /// Estimate with rows as the first since the prior. After a change of the rig the mount has turned by the
    /// difference from the prior beyond chance.
    fn at(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        self.before_any(rows, context).with_rows(rows.turn, rows.variance)
    }

    fn before_any(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        let prior = self.prior(context);
        if self.changed { prior.turned(prior.excess(rows.turn, rows.variance)) } else { prior }
    }

    /// Notes the rows after a pair is fused, if due.
    pub(crate) fn note(
        &mut self,
        rows: impl FnOnce() -> Option<RowsYaw<T>>,
        context: &Context<'_, T>,
    ) {
        if !(self.has_factory() || self.known.is_some()) {
            return;
        }
        let earlier = &mut self.earlier;
        earlier.pairs = earlier.pairs.saturating_add(1);
        if earlier.pairs >= ROWS_LAG
            && let Some(rows) = rows()
        {
            let newer = Some(rows.of_scene(context));
            *earlier = EarlierRows { older: earlier.newer, newer, pairs: 0 };
        }
    }

    /// After a turn of the mount, earlier measurements by witnesses neither support nor contradict later ones.
    fn forget_witnesses(&mut self) {
        (self.support, self.waiting) = (0, None);
    }

    /// The sums of the pairs are dropped, and the estimate stays: rays may have changed.
    pub(crate) fn forget_pairs(&mut self) {
        self.forget_earlier();
        self.waiting = None;
    }

    /// Forgets the earlier rows.
    fn forget_earlier(&mut self) {
        self.earlier = EarlierRows::NONE;
    }

    /// Estimate before the sums of the pairs.
    fn prior(&self, context: &Context<'_, T>) -> YawEstimate<T> {
        let (factory, lens) = context.yaw_variances();
        let mount = factory.filter(|_| self.has_factory());
        self.known.unwrap_or(YawEstimate::independent(mount, lens))
    }

    /// Reported variance of the mount yaw: until a witness confirms it, the rows' turn may belong to the mount.
    pub(crate) fn reported_variance(&self, of: &YawEstimate<T>) -> T {
        of.var_mount() + self.doubt(of)
    }

    /// Reported standard deviation of the apparent yaw of the lens, rad.
    pub(crate) fn lens_deviation(&self, of: &YawEstimate<T>) -> T {
        (of.var_lens() + self.doubt(of)).sqrt()
    }

    /// Additional variance for the chance that the mount turned before the first pair, and the lens differs.
    fn doubt(&self, of: &YawEstimate<T>) -> T {
        let claimed = self.claimed * of.lens();
        claimed * claimed * (T::ONE + self.claimed * T::lit(TURNED_DOUBT))
    }

    /// Whether a factory calibration holds, or held until the rig changed.
    fn has_factory(&self) -> bool {
        self.calibrated && !self.refuted
    }

    /// Whether nothing has changed the mount since production, as far as is known.
    pub(crate) fn is_as_made(&self) -> bool {
        self.has_factory() && self.known.is_none()
    }

    /// Whether rows refute a factory calibration that nothing has refuted before.
    pub(crate) fn is_refuted(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> bool {
        let squared = self.prior(context).surprise(rows.turn, rows.variance);
        self.is_as_made() && squared > T::lit(REFUTED_FACTORY_YAW)
    }

    /// Marks the factory calibration as refuted: the mount yaw is unknown.
    pub(crate) fn refute(&mut self) {
        self.refuted = true;
        self.forget_earlier();
        self.forget_witnesses();
    }

    /// The rig has changed, and the sums of the rows are dropped. The estimate keeps what they measured, and the lens
    /// stays. If only rows have measured the mount, nothing is kept: the next rows measure the same.
    pub(crate) fn change(&mut self, rows: &RowsYaw<T>, context: &Context<'_, T>) {
        if self.has_factory() || self.known.is_some() {
            let rows = self.earlier.older.or(self.earlier.newer).unwrap_or(rows.of_scene(context));
            self.known = Some(self.at(&rows, context));
            self.changed = true;
            self.forget_earlier();
            self.forget_witnesses();
        }
    }

    /// Adds a measurement of the mount yaw, rad, of a variance, rad^2. `None`, without effect, where the lens would have to be
    /// off by more than three deviations of its prior.
    pub(crate) fn witness(
        &mut self,
        yaw: T,
        variance: T,
        rows: &RowsYaw<T>,
        context: &Context<'_, T>,
    ) -> Option<Witnessed> {
        let rows = rows.of_scene(context);
        let (_, lens) = context.yaw_variances();
        // By the prior of the lens alone: a wrong measurement that was taken must not refuse the right ones after it.
        if is_apart(rows.turn - yaw, lens + rows.variance + variance) {
            return None;
        }
        let before = self.before(&rows, context);
        let contradicts = is_apart(yaw - before.mount(), before.var_mount() + variance);
        let alone = Measurements { yaw, variance, count: 1 };
        let confirmed = self.waiting.take().and_then(|waiting| waiting.confirmed(yaw, variance));
        let found = if contradicts { confirmed.unwrap_or(alone) } else { alone };
        if contradicts && found.count <= self.support.max(1) {
            self.waiting = Some(found);
            return Some(Witnessed::Waiting);
        }
        let before = if contradicts { before.freed() } else { before };
        let support = if contradicts { 0 } else { self.support };
        self.support = support.saturating_add(found.count).min(WITNESS_SUPPORT);
        let least = T::lit(WITNESS_RAD * WITNESS_RAD).min(before.var_mount());
        let after = before.with_mount(found.yaw, found.variance).not_below(least);
        self.claimed = if contradicts {
            T::ZERO
        } else {
            self.claimed * (after.var_mount() / before.var_mount())
        };
        (self.known, self.changed) = (Some(after), false);
        self.forget_earlier();
        Some(Witnessed::Taken)
    }
}

impl<T: Scalar> MountYaw<T> {
    /// Mount yaw before the sums, rad; 0 if nothing has measured it.
    pub(crate) fn known_yaw(&self) -> T {
        self.known.map_or(T::ZERO, |known| known.mount())
    }

    /// The numbers and the flags of a record.
    pub(crate) fn parts(&self) -> ([T; 6], [bool; 3]) {
        let [a, b, c, d, e] = self.known.map_or([T::ZERO; 5], |known| known.numbers());
        ([self.claimed, a, b, c, d, e], [self.refuted, self.changed, self.known.is_some()])
    }

    /// Takes the numbers and flags of a record, each within its range, after a reset; `None` unless they fit together.
    pub(crate) fn resume(
        &mut self,
        [claimed, numbers @ ..]: [T; 6],
        [refuted, changed, is_known]: [bool; 3],
    ) -> Option<()> {
        let known = YawEstimate::of(numbers)?;
        self.known = is_known.then_some(known);
        (self.claimed, self.refuted, self.changed) = (claimed, refuted, changed);
        self.support = if claimed < T::ONE { WITNESS_SUPPORT } else { 0 };
        (is_known || !changed).then_some(())
    }
}

impl<T: Scalar> RowsYaw<T> {
    /// The rows with the scatter from scene to scene added to their variance.
    fn of_scene(self, context: &Context<'_, T>) -> Self {
        let (_, lens) = context.yaw_variances();
        let scene = if lens > T::ZERO { T::lit(SCENE_YAW_RAD * SCENE_YAW_RAD) } else { T::ZERO };
        Self { variance: self.variance + scene, ..self }
    }
}

/// Whether a difference exceeds three deviations. Not `>`: a number that is not finite counts as apart.
fn is_apart<T: Scalar>(off: T, variance: T) -> bool {
    !(off * off <= T::lit(LENS_FOUND * LENS_FOUND) * variance)
}

texts! { Witnessed { Taken = "taken", Waiting = "waiting for others that agree" } }
codes! { Witnessed { Taken = 0, Waiting = 1 } }

#[cfg(test)]
mod tests;
