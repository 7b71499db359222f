//! Grey images in which a pixel may have no value (`None`, unseen): a warp leaves it so where the source image does not
//! reach.

use std::path::Path;

use anyhow::{Result, ensure};
use stereo_selfcal::Scalar;

use crate::picture::Picture;

/// A grey image; the centre of its top left pixel is at `(0, 0)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grey {
    size: [u16; 2],
    pixels: Vec<Option<u8>>,
}

impl From<&Picture> for Grey {
    fn from(picture: &Picture) -> Self {
        Self { size: picture.size(), pixels: picture.pixels().iter().copied().map(Some).collect() }
    }
}

impl Grey {
    /// As [`Picture::read`].
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::from(&Picture::read(path)?))
    }

    /// The image of rows of pixels, top first. `None`: the pixel is unseen.
    ///
    /// # Errors
    /// If their number differs from the size.
    pub fn try_new(size: [u16; 2], pixels: Vec<Option<u8>>) -> Result<Self> {
        let expected = usize::from(size[0]) * usize::from(size[1]);
        ensure!(pixels.len() == expected, "{} pixels for {size:?}", pixels.len());
        Ok(Self { size, pixels })
    }

    /// Width and height, px.
    pub fn size(&self) -> [u16; 2] {
        self.size
    }

    /// Width in the type of an index, px.
    pub fn width(&self) -> usize {
        usize::from(self.size[0])
    }

    /// Rows of pixels, top first.
    pub fn pixels(&self) -> &[Option<u8>] {
        &self.pixels
    }

    /// The pixel in a column and a row; `None` also outside the image.
    pub fn at(&self, column: usize, row: usize) -> Option<u8> {
        let inside = column < self.width() && row < usize::from(self.size[1]);
        if inside { self.pixels[row * self.width() + column] } else { None }
    }

    /// A bilinear value between the pixels; `None` outside the image, or if one of its pixels is unseen.
    pub fn sample(&self, [u, v]: [f64; 2]) -> Option<f64> {
        let [right, bottom] = self.size.map(|n| f64::from(n) - 1.0);
        if !(0.0..=right).contains(&u) || !(0.0..=bottom).contains(&v) {
            return None;
        }
        let [column, row] = [u, v].map(|x| usize::from(x.floor().to_u16()));
        let [du, dv] = [u - u.floor(), v - v.floor()];
        let mut sum = 0.0;
        for (i, j, weight) in [
            (0, 0, (1.0 - du) * (1.0 - dv)),
            (1, 0, du * (1.0 - dv)),
            (0, 1, (1.0 - du) * dv),
            (1, 1, du * dv),
        ] {
            if weight > 0.0 {
                sum += weight * f64::from(self.at(column + i, row + j)?);
            }
        }
        Some(sum)
    }
}
