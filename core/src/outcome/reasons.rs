//! What speaks against relying on a calibration, by name.

use core::fmt;

use crate::outcome::health::LastPair;
use crate::outcome::proposal::{Doubt, Proposal};
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::MAX_CONFIRMED_YAW_RAD;

/// One thing that speaks against relying on a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Reason {
    /// The estimate is not confirmed, or the last pairs disagree with it.
    NotLocked,
    /// Rows of the extrinsics in use differ from those of the estimate by 1 px RMS or more.
    Misaligned,
    /// [`Doubt::SecondMode`]: nearly as many matches agree on another calibration.
    SecondMode,
    /// [`Doubt::Baseline`], [`Doubt::Everything`]: image halves disagree; the reported deviations contain it.
    ImageHalves,
    /// The pairs show an error of the lens models ([`crate::outcome::LensEstimate`]); the wide deviations contain it.
    Lens,
    /// Pairs have not determined the baseline direction: that in use is kept.
    Baseline,
    /// The last pair showed the scene of the one before: it adds no evidence.
    Repeated,
    /// [`Doubt::Axis`], in the paper preset: the axis of the rotation is noise.
    Axis,
    /// The matches do not support the calibration: [`crate::Health::cause`] says why.
    Unfit,
    /// No witness has told the yaw of the mount from the apparent yaw of the lens, and rows do not: the deviations of yaw
    /// and of depth contain both.
    Yaw,
}

// Bits of a set.
codes! {
    Reason {
        NotLocked = 1, Misaligned = 2, SecondMode = 4, ImageHalves = 8, Lens = 16, Baseline = 32,
        Repeated = 64, Axis = 128, Unfit = 256, Yaw = 4096,
    }
}
texts! {
    Reason {
        NotLocked = "estimate not locked", Misaligned = "in use off by 1 px or more",
        SecondMode = "second crowd of matches", ImageHalves = "image halves disagree",
        Lens = "lens models off", Baseline = "baseline not observed", Repeated = "repeated scene",
        Axis = "axis of the rotation is noise", Unfit = "matches do not support it",
        Yaw = "yaw not confirmed",
    }
}

impl Reason {
    /// All, those that forbid arming first.
    pub const ALL: [Self; 10] = [
        Self::NotLocked,
        Self::Misaligned,
        Self::Unfit,
        Self::SecondMode,
        Self::ImageHalves,
        Self::Lens,
        Self::Baseline,
        Self::Repeated,
        Self::Axis,
        Self::Yaw,
    ];
}

/// Set of [`Reason`]s.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reasons(u16);

impl Reasons {
    /// What speaks against a proposal.
    ///
    /// * `misaligned`: what is in use differs.
    pub(crate) fn of<T: Scalar>(proposal: &Proposal<T>, misaligned: bool, last: LastPair) -> Self {
        let Proposal { state, doubt, lens, lens_yaw, baseline_observed, .. } = proposal;
        let doubted = doubt.map(|doubt| match doubt {
            Doubt::SecondMode => Reason::SecondMode,
            Doubt::Baseline | Doubt::Everything => Reason::ImageHalves,
            Doubt::Axis => Reason::Axis,
        });
        let is_off = lens.is_some_and(|lens| lens.is_significant()) || lens_yaw.is_significant();
        let named = [
            (*state != State::Locked, Reason::NotLocked),
            (misaligned, Reason::Misaligned),
            (is_off, Reason::Lens),
            (!baseline_observed, Reason::Baseline),
            (last.repeated, Reason::Repeated),
            (last.cause.is_some(), Reason::Unfit),
            (lens_yaw.sd > T::lit(MAX_CONFIRMED_YAW_RAD), Reason::Yaw),
        ];
        let named = named.into_iter().filter_map(|(holds, reason)| holds.then_some(reason));
        Self(named.chain(doubted).fold(0, |bits, reason| bits | reason.code()))
    }

    /// Whether nothing speaks against it.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether a reason is in the set.
    #[must_use]
    pub const fn contains(self, reason: Reason) -> bool {
        self.0 & reason.code() != 0
    }

    /// The reasons, in the order of [`Reason::ALL`].
    pub fn iter(self) -> impl Iterator<Item = Reason> {
        Reason::ALL.into_iter().filter(move |reason| self.contains(*reason))
    }

    /// Sum of the [`Reason::code`]s, as in the C API.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }
}

impl fmt::Display for Reasons {
    /// `estimate not locked, baseline not observed`; `none` if there are none.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_empty() {
            return f.write_str("none");
        }
        let mut separator = "";
        for reason in self.iter() {
            write!(f, "{separator}{reason}")?;
            separator = ", ";
        }
        Ok(())
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Reasons {
    fn format(&self, f: defmt::Formatter<'_>) {
        for reason in self.iter() {
            defmt::write!(f, "{} ", reason);
        }
    }
}
