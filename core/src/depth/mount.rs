//! Estimate of the yaws of mount and lens, apart from the sums over the pairs, and its updates.
//!
//! The fused row offsets are one measurement of the sum of the two yaws, whatever the number of pairs. Each read
//! applies this measurement to the prior. The measurement becomes part of the prior when the sums over the pairs are
//! dropped; rows that are old enough also become part of it when a witness is taken.
//!
//! A knock may be in the sums for many pairs before it is detected. Therefore the yaw of the lens is learnt only from
//! rows that are at least [`ROWS_LAG`] pairs old, once there are such rows. A later change of the rows beyond chance
//! counts as a turn of the mount.

use super::yaw::YawEstimate;
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::{
    ROWS_LAG, SCENE_YAW_RAD, SIGNIFICANT, TURNED_DOUBT, WITNESS_RAD, WITNESS_SUPPORT,
};

/// Estimate of the yaws of mount and lens, and its evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MountYaw<T> {
    /// Whether a calibration measured the factory extrinsics. This belongs to the rig: a reset keeps it.
    calibrated: bool,
    /// Part of the mount yaw that rests on the factory calibration alone, 0 to 1.
    claimed: T,
    /// Whether rows have refuted the factory calibration.
    refuted: bool,
    /// Whether the rig changed before the present sums began, and no witness has been taken since.
    changed: bool,
    /// Estimate before the present sums; `None` for the prior of the configuration.
    known: Option<YawEstimate<T>>,
    /// Number of witness measurements that agree with the estimate, at most [`WITNESS_SUPPORT`]. After a restart it is
    /// [`WITNESS_SUPPORT`] if a witness was ever taken since the last reset, and 0 otherwise.
    support: u8,
    /// Consecutive witness measurements that contradict the estimate, and wait for others that agree with them.
    waiting: Option<Measurements<T>>,
    earlier: EarlierRows<T>,
}

/// Consecutive measurements that agree with each other: their mean, rad, its variance, rad^2, and their number.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Measurements<T> {
    yaw: T,
    variance: T,
    count: u8,
}

impl<T: Scalar> Measurements<T> {
    /// Returns the measurements with one more; `None` if the new measurement does not agree with them.
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

/// Yaw of the rows at two earlier times. Every [`ROWS_LAG`] pairs the newer value becomes the older one. A record does
/// not contain these values.
#[derive(Debug, Clone, Copy, PartialEq)]
struct EarlierRows<T> {
    older: Option<RowsYaw<T>>,
    newer: Option<RowsYaw<T>>,
    /// Number of pairs since the newer value was noted.
    pairs: u16,
}

impl<T: Scalar> EarlierRows<T> {
    const NONE: Self = Self { older: None, newer: None, pairs: 0 };
}

/// Effect of a witness measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Witnessed {
    /// The measurement is part of the estimate.
    Taken,
    /// The measurement contradicts the present yaw, and waits for further measurements that agree with it.
    Waiting,
}

/// Yaw that the rows show, relative to the factory extrinsics, rad, and its variance, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowsYaw<T> {
    pub(crate) turn: T,
    pub(crate) variance: T,
}

impl<T: Scalar> MountYaw<T> {
    /// State of a rig without a factory calibration.
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

    /// State of a rig whose factory extrinsics a calibration has measured.
    pub(crate) const CALIBRATED: Self = Self { calibrated: true, ..Self::UNKNOWN };

    /// Forgets the measurements of pairs and witnesses.
    pub(crate) fn reset(&mut self) {
        *self = Self { calibrated: self.calibrated, ..Self::UNKNOWN };
    }

    /// Returns the estimate after the rows of the pairs.
    #[inline(never)]
    pub(crate) fn with_rows(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        let rows = rows.of_scene(context);
        self.before(&rows, context).with_rows(rows.turn, rows.variance)
    }

