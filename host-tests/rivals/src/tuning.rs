//! Settings of a method that a comparison varies, so that each is shown with those that suit it best.

/// Standard deviation of the rig's motion from pair to pair that a steady filter expects, rad about each axis.
const STEADY_SD: f64 = 1e-5;

/// The same of an agile filter: follows a knock within a pair or two, and errs more between knocks.
const AGILE_SD: f64 = 1e-3;

/// Which settings a method is run with; the default ones are those of its file's header.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent choices, each on or off")]
pub struct Tuning {
    /// Only the inliers of RANSAC are given to the method.
    pub prefiltered: bool,
    /// The scale of the noise is estimated from the matches, in place of the one told.
    pub noise_estimated: bool,
    /// Pairs alone pass the gate of the paper preset before they are fused.
    pub gated: bool,
    /// A loss that redescends is entered from a wide scale, halved step by step.
    pub annealed: bool,
    /// Outliers are removed by their residual, and the others fitted by least squares.
    pub rejecting: bool,
    /// A filter expects a rig that moves.
    pub agile: bool,
}

impl Tuning {
    /// Process noise of a filter, rad a pair about each axis.
    pub(super) fn process_sd(self) -> f64 {
        if self.agile { AGILE_SD } else { STEADY_SD }
    }

    /// What is set, in the words of a heading: `RANSAC, noise estimated`.
    #[must_use]
    pub fn words(self) -> String {
        let all = [
            (self.prefiltered, "RANSAC"),
            (self.noise_estimated, "noise estimated"),
            (self.gated, "gate"),
            (self.annealed, "annealed"),
            (self.rejecting, "rejection"),
            (self.agile, "agile"),
        ];
        let set = all.iter().filter(|(set, _)| *set);
        let words: Vec<&str> = set.map(|(_, words)| *words).collect();
        if words.is_empty() { "plain".into() } else { words.join(", ") }
    }
}
