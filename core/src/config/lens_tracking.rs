//! Choice between reporting and compensating errors of the given lens models.

/// Whether errors of the given lens models are reported only, or compensated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum LensTracking {
    /// Errors are estimated and reported, and they increase the reported deviations that include the lens. The
    /// extrinsics belong to the given lens models.
    Report,
    /// Differences of the focal lengths and of `k1` are compensated if that halves the standard deviation of `t`. The
    /// estimate then begins again with corrected cameras ([`crate::Fused::LensCorrected`]), and the extrinsics belong
    /// to these cameras ([`crate::Calibration`]). A lens that changes later, by autofocus or a blow, is corrected again.
    /// This is for callers who rectify with [`crate::Calibration::cameras`].
    Compensate,
}

codes! { LensTracking { Report = 0, Compensate = 1 } }
texts! { LensTracking { Report = "report", Compensate = "compensate" } }
