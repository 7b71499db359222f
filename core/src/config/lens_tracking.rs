//! Whether errors of the given lens models are compensated.

/// Whether errors of the given lens models are reported only, or compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LensTracking {
    /// They are estimated, named, and widen the deviations. The extrinsics belong to the given lens models.
    Report,
    /// Differences of focal length and of `k1` are compensated, where that halves the deviation of `t`: the estimate
    /// begins again with corrected cameras ([`crate::Fused::LensCorrected`]), and extrinsics belong to these
    /// ([`crate::Calibration`]). For callers who rectify with [`crate::Calibration::cameras`].
    Compensate,
}

codes! { LensTracking { Report = 0, Compensate = 1 } }
texts! { LensTracking { Report = "report", Compensate = "compensate" } }
