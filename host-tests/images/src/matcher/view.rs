//! An image, prepared for a search: its halvings, and the corners of a small one.

use anyhow::Result;
use kornia_image::{Image, ImageSize};
use kornia_imgproc::pyramid::pyrdown_u8;

use super::keypoints::Keypoints;
use super::patch;
use super::refine::Halved;
use super::smooth::smoothed;
use crate::picture::Picture;

/// Number of corners sought in the small images, and of levels of their pyramid.
const COARSE: [usize; 2] = [1200, 5];

/// Largest width of the small images, px.
const SMALL: usize = 720;

/// Largest number of halvings.
const HALVINGS: usize = 3;

/// An image, prepared for the first search.
pub struct View {
    pub(super) levels: Halved,
    /// The levels, smoothed for the refinement of matches.
    pub(super) smooth: Halved,
    /// The level of the first search.
    pub(super) small: usize,
    /// Corners of this level.
    pub(super) corners: Keypoints,
}

impl View {
    pub(super) fn new(picture: &Picture) -> Result<Self> {
        let levels = halved(picture)?;
        let smooth = levels.iter().map(smoothed).collect::<Result<Halved>>()?;
        let small = small(&levels);
        let [count, octaves] = COARSE;
        let corners = Keypoints::of(&levels[small], count, octaves, f64::from(1_u32 << small))?;
        Ok(Self { levels, smooth, small, corners })
    }

    /// Size of a pixel of the first search, px.
    pub fn pixel(&self) -> f64 {
        f64::from(1_u32 << self.small)
    }
}

/// The image and its repeated halvings, at most `HALVINGS`, while the shorter side holds four windows.
///
/// # Errors
/// If a level cannot be computed.
pub fn halved(picture: &Picture) -> Result<Halved> {
    let mut levels = vec![picture.clone()];
    while levels.len() <= HALVINGS {
        let image = levels[levels.len() - 1].image();
        let size =
            ImageSize { width: image.width().div_ceil(2), height: image.height().div_ceil(2) };
        if size.width.min(size.height) < 4 * patch::SIDE {
            break;
        }
        let mut half = Image::from_size_val(size, 0)?;
        pyrdown_u8(image, &mut half)?;
        levels.push(Picture::from_image(half));
    }
    Ok(levels)
}

/// The first level that is at most [`SMALL`] px wide, otherwise the last level.
fn small(halved: &Halved) -> usize {
    let fits = |picture: &Picture| usize::from(picture.size()[0]) <= SMALL;
    halved.iter().position(fits).unwrap_or(halved.len() - 1)
}
