//! Recommended action for a calibration, as a word and as an exit status.

use std::fmt;

use serde::Serialize;

use super::JudgedInWords;

/// Recommended action for the calibration in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Recommendation {
    /// Rows are within their limit, and the estimate does not improve them clearly.
    Good,
    /// Rows are within their limit, but the estimate is clearly better.
    Improvable,
    /// Rows are beyond their limit.
    Recalibrate,
    /// The matches do not decide, or a cause is named, or the calibrator would not arm although the rows are right.
    Unknown,
}

impl Recommendation {
    /// Exit status of a command; 1 stands for an error.
    pub fn status(self) -> u8 {
        match self {
            Self::Good => 0,
            Self::Improvable => 10,
            Self::Recalibrate => 20,
            Self::Unknown => 30,
        }
    }

    /// The recommendation that follows from the verdict after the last pair; `None`: there was no pair.
    pub fn of(verdict: Option<&JudgedInWords>) -> Self {
        match verdict {
            Some(JudgedInWords { cause: None, rows_px: Some(_), rows_ok: false, .. }) => {
                Self::Recalibrate
            }
            Some(JudgedInWords { cause: None, should_apply: true, .. }) => Self::Improvable,
            Some(JudgedInWords { cause: None, may_arm: true, .. }) => Self::Good,
            _ => Self::Unknown,
        }
    }
}

impl fmt::Display for Recommendation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Good => "good",
            Self::Improvable => "improvable",
            Self::Recalibrate => "recalibrate",
            Self::Unknown => "unknown",
        })
    }
}
