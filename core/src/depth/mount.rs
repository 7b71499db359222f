//! Yaws of mount and lens: what a factory calibration, pairs and witnesses tell of them, apart from the sums over the
//! pairs.
//!
//! The pairs are added one by one, each with the yaw of its own optimum, to a [`Bank`] that starts from the factory
//! calibration or from the first witness. Before there is either, the rows give the yaw of the mount.

use super::bank::Bank;
use super::scatter::Scatter;
use super::yaw::{Measured, RowsYaw, YawEstimate};
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::{SCENE_YAW_RAD, SIGNIFICANT, TURNED_DOUBT, WITNESS_RAD, WITNESS_SUPPORT};

/// Estimate of the yaws of mount and lens, and its evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MountYaw<T> {
    /// Whether a calibration measured the factory extrinsics. This belongs to the rig: a reset keeps it.
    calibrated: bool,
    /// Part of the mount yaw that rests on the factory calibration alone, 0 to 1.
    claimed: T,
    /// Estimate after the pairs so far; `None` before the first one, and while nothing but rows has measured the mount.
    bank: Option<Bank<T>>,
    /// Scatter of the pairs that the bank has added.
    scatter: Scatter<T>,
    /// Number of witness measurements that agree with the estimate, at most [`WITNESS_SUPPORT`]. After a restart it is
    /// [`WITNESS_SUPPORT`] if a witness was ever taken since the last reset, and 0 otherwise.
    support: u8,
    /// Consecutive witness measurements that contradict the estimate, and wait for others that agree with them.
    waiting: Option<Measurements<T>>,
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

/// Yaws of mount and lens as they are reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ReportedYaw<T> {
    /// Yaw of the mount relative to the factory extrinsics, rad; `None` if it is the yaw of the rows.
    pub(crate) mount: Option<T>,
    /// Variance of the yaw of the mount, rad^2.
    pub(crate) variance: T,
    /// Apparent yaw `o` of the lens, rad: rows are off by `o x y` at unit depth.
    pub(crate) lens: T,
    /// Standard deviation of the apparent yaw, rad.
    pub(crate) lens_sd: T,
    /// Variance of the yaw of the rows while the mount rests, rad^2: chance in a turn of the mount.
    var_at_rest: T,
}

impl<T: Scalar> ReportedYaw<T> {
    /// Returns whether the pairs have shown a turn of the mount, beyond chance, from a yaw that was estimated before,
    /// rad.
    pub(crate) fn has_turned_from(&self, yaw: T) -> bool {
        let chance = self.var_at_rest + self.var_at_rest;
        self.mount.is_some_and(|mount| (mount - yaw) * (mount - yaw) > chance)
    }
}

impl<T: Scalar> MountYaw<T> {
    /// Returns the state before any pair.
    ///
    /// * `calibrated`: whether a calibration measured the factory extrinsics.
    pub(crate) const fn new(calibrated: bool) -> Self {
        Self {
            calibrated,
            claimed: T::ONE,
            bank: None,
            scatter: Scatter::new(),
            support: 0,
            waiting: None,
        }
    }

    /// Returns whether a calibration measured the factory extrinsics.
    pub(crate) fn is_calibrated(&self) -> bool {
        self.calibrated
    }

