//! Grey pictures of 8 bits.

use std::fmt;
use std::io::Cursor;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use image::DynamicImage;
use image::metadata::Orientation;
use kornia_image::{Image, ImageSize};

/// Share of the pixels of a 16-bit picture that may be brighter than the level that becomes white.
const CLIPPED: f64 = 0.001;

/// Largest difference of the brightest and the darkest pixel in an empty picture.
const CONTRAST: u8 = 8;

/// A grey picture; the centre of its top left pixel is at `(0, 0)`.
#[derive(Clone)]
pub struct Picture(Image<u8, 1>);

impl fmt::Debug for Picture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [width, height] = self.size();
        write!(f, "Picture({width} x {height})")
    }
}

impl Picture {
    /// From rows of pixels, top first.
    ///
    /// # Errors
    /// If the number of pixels does not fit the size, or a side is shorter than 2 or longer than 65535 px.
    pub fn try_new(size: [usize; 2], pixels: Vec<u8>) -> Result<Self> {
        let [width, height] = size;
        for length in size {
            ensure!(
                u16::try_from(length).is_ok(),
                "{width} x {height} px: a side may have at most 65535"
            );
        }
        ensure!(width >= 2 && height >= 2, "{width} x {height} px: too small for an image");
        Ok(Self(Image::new(ImageSize { width, height }, pixels)?))
    }

    /// Reads a PNG, JPEG, PGM, TIFF, BMP or `WebP` file of 8 or 16 bits as stored; colours become grey.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::read_with_orientation(path)?.0)
    }

    /// As [`Picture::read`], with the orientation from the EXIF data of the file.
    pub fn read_with_orientation(path: &Path) -> Result<(Self, Orientation)> {
        let name = path.display();
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {name}"))?;
        decoded(&bytes)
            .and_then(|(image, orientation)| Ok((Self::of(image)?, orientation)))
            .with_context(|| format!("cannot read the image {name}"))
    }

    /// Decodes the bytes of a file that [`Picture::read`] reads.
    ///
    /// # Errors
    /// If the bytes are not an image, or the image is damaged.
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        Self::of(decoded(bytes)?.0)
    }

    /// Turns or mirrors the picture as its EXIF orientation says.
    pub fn turned(self, orientation: Orientation) -> Self {
        if orientation == Orientation::NoTransforms {
            return self;
        }
        let [width, height] = self.size().map(u32::from);
        let grey = image::GrayImage::from_raw(width, height, self.pixels().to_vec());
        let Some(grey) = grey else { return self };
        let mut image = DynamicImage::ImageLuma8(grey);
        image.apply_orientation(orientation);
        Self::of(image).unwrap_or(self)
    }

    /// The left (0) or the right (1) half of a picture of both cameras side by side.
    ///
    /// # Errors
    /// If the width is odd or too small.
    pub fn half(&self, side: usize) -> Result<Self> {
        let [width, height] = self.size().map(usize::from);
        ensure!(width % 2 == 0, "{width} px: the width of a picture of both cameras must be even");
        let begin = side * width / 2;
        let lines = self.pixels().chunks_exact(width);
        Self::try_new(
            [width / 2, height],
            lines.flat_map(|line| line[begin..begin + width / 2].to_vec()).collect(),
        )
    }

    /// Resampled to another size with a triangle filter, which averages over the area of a pixel.
    pub fn resized(&self, size: [u16; 2]) -> Result<Self> {
        let [width, height] = self.size().map(u32::from);
        let grey = image::GrayImage::from_raw(width, height, self.pixels().to_vec())
            .context("a picture")?;
        let [width, height] = size.map(u32::from);
        let filter = image::imageops::FilterType::Triangle;
        Self::of(DynamicImage::ImageLuma8(image::imageops::resize(&grey, width, height, filter)))
    }

    /// Any decoded image as grey of 8 bits.
    pub fn of(image: DynamicImage) -> Result<Self> {
        let size = [image.width(), image.height()].map(|n| n as usize);
        let pixels = match image {
            DynamicImage::ImageLuma8(grey) => grey.into_raw(),
            DynamicImage::ImageLuma16(_)
            | DynamicImage::ImageLumaA16(_)
            | DynamicImage::ImageRgb16(_)
            | DynamicImage::ImageRgba16(_) => narrowed(&image.into_luma16().into_raw()),
            colours => colours.into_luma8().into_raw(),
        };
        Self::try_new(size, pixels)
    }

    /// From rows of 16-bit pixels, top first. The brightest pixels become white, whatever the bit depth of the camera.
    pub fn of_16_bits(size: [usize; 2], pixels: &[u16]) -> Result<Self> {
        Self::try_new(size, narrowed(pixels))
    }

    /// Width and height, px.
    pub fn size(&self) -> [u16; 2] {
        [self.0.width(), self.0.height()].map(|n| u16::try_from(n).unwrap_or(u16::MAX))
    }

    /// Rows of pixels, top first.
    pub fn pixels(&self) -> &[u8] {
        self.0.as_slice()
    }

    pub(crate) fn image(&self) -> &Image<u8, 1> {
        &self.0
    }

    pub(crate) fn from_image(image: Image<u8, 1>) -> Self {
        Self(image)
    }

    /// Whether the picture shows nothing: all pixels have almost the same grey value, as with a cap on the lens.
    pub fn is_blank(&self) -> bool {
        let (least, most) = self
            .pixels()
            .iter()
            .fold((u8::MAX, 0), |(low, high), &pixel| (low.min(pixel), high.max(pixel)));
        most.saturating_sub(least) <= CONTRAST
    }
}

