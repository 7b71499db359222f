//! Named reasons not to rely on a calibration: reasons of the estimate, and reasons of the last pair.

/// One reason not to rely on a calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Reason {
    /// The state is not locked: the estimate is not confirmed, the last pair disagrees with it, or a challenger gathers
    /// pairs. Forbids arming, except in the state [`crate::State::Suspect`].
    NotLocked,
    /// Matches with residuals on one side of the inliers are nearly as many as the inliers, and may agree with a second
    /// calibration, for instance because of a fence or a reflection. Forbids arming, and nothing is applied until the
    /// view has changed.
    SecondMode,
    /// Image halves disagree by more than 5 standard deviations, and the lens models are taken as exact
    /// ([`crate::Config::without_lens_prior`]): the matches of an image region share a bias. Forbids arming, and
    /// nothing is applied.
    Biased,
    /// The matches or the estimate show a mistake in rig file or matcher: [`crate::Verdict::cause`]. Forbids arming.
    Unfit,
    /// The calibration in use has not fitted two pairs in a row, or two pairs in a row have missed it since, or no pair
    /// could be solved for ten pairs. Forbids arming.
    Evidence,
    /// The disparities in use are expected to be off by more than the limit: [`crate::Verdict::depth_px`]. Forbids
    /// arming.
    Depth,
    /// The rows in use are off by more than the limit: [`crate::Verdict::rows_px`]. One such pair alone does not
    /// disarm.
    Rows,
    /// Too few of the matches that fit the pair's own pose fit the calibration in use, or they cover less than a
    /// seventh of the image. One such pair alone does not disarm.
    Coverage,
    /// Image halves disagree by more than 3 standard deviations; the reported deviations include this disagreement.
    /// With exact lens models the `t` in use is kept.
    ImageHalves,
    /// The pairs show an error of the lens models ([`crate::outcome::LensEstimate`]) or an apparent yaw of the lenses
    /// ([`crate::Proposal::lens_yaw`]); the deviations with the lens uncertain include it.
    Lens,
    /// The pairs have not determined the baseline direction: as a rule the baseline in use is kept
    /// ([`crate::Proposal::applicable`]).
    Baseline,
    /// The scene has hardly moved since the last pair that was added, and the pair adds no evidence.
    Repeated,
    /// The standard deviation of the apparent yaw of the lens is above 0.1 degrees: rows do not separate this yaw from
    /// the yaw of the mount, and neither the factory calibration nor witnesses determine the latter well enough. The
    /// deviations of yaw and of depth include both yaws.
    Yaw,
}

// Each code is one bit, so that a set is a sum of codes.
codes! {
    Reason {
        NotLocked = 1, Rows = 2, SecondMode = 4, ImageHalves = 8, Lens = 16, Baseline = 32,
        Repeated = 64, Evidence = 128, Unfit = 256, Biased = 512, Coverage = 1024, Depth = 2048,
        Yaw = 4096,
    }
}
texts! {
    Reason {
        NotLocked = "estimate not locked", Evidence = "in use not confirmed by the last pairs",
        Depth = "depth in use uncertain", Rows = "rows in use off",
        Coverage = "matches do not cover image or calibration in use",
        SecondMode = "second crowd of matches", ImageHalves = "image halves disagree",
        Lens = "lens models off", Baseline = "baseline not observed", Repeated = "repeated scene",
        Unfit = "matches do not support it",
        Biased = "matches biased", Yaw = "yaw not confirmed",
    }
}

impl Reason {
    /// All reasons; the reasons that forbid arming come first.
    pub const ALL: [Self; 13] = [
        Self::NotLocked,
        Self::SecondMode,
        Self::Biased,
        Self::Unfit,
        Self::Evidence,
        Self::Depth,
        Self::Rows,
        Self::Coverage,
        Self::ImageHalves,
        Self::Lens,
        Self::Baseline,
        Self::Repeated,
        Self::Yaw,
    ];
}

sets! {
    /// Set of [`Reason`]s.
    Reasons of Reason;
}

impl Reasons {
    /// Returns whether a reason of the set forbids arming of a rig whose estimate has been confirmed.
    pub(crate) const fn forbid_arming(self) -> bool {
        self.contains(Reason::Unfit)
            || self.contains(Reason::Evidence)
            || self.contains(Reason::Depth)
            || self.is_doubtful()
    }

    /// Returns whether the matches are too doubtful to apply their estimate.
    pub(crate) const fn is_doubtful(self) -> bool {
        self.contains(Reason::SecondMode) || self.contains(Reason::Biased)
    }
}
