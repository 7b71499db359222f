//! Number of trials.

/// Trials of each kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Scenes of a point of a curve over single pairs.
    pub single: u64,
    /// Scenes of a point of the curve over the number of pairs.
    pub fused: u64,
    /// Runs over a step.
    pub steps: u64,
    /// Whether every point of a curve is measured, or every second one.
    pub dense: bool,
}

impl Effort {
    /// Takes minutes.
    pub const QUICK: Self = Self { single: 100, fused: 25, steps: 25, dense: false };
    /// Takes most of an hour on two cores. The standard error of an RMS over 2,500 scenes is 1.5 %.
    pub const FULL: Self = Self { single: 2500, fused: 500, steps: 500, dense: true };

    /// An effort of so many scenes and runs of each kind.
    #[must_use]
    pub fn with_trials(self, trials: u64) -> Self {
        Self { single: trials, fused: trials, steps: trials, ..self }
    }

    /// Selects the measured values: all if dense; otherwise every second one from the first, and the last.
    #[must_use]
    pub fn thinned(self, values: &[f64]) -> Vec<f64> {
        let last = values.len().saturating_sub(1);
        let numbered = values.iter().enumerate();
        numbered.filter(|(i, _)| self.dense || i % 2 == 0 || *i == last).map(|(_, x)| *x).collect()
    }
}
