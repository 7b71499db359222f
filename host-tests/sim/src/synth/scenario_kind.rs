//! Names of scenarios, and the scene of each.

use serde::{Deserialize, Serialize};
use strum::{Display, EnumMessage, EnumString, VariantArray};

use super::depth::Depth;
use super::flight;
use super::scene::Scene;

/// Height of a narrow band, and least height of a random band, in image heights.
pub(super) const NARROW_BAND: f64 = 0.15;

/// Name of a scenario.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    Default,
    Display,
    EnumMessage,
    EnumString,
    VariantArray,
    Serialize,
    Deserialize,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ScenarioKind {
    /// Points 3 to 80 baselines away.
    #[default]
    Near,
    /// Points 30 to 800 baselines away.
    Far,
    /// Points 300 to 3000 baselines away: the images have hardly any information on the baseline.
    VeryFar,
    /// Points 1000 to 10000 baselines away, as from high above: the disparities are 1.4 to 0.14 px, the noise is 0.3
    /// px.
    Altitude,
    /// Points 3 to 80 baselines away in the first pair, and a thousand times as far in the last.
    Climb,
    /// The reverse of a climb: points 3000 to 80000 baselines away in the first pair, and 3 to 80 in the last.
    Descent,
    /// 6 % of the points 3 to 80 baselines away, the others 300 to 3000.
    NearFew,
    /// 5 % of the points 3 to 80 baselines away, the others in the sky.
    Sky,
    /// Number of matches (48 to 512), depth range (within 3 to 800 baselines) and band of rows (height and middle) are
    /// new in each pair.
    Heterogeneous,
    /// Points in the middle 15 % of the rows.
    NarrowBand,
    /// All points of a pair on one plane, slanted by 15 to 60 degrees, a new one in each pair.
    Planar,
    /// All points of a pair on one plane across the left optical axis, at a new depth in each pair.
    FrontoParallel,
    /// The vehicle stands still: the same points and outliers in every pair, only the noise is new.
    Parked,
    /// The vehicle stands still for two thirds of the run, then moves. Each landmark has a matching error of its own,
    /// which stays the same from pair to pair.
    ParkedLandmarks,
    /// The vehicle creeps: landmarks pass slowly through the images, and keep their matching errors.
    Creeping,
    /// The right camera turns once, in mid run, about a random axis.
    Step,
    /// The right camera turns a little with every pair, about a fixed random axis.
    Drift,
    /// The right camera turns as its mount warms up in the first half of the run, and turns back as it cools down in the
    /// second: exponential curves, about a fixed random axis.
    WarmUp,
    /// Two drives with a long rest between: the vehicle stands still in the middle half of the run. The right camera
    /// turns once, before the second drive.
    Drives,
    /// The lenses of the scene have their errors from mid run on, as after autofocus or a blow.
    Refocus,
    /// A flight from the ground up and back, with outliers, vibration, thermal drift, and a knock in mid flight.
    Flight,
}

impl ScenarioKind {
    /// The scene of this name.
    #[must_use]
    pub fn scene(self) -> Scene {
        let depth = |near, far| Scene { depth: Depth::LogUniform([near, far]), ..Scene::default() };
        match self {
            Self::Far => depth(30.0, 800.0),
            Self::VeryFar => depth(300.0, 3000.0),
            Self::Altitude => depth(1000.0, 10_000.0),
            Self::NearFew => few_near(0.06, [300.0, 3000.0]),
            Self::Sky => few_near(0.05, [1e5, 1e7]),
            Self::Heterogeneous => Scene { matches: 512, ..depth(3.0, 800.0) },
            Self::Flight => Scene { outliers: flight::OUTLIERS, ..depth(3.0, 80.0) },
            Self::ParkedLandmarks | Self::Creeping => Scene { noise_px: 0.1, ..depth(3.0, 80.0) },
            Self::NarrowBand => Scene { band: NARROW_BAND, ..depth(3.0, 80.0) },
            Self::Near
            | Self::Climb
            | Self::Descent
            | Self::Planar
            | Self::FrontoParallel
            | Self::Parked
            | Self::Step
            | Self::Drift
            | Self::WarmUp
            | Self::Drives
            | Self::Refocus => depth(3.0, 80.0),
        }
    }

    /// Default of [`Scenario::turn_deg`](super::Scenario::turn_deg); 0 for a rig that does not move.
    #[must_use]
    pub fn turn_deg(self) -> f64 {
        match self {
            Self::Step => 0.5,
            Self::Drift => 0.01,
            Self::WarmUp | Self::Drives => 0.1,
            Self::Flight => flight::KNOCK_DEG,
            _ => 0.0,
        }
    }

    /// Default of [`Disturbance::vibration_deg`](super::Disturbance::vibration_deg).
    pub(super) fn vibration_deg(self) -> f64 {
        if self == Self::Flight { flight::VIBRATION_DEG } else { 0.0 }
    }

    /// Whether landmarks keep matching errors of their own from pair to pair.
    #[must_use]
    pub fn keeps_landmarks(self) -> bool {
        matches!(self, Self::ParkedLandmarks | Self::Creeping)
    }

    /// Whether the rig of this kind moves.
    #[must_use]
    pub fn moves(self) -> bool {
        matches!(self, Self::Step | Self::Drift | Self::WarmUp | Self::Drives | Self::Flight)
    }
}

/// A share of the points 3 to 80 baselines away, the others within a range.
fn few_near(share: f64, far: [f64; 2]) -> Scene {
    Scene { depth: Depth::Mixture { near: [3.0, 80.0], share, far }, ..Scene::default() }
}
