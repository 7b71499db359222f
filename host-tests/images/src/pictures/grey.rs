//! Grey images in which a pixel may have no value (`None`, unseen): a warp leaves it so where the source image does not
//! reach.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use stereo_selfcal::Scalar;

/// A grey image; the centre of its top left pixel is at `(0, 0)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grey {
    size: [u16; 2],
    pixels: Vec<Option<u8>>,
}

impl Grey {
    /// Reads a PNG or JPEG file; colours become grey.
    ///
    /// # Errors
    /// Names the file.
    pub fn read(path: &Path) -> Result<Self> {
        let name = path.display();
        let bytes = fs::read(path).with_context(|| format!("cannot read {name}"))?;
        let image = image::load_from_memory(&bytes)
            .with_context(|| format!("cannot read the image {name}"))?
            .into_luma8();
        let size = [u16::try_from(image.width()), u16::try_from(image.height())];
        let [Ok(width), Ok(height)] = size else { anyhow::bail!("{name} is larger than 65535 px") };
        Ok(Self { size: [width, height], pixels: image.into_raw().into_iter().map(Some).collect() })
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
    #[must_use]
    pub fn size(&self) -> [u16; 2] {
        self.size
    }

    /// Width in the type of an index, px.
    #[must_use]
    pub fn width(&self) -> usize {
        usize::from(self.size[0])
    }

    /// Rows of pixels, top first.
    #[must_use]
    pub fn pixels(&self) -> &[Option<u8>] {
        &self.pixels
    }

    /// The pixel in a column and a row; `None` also outside the image.
    #[must_use]
    pub fn at(&self, column: usize, row: usize) -> Option<u8> {
        let inside = column < self.width() && row < usize::from(self.size[1]);
        if inside { self.pixels[row * self.width() + column] } else { None }
    }

    /// A bilinear value between the pixels; `None` outside the image, or if one of its pixels is unseen.
    #[must_use]
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
