//! Mistakes of a source of matches. The calibrator must not calibrate from such matches.

use std::mem;

use serde::{Deserialize, Serialize};

use rigs::data::Match;

/// A mistake in all matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Mistake {
    /// Left and right are exchanged.
    Exchanged,
    /// Both images are the left one.
    Identical,
}

impl Mistake {
    pub(super) fn make(self, m: &mut Match) {
        match self {
            Self::Exchanged => {
                mem::swap(&mut m.ul, &mut m.ur);
                mem::swap(&mut m.vl, &mut m.vr);
            }
            Self::Identical => (m.ur, m.vr) = (m.ul, m.vl),
        }
    }
}