    /// Returns the part of an error of the rows that goes into the mount yaw, 0 to 1.
    pub(crate) fn gain(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> T {
        let rows = rows.of_scene(context);
        self.before(&rows, context).gain_of_rows(rows.variance)
    }

    /// Returns the estimate before the rows. A difference from the earlier rows beyond chance counts as a turn of the
    /// mount.
    fn before(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        match self.earlier.older {
            Some(older) => {
                let then = self.at(&older, context);
                then.turned(then.excess(rows.turn, rows.variance))
            }
            None => self.before_any(rows, context),
        }
    }

    /// Returns the estimate after `rows`, without the earlier rows. After a change of the rig, a difference from the
    /// prior beyond chance counts as a turn of the mount.
    fn at(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        self.before_any(rows, context).with_rows(rows.turn, rows.variance)
    }

    fn before_any(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        let prior = self.prior(context);
        if self.changed { prior.turned(prior.excess(rows.turn, rows.variance)) } else { prior }
    }

    /// Counts a fused pair, and notes the rows every [`ROWS_LAG`] pairs. Does nothing while nothing but rows has
    /// measured the mount.
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

    /// Forgets the witness measurements: after a turn of the mount they neither support nor contradict later ones.
    fn forget_witnesses(&mut self) {
        (self.support, self.waiting) = (0, None);
    }

    /// Forgets the earlier rows and the waiting measurements when the sums over the pairs are dropped, because the rays
    /// may have changed. The estimate stays.
    pub(crate) fn forget_pairs(&mut self) {
        self.forget_earlier();
        self.waiting = None;
    }

    /// Forgets the earlier rows.
    fn forget_earlier(&mut self) {
        self.earlier = EarlierRows::NONE;
    }

    /// Returns the estimate before the sums over the pairs.
    fn prior(&self, context: &Context<'_, T>) -> YawEstimate<T> {
        let (factory, lens) = context.yaw_variances();
        let mount = factory.filter(|_| self.has_factory());
        self.known.unwrap_or(YawEstimate::independent(mount, lens))
    }

    /// Returns the reported variance of the mount yaw, rad^2. It includes [`Self::doubt`]: until a witness confirms the
    /// yaw, the apparent yaw of the lens may be a turn of the mount.
    pub(crate) fn reported_variance(&self, of: &YawEstimate<T>) -> T {
        of.var_mount() + self.doubt(of)
    }

    /// Returns the reported standard deviation of the apparent yaw of the lens, rad.
    pub(crate) fn lens_deviation(&self, of: &YawEstimate<T>) -> T {
        (of.var_lens() + self.doubt(of)).sqrt()
    }

    /// Returns the additional variance, rad^2, for the case that the mount has turned before the first pair, and the
    /// estimate takes this turn for a yaw of the lens.
    fn doubt(&self, of: &YawEstimate<T>) -> T {
        let claimed = self.claimed * of.lens();
        claimed * claimed * (T::ONE + self.claimed * T::lit(TURNED_DOUBT))
    }

    /// Returns whether the estimate starts from a factory calibration that rows have not refuted.
    fn has_factory(&self) -> bool {
        self.calibrated && !self.refuted
    }

    /// Returns whether the mount yaw still rests on the factory calibration alone: so far there was no refutation, no
    /// change of the rig and no witness.
    pub(crate) fn is_as_made(&self) -> bool {
        self.has_factory() && self.known.is_none()
    }

    /// Returns whether the rows refute the factory calibration. Only a mount yaw that rests on the factory calibration
    /// alone can be refuted.
    pub(crate) fn is_refuted(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> bool {
        let squared = self.prior(context).surprise(rows.turn, rows.variance);
        self.is_as_made() && squared > T::lit(SIGNIFICANT * SIGNIFICANT)
    }

    /// Marks the factory calibration as refuted: the mount yaw is unknown.
    pub(crate) fn refute(&mut self) {
        self.refuted = true;
        self.forget_earlier();
        self.forget_witnesses();
    }

    /// Handles a change of the rig, which drops the sums over the pairs. The rows before the change become part of the
    /// estimate. The yaw of the lens stays, and the mount may have turned. If nothing but rows has measured the mount,
    /// nothing is kept, because the next rows measure the sum of the two yaws again.
    pub(crate) fn change(&mut self, rows: &RowsYaw<T>, context: &Context<'_, T>) {
        if self.has_factory() || self.known.is_some() {
            let rows = self.earlier.older.or(self.earlier.newer).unwrap_or(rows.of_scene(context));
            self.known = Some(self.at(&rows, context));
            self.changed = true;
            self.forget_earlier();
            self.forget_witnesses();
        }
    }

    /// Adds a measurement of the mount yaw, rad, with its variance, rad^2. Returns `None`, and changes nothing, if it
    /// implies a yaw of the lens above three standard deviations; these include the prior of the lens and the errors of
    /// rows and measurement.
    pub(crate) fn witness(
        &mut self,
        yaw: T,
        variance: T,
        rows: &RowsYaw<T>,
        context: &Context<'_, T>,
    ) -> Option<Witnessed> {
        let rows = rows.of_scene(context);
        let (_, lens) = context.yaw_variances();
        // The limit depends on the prior of the lens and not on the estimate: a wrong measurement that was taken must
        // not cause the refusal of later right ones.
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
    /// Returns the mount yaw before the sums, rad; 0 if nothing has measured it.
    pub(crate) fn known_yaw(&self) -> T {
        self.known.map_or(T::ZERO, |known| known.mount())
    }

    /// Returns the numbers and the flags of a record.
    pub(crate) fn parts(&self) -> ([T; 6], [bool; 3]) {
        let [a, b, c, d, e] = self.known.map_or([T::ZERO; 5], |known| known.numbers());
        ([self.claimed, a, b, c, d, e], [self.refuted, self.changed, self.known.is_some()])
    }

    /// Takes over the numbers and flags of a record after a reset; returns `None` unless they fit together. The caller
    /// has checked the range of each number.
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
    /// Returns the rows with the scatter from scene to scene added to their variance, unless the lens is exact.
    fn of_scene(self, context: &Context<'_, T>) -> Self {
        let (_, lens) = context.yaw_variances();
        let scene = if lens > T::ZERO { T::lit(SCENE_YAW_RAD * SCENE_YAW_RAD) } else { T::ZERO };
        Self { variance: self.variance + scene, ..self }
    }
}

/// Returns whether a difference exceeds [`SIGNIFICANT`] standard deviations. The comparison is negated, so that a
/// number that is not finite counts as apart.
fn is_apart<T: Scalar>(off: T, variance: T) -> bool {
    !(off * off <= T::lit(SIGNIFICANT * SIGNIFICANT) * variance)
}

texts! { Witnessed { Taken = "taken", Waiting = "waiting for others that agree" } }
codes! { Witnessed { Taken = 0, Waiting = 1 } }

#[cfg(test)]
mod tests;
