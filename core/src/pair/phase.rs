//! Phases of a solver, and the loss of each (`ESTIMATOR.md`, section 5).

use super::proposal::Rounds;
use super::weighting::Loss;
use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::state::Stop;
use crate::thresholds::{
    ANNEALING, BELOW_PEAK, LEAST_SCALE_PX, NARROW_PX, POLISH_AT, WIDE_ANNEALING, WIDE_SCALE_PX,
};

/// Phase of a solver: it decides the loss of the next pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Phase<T> {
    /// First pass of a track: finds the limit on leverage, for the covariance of the start, rad^2.
    Survey(Symmetric5<T>),
    /// A step of a track: Tukey's loss, its limit widened by the covariance of the pose, rad^2.
    Track(Symmetric5<T>),
    /// First pass of a search: finds the first scale of the annealing, and takes its first step.
    Start,
    /// A step of the annealing: Geman-McClure's loss.
    Anneal {
        /// Scale, px.
        scale: T,
        /// Whether the second start is over.
        is_second: bool,
    },
    /// A round of the second start.
    SecondStart(Rounds),
    /// A step at the estimated noise: Tukey's loss.
    Polish,
    /// Only the evaluation is left.
    Done(Stop),
}

/// Next phase after a pass of the annealing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum AfterAnnealing<T> {
    /// The annealing goes on at this scale, px.
    Scale(T),
    /// The annealing ends; the polish begins at this noise, px.
    Polish(T),
}

impl<T: Scalar> AfterAnnealing<T> {
    /// Returns what follows a pass of the annealing.
    ///
    /// The scale falls to the width of the peak or below before the polish begins. At a wider scale, two groups of
    /// matches that fit different poses look like one peak between them. Without a peak, the polish begins when the
    /// next scale would be at most [`LEAST_SCALE_PX`].
    ///
    /// * `scale`: scale of the pass, px; `peak`: width of the peak seen in the pass, px; `None` without a peak.
    pub(super) fn of(scale: T, peak: Option<T>) -> Self {
        let is_wide = scale > T::lit(WIDE_SCALE_PX);
        let next = scale * T::lit(if is_wide { WIDE_ANNEALING } else { ANNEALING });
        let [narrow, wide] = POLISH_AT.map(T::lit);
        match peak {
            Some(peak) => {
                let at = if peak > T::lit(NARROW_PX) { wide } else { narrow };
                if scale <= at * peak {
                    Self::Polish(peak)
                } else {
                    Self::Scale(next.min(T::lit(BELOW_PEAK) * peak))
                }
            }
            None if next <= T::lit(LEAST_SCALE_PX) => Self::Polish(next),
            None => Self::Scale(next),
        }
    }
}

impl<T: Scalar> Phase<T> {
    /// Returns the residual variance that the loss assumes, px^2.
    ///
    /// * `noise`: standard deviation of a coordinate, px.
    pub(super) fn variance(&self, noise: T) -> T {
        match self {
            Self::Anneal { scale, .. } => *scale * *scale,
            _ => noise * noise,
        }
    }

    /// Returns whether the pass fills a histogram of residuals, in which a peak is sought.
    pub(super) fn sees_peaks(&self) -> bool {
        match self {
            Self::Anneal { scale, .. } => *scale <= T::lit(WIDE_SCALE_PX),
            Self::Polish => true,
            _ => false,
        }
    }

    /// Returns the loss of the pass.
    pub(super) fn loss(&self) -> Loss<T> {
        match self {
            Self::Survey(covariance) | Self::Track(covariance) => Loss::Track(*covariance),
            Self::Anneal { scale, .. } => Loss::Anneal(T::ONE / (*scale * *scale)),
            Self::Start | Self::SecondStart(_) | Self::Polish | Self::Done(_) => Loss::Polish,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    /// Returns the scales of an annealing that sees the same peak in each pass, and its final noise, px.
    fn scales(first: f64, peak: Option<f64>) -> (Vec<f64>, f64) {
        let mut scales = Vec::from([first]);
        loop {
            match AfterAnnealing::of(*scales.last().unwrap(), peak) {
                AfterAnnealing::Scale(next) => scales.push(next),
                AfterAnnealing::Polish(noise) => return (scales, noise),
            }
            assert!(scales.len() < 30, "{scales:?}");
        }
    }

    #[test]
    fn the_scale_of_an_annealing_falls_with_every_pass_and_ends_at_the_peak_or_below() {
        for peak in [None, Some(0.25), Some(0.5), Some(0.7), Some(5.6), Some(16.0)] {
            let (scales, noise) = scales(480.0, peak);
            assert!(scales.is_sorted_by(|a, b| b < a), "{scales:?}");
            let last = scales.last().unwrap();
            match peak {
                Some(peak) => assert!(noise == peak && *last <= peak, "{scales:?}"),
                None => assert!(noise <= LEAST_SCALE_PX, "{scales:?}"),
            }
            assert!(peak.is_none_or(|peak| peak < 1.0 || *last <= 0.3 * peak), "{scales:?}");
        }
    }
}
