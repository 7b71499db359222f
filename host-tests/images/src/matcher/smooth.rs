//! The images for the refinement of matches.

use anyhow::Result;

use crate::picture::Picture;

/// The picture smoothed with weights 1 2 1 along rows and columns. Bilinear interpolation blurs more in the middle
/// between pixels than near them, which pulls a refined position towards whole pixels. A smooth image is hardly
/// blurred.
pub(super) fn smoothed(picture: &Picture) -> Result<Picture> {
    let [width, height] = picture.size().map(usize::from);
    let mut across = Vec::with_capacity(width * height);
    for line in picture.pixels().chunks_exact(width) {
        let at = |u: usize| u16::from(line[u]);
        // Beyond a border the last pixel of the line or column is repeated.
        across.push(3 * at(0) + at(1));
        across.extend(
            line.windows(3).map(|w| w.iter().map(|x| u16::from(*x)).sum::<u16>() + u16::from(w[1])),
        );
        across.push(at(width - 2) + 3 * at(width - 1));
    }
    let row = |v: usize| &across[v * width..(v + 1) * width];
    let mut pixels = Vec::with_capacity(width * height);
    for v in 0..height {
        let (above, below) = (row(v.saturating_sub(1)), row((v + 1).min(height - 1)));
        let three = above.iter().zip(row(v)).zip(below);
        pixels.extend(three.map(|((a, b), c)| ((a + 2 * b + c + 8) / 16) as u8));
    }
    Picture::try_new([width, height], pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_unchanged_and_a_dot_is_spread() {
        let slope: Vec<u8> = (0..30).map(|i| 10 * (i % 6) + i / 6).collect();
        let smooth = smoothed(&Picture::try_new([6, 5], slope.clone()).unwrap()).unwrap();
        for v in 1..4 {
            assert_eq!(smooth.pixels()[6 * v + 1..6 * v + 5], slope[6 * v + 1..6 * v + 5]);
        }
        let mut dot = vec![0; 25];
        dot[12] = 160;
        let smooth = smoothed(&Picture::try_new([5, 5], dot).unwrap()).unwrap();
        assert_eq!(smooth.pixels()[6..9], [10, 20, 10]);
        assert_eq!(smooth.pixels()[11..14], [20, 40, 20]);
        assert_eq!(smooth.pixels().iter().map(|x| u32::from(*x)).sum::<u32>(), 160);
    }
}
