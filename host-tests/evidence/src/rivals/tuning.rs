//! Settings of a method that a comparison varies, so that each method is shown with its best settings.

/// Standard deviation of the rig's motion from pair to pair that a steady filter expects, rad about each axis.
const STEADY_SD: f64 = 1e-5;

/// The same for an agile filter, which follows a knock within a pair or two, and has larger errors between knocks.
const AGILE_SD: f64 = 1e-3;

/// Settings of a method; the header of its file describes the defaults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "independent choices, each on or off")]
pub struct Tuning {
    /// The method gets only the inliers of RANSAC.
    pub prefiltered: bool,
    /// The scale of the noise is estimated from the matches instead of given.
    pub noise_estimated: bool,
    /// Single pairs pass the gate of the published method before they are fused.
    pub gated: bool,
    /// A redescending loss starts at a wide scale, halved step by step.
    pub annealed: bool,
    /// Outliers are removed by their residual, and the other matches are fitted by least squares.
    pub rejecting: bool,
    /// A filter expects a rig that moves.
    pub agile: bool,
}

impl Tuning {
    /// Process noise of a filter, rad a pair about each axis.
    pub(super) fn process_sd(self) -> f64 {
        if self.agile { AGILE_SD } else { STEADY_SD }
    }

    /// The changed settings in words for a heading: `RANSAC, noise estimated`.
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
