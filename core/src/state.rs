//! State of the estimate, and why a solver stopped.

/// Reliability of the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum State {
    /// Too few pairs agree yet.
    Acquiring,
    /// The estimate is confirmed, and the last pair that was compared with it agrees. `R` is certain; `t` may still be
    /// the start value: [`crate::Proposal::baseline_observed`].
    Locked,
    /// The last pair that was compared with the estimate disagrees, a challenger gathers pairs, or no pair has supported
    /// a restored estimate yet.
    Suspect,
    /// At least ten pairs in a row disagree with the estimate, and no three of them agree well enough with each other.
    Lost,
}

codes! { State { Acquiring = 0, Locked = 1, Suspect = 2, Lost = 3 } }

texts! {
    State { Acquiring = "acquiring", Locked = "locked", Suspect = "suspect", Lost = "lost" }
    Stop { Converged = "converged", NoDescent = "no descent", PassesSpent = "passes spent" }
}

/// Why the solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Stop {
    /// The step fell below the tolerance, or below the resolution of the scalar at the optimum.
    Converged,
    /// No step lowers the cost, so this is the optimum within the resolution of the scalar; or the normal equations
    /// have no solution that is a valid step.
    NoDescent,
    /// All passes were taken. This is normal for a pair that was tracked from an estimate. A search that stops this way
    /// has not converged; its result is the best pose reached.
    PassesSpent,
}

codes! { Stop { Converged = 0, NoDescent = 1, PassesSpent = 2 } }
