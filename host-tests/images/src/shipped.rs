//! The images that the project ships.

use std::path::{Path, PathBuf};

use anyhow::Result;
use rigs::data::Dataset;
use strum::{Display, EnumMessage, EnumString, VariantArray};

/// Images of a shipped data set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display, EnumMessage, EnumString, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum ShippedImages {
    /// 13 pairs of a chessboard, 640 x 480, of OpenCV's samples.
    Chess,
    /// Middlebury 2014 Motorcycle at a quarter of its size, one pair, rectified.
    Motorcycle,
    /// Middlebury 2006 Aloe, one pair, rectified.
    Aloe,
}

/// Numbers of the chessboard's images.
const CHESS: [u8; 13] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14];

impl ShippedImages {
    /// All image sets.
    pub const ALL: &[Self] = Self::VARIANTS;

    /// The images with this name, unless a file or a folder has the same name.
    pub fn named(place: &Path) -> Option<Self> {
        place.to_str()?.parse().ok().filter(|_| !place.exists())
    }

    /// Left and right file of each pair.
    pub fn files(self) -> Vec<[PathBuf; 2]> {
        let images = Dataset::shipped().join("images");
        let names: Vec<[String; 2]> = match self {
            Self::Chess => CHESS
                .map(|n| ["left", "right"].map(|side| format!("chess/{side}{n:02}.jpg")))
                .into(),
            Self::Motorcycle => {
                vec![["left", "right"].map(|side| format!("motorcycle_{side}.jpg"))]
            }
            Self::Aloe => vec![["left", "right"].map(|side| format!("aloe/{side}.jpg"))],
        };
        names.into_iter().map(|pair| pair.map(|name| images.join(name))).collect()
    }

    /// Name of the data set of SIFT matches in the same images, which has their rig.
    pub fn set(self) -> &'static str {
        match self {
            Self::Chess => "opencv_chess_sift",
            Self::Motorcycle => "motorcycle_sift",
            Self::Aloe => "aloe_sift",
        }
    }

    /// The data set of SIFT matches in the same images.
    ///
    /// # Errors
    /// If its files are damaged.
    pub fn sift(self) -> Result<Dataset> {
        Dataset::load(&Dataset::shipped().join(self.set()))
    }
}