    /// Forgets the measurements of pairs and witnesses.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.calibrated);
    }

    /// Adds the yaw of one more pair. Does nothing while nothing but rows has measured the mount.
    ///
    /// * `pair`: yaw of the pair alone, with the variance of its noise.
    pub(crate) fn add(&mut self, pair: &RowsYaw<T>, context: &Context<'_, T>) {
        let (_, var_lens) = context.yaw_variances();
        // The scatter of the pairs contains that of the scenes.
        let least = scene_variance(context);
        let scatter = self.scatter.variance(least).max(context.vibration.rotation);
        let (turn, variance) = (pair.turn, pair.variance + scatter);
        if !(turn.is_finite() && variance > T::ZERO && variance.is_finite()) {
            return;
        }
        let bank = match (self.bank, self.factory(context)) {
            (Some(mut bank), _) => {
                bank.add_rows(turn, variance);
                bank
            }
            (None, Some(made)) => Bank::at_rest(made.with(Measured::Rows, turn, variance)),
            (None, None) => return,
        };
        self.scatter.add(pair, least);
        // No lens has such a yaw: the mount has turned since its yaw was measured.
        let is_refuted = is_apart(bank.estimate().lens(), var_lens);
        self.bank = (!is_refuted).then_some(bank);
        if is_refuted {
            (self.claimed, self.support, self.waiting) = (T::ZERO, 0, None);
        }
    }

    /// Returns whether the estimate contains no pair yet; then the first yaw to add belongs to all pairs so far. `None`
    /// while nothing but rows has measured the mount, and no yaw is to be added.
    pub(crate) fn begins(&self, context: &Context<'_, T>) -> Option<bool> {
        let begins = self.bank.is_none();
        (!begins || self.factory(context).is_some()).then_some(begins)
    }

    /// Keeps the yaw of the mount for rays that are corrected for another lens: its apparent yaw is unknown.
    pub(crate) fn change_lens(&mut self, context: &Context<'_, T>) {
        let (_, var_lens) = context.yaw_variances();
        (self.waiting, self.scatter) = (None, Scatter::new());
        let Some(bank) = &mut self.bank else { return };
        let known = bank.estimate();
        // The next pair shows the new lens, and no turn of the mount.
        *bank = Bank::at_rest(YawEstimate::of_mount(known.mount(), known.var_mount(), var_lens));
    }

    /// Returns the estimate from the factory calibration alone; `None` without one.
    fn factory(&self, context: &Context<'_, T>) -> Option<YawEstimate<T>> {
        let (var_mount, var_lens) = context.yaw_variances();
        let is_claimed = self.calibrated && self.claimed > T::ZERO;
        let var_mount = var_mount.filter(|_| is_claimed)?;
        Some(YawEstimate::of_mount(T::ZERO, var_mount, var_lens))
    }

    /// Returns the estimate after the pairs; `None` if the rows give the yaw of the mount.
    ///
    /// * `rows`: yaw of the fused rows. It counts before the first pair has been added.
    fn estimate(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> Option<YawEstimate<T>> {
        let RowsYaw { turn, variance } = rows.of_scene(context);
        let first = || Some(self.factory(context)?.with(Measured::Rows, turn, variance));
        self.bank.map(|bank| bank.estimate()).or_else(first)
    }

    /// Returns the estimate if the fused rows give the yaw of the mount.
    fn of_rows(rows: &RowsYaw<T>, context: &Context<'_, T>) -> YawEstimate<T> {
        let RowsYaw { turn, variance } = rows.of_scene(context);
        let (_, var_lens) = context.yaw_variances();
        YawEstimate::of_rows(turn, variance, var_lens)
    }

    /// Returns the yaws of mount and lens for a report.
    ///
    /// * `rows`: yaw of the fused rows.
    #[inline(never)]
    pub(crate) fn reported(&self, rows: &RowsYaw<T>, context: &Context<'_, T>) -> ReportedYaw<T> {
        let known = self.estimate(rows, context);
        let yaw = known.unwrap_or_else(|| Self::of_rows(rows, context));
        let doubt = self.doubt(&yaw);
        ReportedYaw {
            mount: known.map(|known| known.mount()),
            variance: yaw.var_mount() + doubt,
            lens: yaw.lens(),
            lens_sd: (yaw.var_lens() + doubt).sqrt(),
            var_at_rest: self.bank.map_or(yaw.var_rows(), |bank| bank.var_at_rest()),
        }
    }

    /// Returns the additional variance, rad^2, for the case that the mount has turned before the first pair, and the
    /// estimate takes this turn for a yaw of the lens.
    fn doubt(&self, of: &YawEstimate<T>) -> T {
        let claimed = self.claimed * of.lens();
        claimed * claimed * (T::ONE + self.claimed * T::lit(TURNED_DOUBT))
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
        let (_, var_lens) = context.yaw_variances();
        let before = self.estimate(rows, context).unwrap_or_else(|| Self::of_rows(rows, context));
        // The limit depends on the prior of the lens and not on the estimate: a wrong measurement that was taken must
        // not cause the refusal of later right ones.
        if is_apart(before.rows() - yaw, var_lens + before.var_rows() + variance) {
            return None;
        }
        let contradicts = is_apart(yaw - before.mount(), before.var_mount() + variance);
        let alone = Measurements { yaw, variance, count: 1 };
        let confirmed = self.waiting.take().and_then(|waiting| waiting.confirmed(yaw, variance));
        let found = if contradicts { confirmed.unwrap_or(alone) } else { alone };
        if contradicts && found.count <= self.support.max(1) {
            self.waiting = Some(found);
            return Some(Witnessed::Waiting);
        }
        let mut bank = self.bank.unwrap_or(Bank::at_rest(before));
        if contradicts {
            // Only the sum of mount and lens stays, because the pairs show it.
            bank = Bank::at_rest(YawEstimate::of_rows(before.rows(), before.var_rows(), var_lens));
            (self.claimed, self.support) = (T::ZERO, 0);
        }
        let var_before = bank.estimate().var_mount();
        bank.add(Measured::Mount, found.yaw, found.variance);
        let least = T::lit(WITNESS_RAD * WITNESS_RAD).min(var_before);
        bank.map(|yaws| yaws.not_below(least));
        self.support = self.support.saturating_add(found.count).min(WITNESS_SUPPORT);
        self.claimed *= (bank.estimate().var_mount() / var_before).min(T::ONE);
        self.bank = Some(bank);
        Some(Witnessed::Taken)
    }

    /// Returns the mount yaw apart from the present sums, rad; 0 if nothing but rows has measured it.
    pub(crate) fn known_yaw(&self) -> T {
        self.bank.map_or(T::ZERO, |bank| bank.estimate().mount())
    }

    /// Returns the numbers of a record, and whether the yaws are known.
    pub(crate) fn parts(&self) -> ([T; 6], bool) {
        let [a, b, c, d, e] = self.bank.map_or([T::ZERO; 5], |bank| bank.estimate().numbers());
        ([self.claimed, a, b, c, d, e], self.bank.is_some())
    }

    /// Takes over the numbers of a record after a reset; returns `None` unless they fit together. The caller has
    /// checked the range of each number.
    pub(crate) fn resume(&mut self, [claimed, numbers @ ..]: [T; 6], is_known: bool) -> Option<()> {
        let known = YawEstimate::of(numbers)?;
        self.bank = is_known.then_some(Bank::of(known));
        self.claimed = claimed;
        self.support = if claimed < T::ONE { WITNESS_SUPPORT } else { 0 };
        Some(())
    }
}

impl<T: Scalar> RowsYaw<T> {
    /// Returns the rows with the scatter from scene to scene added to their variance.
    fn of_scene(self, context: &Context<'_, T>) -> Self {
        Self { variance: self.variance + scene_variance(context), ..self }
    }
}

/// Returns the variance of the yaw of the rows from scene to scene, rad^2; 0 if the lens is exact.
fn scene_variance<T: Scalar>(context: &Context<'_, T>) -> T {
    let (_, lens) = context.yaw_variances();
    if lens > T::ZERO { T::lit(SCENE_YAW_RAD * SCENE_YAW_RAD) } else { T::ZERO }
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
