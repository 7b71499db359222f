//! Cameras of images that were cropped or resampled: region of interest, binning, scale.

use anyhow::{Result, ensure};
use rigs::data::{Meta, Rows};

/// Change of an image: cropped, then scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Place of the first pixel of the new image in the whole image, px.
    pub offset: [f64; 2],
    /// Size of a pixel of the whole image, in px of the new image.
    pub scale: [f64; 2],
    /// Width and height of the new image, px.
    pub size: [u16; 2],
}

impl Change {
    /// The change by a region of interest `[x, y, width, height]` (the whole image if width or height is 0) and a
    /// binning (1 if it is 0).
    ///
    /// # Errors
    /// If the region is not in the image.
    pub fn of_info(
        [width, height]: [u16; 2],
        [x, y, w, h]: [u32; 4],
        binning: [u32; 2],
    ) -> Result<Self> {
        let whole = [width, height].map(u32::from);
        let [x, y, w, h] = if w == 0 || h == 0 { [0, 0, whole[0], whole[1]] } else { [x, y, w, h] };
        let inside = u64::from(x) + u64::from(w) <= u64::from(whole[0])
            && u64::from(y) + u64::from(h) <= u64::from(whole[1]);
        ensure!(
            inside,
            "the region of interest, {w} x {h} px at {x}, {y}, is not in the image of {width} x {height} px: give the rig (--rig)"
        );
        let binning = binning.map(|n| n.max(1));
        let size = [w / binning[0], h / binning[1]].map(|n| n as u16);
        Ok(Self { offset: [x, y].map(f64::from), scale: binning.map(|n| 1.0 / f64::from(n)), size })
    }

    /// A change of scale alone.
    pub fn scaled(from: [u16; 2], to: [u16; 2]) -> Self {
        Self {
            offset: [0.0; 2],
            scale: [0, 1].map(|i| f64::from(to[i]) / f64::from(from[i])),
            size: to,
        }
    }

    /// A crop from the middle.
    pub fn centre(from: [u16; 2], to: [u16; 2]) -> Self {
        let offset = [0, 1].map(|i| ((f64::from(from[i]) - f64::from(to[i])) / 2.0).floor());
        Self { offset, scale: [1.0; 2], size: to }
    }

    /// Camera matrix of the new image. The centre of the first pixel is at 0, so the border of an image is at -0.5,
    /// before and after the change.
    fn camera(&self, [[fx, skew, cx], [zero, fy, cy], bottom]: Rows) -> Rows {
        let [sx, sy] = self.scale;
        let centre = |c: f64, i: usize| (c - self.offset[i] + 0.5) * self.scale[i] - 0.5;
        [[fx * sx, skew, centre(cx, 0)], [zero, fy * sy, centre(cy, 1)], bottom]
    }
}

/// The rig of changed images, left and right.
pub fn changed(meta: &Meta, [left, right]: [Change; 2]) -> Meta {
    let [_, lens] = meta.lenses();
    let mut changed =
        Meta { k_l: left.camera(meta.k_l), k_r: right.camera(meta.k_r), ..meta.clone() };
    [changed.width, changed.height] = left.size;
    changed.set_right(lens, right.size);
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn region_and_binning_see_the_rays_of_the_whole_image() {
        let meta = Meta { ..rigs::data::Dataset::find_meta("opencv_chess_sift".as_ref()).unwrap() };
        let change = Change::of_info([640, 480], [100, 40, 400, 300], [2, 2]).unwrap();
        let part = changed(&meta, [change; 2]);
        assert_eq!(part.sizes(), [[200, 150]; 2]);
        let [whole, part] = [&meta, &part].map(|meta| meta.cameras::<f64>().unwrap().right);
        // Pixel (10, 20) of the part covers pixels 120 to 121 and 80 to 81 of the whole.
        let [a, b] = [whole.ray([120.5, 80.5]).unwrap(), part.ray([10.0, 20.0]).unwrap()];
        assert!((a - b).norm() < 1e-12, "{a} {b}");
        let all = Change::of_info([640, 480], [0; 4], [0, 0]).unwrap();
        assert_eq!(changed(&meta, [all; 2]).k_l, meta.k_l);
        assert!(Change::of_info([640, 480], [400, 0, 300, 480], [1, 1]).is_err());
    }

    #[test]
    fn a_cut_keeps_the_focal_length_and_moves_the_principal_point() {
        let meta = rigs::data::Dataset::find_meta("opencv_chess_sift".as_ref()).unwrap();
        let cut = changed(&meta, [Change::centre([640, 480], [320, 240]); 2]);
        assert!((cut.k_l[0][0] - meta.k_l[0][0]).abs() < 1e-12);
        assert!((cut.k_l[0][2] - (meta.k_l[0][2] - 160.0)).abs() < 1e-12);
    }
}