fn decoded(bytes: &[u8]) -> Result<(DynamicImage, Orientation)> {
    ensure!(
        image::guess_format(bytes).is_ok(),
        "neither PNG nor JPEG nor PGM nor TIFF nor BMP nor WebP: save it as one of them"
    );
    // `ImageReader` is generic, so its decoders would be compiled once more here.
    Ok((image::load_from_memory(bytes)?, orientation(bytes)))
}

/// The orientation from the EXIF data; `NoTransforms` without EXIF data.
fn orientation(bytes: &[u8]) -> Orientation {
    let exif = exif::Reader::new().read_from_container(&mut Cursor::new(bytes)).ok();
    exif.and_then(|exif| {
        let field = exif.get_field(exif::Tag::Orientation, exif::In::PRIMARY)?;
        Orientation::from_exif(u8::try_from(field.value.get_uint(0)?).ok()?)
    })
    .unwrap_or(Orientation::NoTransforms)
}

/// 16 bits to 8 bits: linear from 0 to the level that only a few pixels exceed.
fn narrowed(pixels: &[u16]) -> Vec<u8> {
    let mut counts = vec![0_usize; 1 << 16];
    for &pixel in pixels {
        counts[usize::from(pixel)] += 1;
    }
    let may_clip = (pixels.len() as f64 * CLIPPED) as usize;
    let mut above = 0;
    let white = counts.iter().rposition(|count| {
        above += count;
        above > may_clip
    });
    let white = white.unwrap_or(0).max(1) as u32;
    pixels.iter().map(|&pixel| (u32::from(pixel) * 255 / white).min(255) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twelve_bits_in_sixteen_fill_the_range_and_a_hot_pixel_does_not_darken_the_rest() {
        let mut pixels: Vec<u16> = (0..10_000).map(|i| (i % 4096) as u16).collect();
        pixels[17] = u16::MAX;
        let picture = Picture::of_16_bits([100, 100], &pixels).unwrap();
        assert_eq!(picture.pixels()[17], 255);
        let brightest = picture.pixels()[4000..4096].iter().max();
        assert!(brightest >= Some(&249), "{brightest:?}");
        assert!(!picture.is_blank());
        assert!(Picture::of_16_bits([100, 100], &vec![0; 10_000]).unwrap().is_blank());
    }

    #[test]
    fn bytes_that_are_not_an_image_are_refused() {
        let why = |bytes: &[u8]| format!("{:#}", Picture::decode(bytes).unwrap_err());
        assert!(why(b"no image").contains("neither PNG"));
        assert!(Picture::decode(b"P5 4 4 255\n0123").is_err(), "a truncated PGM");
        assert!(Picture::decode(b"P5 2 2 255\n0123").is_ok());
        assert!(Picture::try_new([3, 3], vec![0; 8]).is_err());
    }
}
