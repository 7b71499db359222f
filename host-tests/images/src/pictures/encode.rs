//! Rectified pairs and disparities as encoded pictures.

use anyhow::{Context, Result};
use image::codecs::jpeg::JpegEncoder;
use image::imageops::{FilterType, crop_imm, replace, resize};
use image::{Rgb, RgbImage};

use super::grey::Grey;
use super::rectification::Rectification;
use page::chart::palette::{self, SERIES, viridis};
use page::report::Picture;

/// Colour of a pixel without disparity; no colour of the map is grey.
const INVALID: Rgb<u8> = Rgb([150, 150, 150]);

/// Colour of a pixel outside the original image.
const UNSEEN: Rgb<u8> = Rgb([40, 44, 60]);

/// Number of strips between the horizontal lines over a pair, and the largest number of matches drawn.
const LINES: u32 = 12;
const MATCHES: usize = 16;

/// Radius of the mark of a match's end, px.
const MARK: i64 = 4;

/// Half the width of the bar of a row offset, px.
const BAR: i64 = 1;

const QUALITY: u8 = 58;

/// Largest width of an encoded picture, px.
const WIDEST: u32 = 640;

/// Width of a tile of [`before_and_after`], and distance between tiles, px.
const TILE: u32 = 360;
const GAP: u32 = 6;

/// Disparities in colour, dark blue for far and yellow for near; grey without a disparity.
pub fn disparity_picture(rectification: &Rectification) -> Result<Picture> {
    jpeg(&disparity_image(rectification)).context("cannot encode the disparities")
}

fn disparity_image(rectification: &Rectification) -> RgbImage {
    let [width, height] = rectification.disparities.size.map(u32::from);
    let most = f64::from(rectification.range);
    let color = |d: &Option<f64>| d.map_or(INVALID, |d| pixel(viridis(d / most)));
    let mut image = RgbImage::new(width, height);
    let pixels = image.pixels_mut().zip(&rectification.disparities.pixels);
    pixels.for_each(|(pixel, d)| *pixel = color(d));
    image
}

/// Left and right image side by side, with level lines over both, and matches: a dot at either end, a level line from the
/// left dot on which the right dot should lie, and a bar from this line to the right dot.
pub fn pair_picture(rectification: &Rectification) -> Result<Picture> {
    jpeg(&pair_image(rectification)).context("cannot encode the pair")
}

fn pair_image(rectification: &Rectification) -> RgbImage {
    let [left, right] = &rectification.images;
    let [width, height] = left.size().map(u32::from);
    let mut image = RgbImage::new(2 * width, height);
    for (side, x) in [(left, 0), (right, width)] {
        paste(&mut image, side, x);
    }
    let [line, level, end] = [SERIES[5], SERIES[4], SERIES[1]].map(|color| pixel(color.light));
    for i in 1..LINES {
        let y = height * i / LINES;
        (0..2 * width).for_each(|x| (y..y + 2).for_each(|y| blend(&mut image, x, y, line)));
    }
    for [l, r] in spread(&rectification.matches) {
        let right = [r[0] + f64::from(width), r[1]];
        let y = whole(l[1]);
        for x in whole(l[0])..=whole(right[0]) {
            put(&mut image, [x, y], level);
            put(&mut image, [x, y + 1], level);
        }
        // The row offset, as a bar that an aligned match does not have.
        let [x, bottom] = right.map(whole);
        for y in y.min(bottom)..=y.max(bottom) {
            (-BAR..=BAR).for_each(|dx| put(&mut image, [x + dx, y], end));
        }
        for point in [*l, right] {
            dot(&mut image, point.map(whole), end);
        }
    }
    image
}

/// One pair under two rectifications, a row of tiles each: left image, right image, disparities. JPEG.
pub fn before_and_after(rows: [&Rectification; 2]) -> Result<Vec<u8>> {
    let [width, height] = rows[0].images[0].size().map(u32::from);
    let high = height * TILE / width;
    let mut image = RgbImage::from_pixel(3 * TILE + 2 * GAP, 2 * high + GAP, Rgb([255; 3]));
    for (row, top) in rows.into_iter().zip([0, i64::from(high + GAP)]) {
        let pair = resize(&pair_image(row), 2 * TILE, high, FilterType::Triangle);
        let depth = resize(&disparity_image(row), TILE, high, FilterType::Triangle);
        for (i, x) in [0, TILE].into_iter().zip([0, TILE + GAP]) {
            let side = crop_imm(&pair, i, 0, TILE, high).to_image();
            replace(&mut image, &side, x.into(), top);
        }
        replace(&mut image, &depth, (2 * (TILE + GAP)).into(), top);
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&image)?;
    Ok(bytes)
}

/// Encodes an image as JPEG, no wider than a panel of the page.
fn jpeg(image: &RgbImage) -> Result<Picture> {
    let [width, height] = [image.width(), image.height()];
    let shown = width.min(WIDEST);
    let small = resize(image, shown, height * shown / width, FilterType::Triangle);
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&small)?;
    Ok(Picture::Jpeg(bytes))
}

fn pixel(palette::Rgb(r, g, b): palette::Rgb) -> Rgb<u8> {
    Rgb([r, g, b])
}

fn paste(image: &mut RgbImage, side: &Grey, x: u32) {
    for (i, pixel) in (0_u32..).zip(side.pixels()) {
        let width = u32::from(side.size()[0]);
        let color = pixel.map_or(UNSEEN, |grey| Rgb([grey; 3]));
        image.put_pixel(x + i % width, i / width, color);
    }
}

/// Some of the matches, from top to bottom.
fn spread(matches: &[[[f64; 2]; 2]]) -> impl Iterator<Item = &[[f64; 2]; 2]> {
    let mut sorted: Vec<_> = matches.iter().collect();
    sorted.sort_by(|a, b| a[0][1].total_cmp(&b[0][1]));
    let step = sorted.len().div_ceil(MATCHES).max(1);
    sorted.into_iter().step_by(step)
}

/// The nearest whole number, within the range of images.
fn whole(x: f64) -> i64 {
    let size = i64::from(stereo_selfcal::Scalar::to_u16(x.abs() + 0.5));
    if x < 0.0 { -size } else { size }
}

fn blend(image: &mut RgbImage, x: u32, y: u32, Rgb(color): Rgb<u8>) {
    let Rgb(under) = image.get_pixel_mut(x, y);
    for (under, color) in under.iter_mut().zip(color) {
        *under = under.midpoint(color);
    }
}

/// Sets a pixel; ignores pixels outside the image.
fn put(image: &mut RgbImage, [x, y]: [i64; 2], color: Rgb<u8>) {
    let place = u32::try_from(x).ok().zip(u32::try_from(y).ok());
    if let Some(pixel) = place.and_then(|(x, y)| image.get_pixel_mut_checked(x, y)) {
        *pixel = color;
    }
}

fn dot(image: &mut RgbImage, [x, y]: [i64; 2], color: Rgb<u8>) {
    for dy in -MARK..=MARK {
        for dx in -MARK..=MARK {
            if dx * dx + dy * dy <= MARK * MARK {
                put(image, [x + dx, y + dy], color);
            }
        }
    }
}
