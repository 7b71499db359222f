//! Generated scenes: a known rig, points of known depth, Gaussian noise, gross outliers.
//!
//! Left points are uniform in the image, or in a band of its rows; points that miss the right image are drawn again.
//! Half of the outliers are uniform in the right image, half within +-60 px (u) and +-20 px (v) of the truth. All four
//! coordinates get noise; then they are rounded to the matcher's grid.

use anyhow::{Result, ensure};
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::Extrinsics;

use super::depth::Depth;
use super::fence::{Fence, Place};
use super::grid::{self, Grid};
use super::lens_error::LensError;
use super::normal::normal;
use rigs::data::{Match, Rays};

/// Parameters of a generated scene. `Default` is the scene of the project's figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Image `[width, height]`, px.
    pub size: [u16; 2],
    /// Focal length of both cameras, px; the principal point is the middle of the image.
    pub focal: f64,
    /// Errors of the left and the right camera: true camera less the nominal pinhole of `focal` and `size`.
    pub lens_errors: [LensError; 2],
    /// True extrinsics.
    pub rig: Extrinsics<f64>,
    /// Standard deviation of the noise of each coordinate, px.
    pub noise_px: f64,
    /// Share of gross outliers, 0 to 1.
    pub outliers: f64,
    /// A repeated structure, whose matches are outliers that agree with each other.
    pub fence: Option<Fence>,
    /// Depth of the points.
    pub depth: Depth,
    /// Height of the band of rows that left points come from, in image heights.
    pub band: f64,
    /// Middle of the band, in image heights from the top; 0.5 is centred.
    pub band_centre: f64,
    /// Number of correspondences of a pair.
    pub matches: usize,
    /// Grid that the coordinates are rounded to, after the noise.
    pub grid: Grid,
}

impl Default for Scene {
    fn default() -> Self {
        Self {
            size: [1920, 1200],
            focal: 1400.0,
            lens_errors: [LensError::NONE; 2],
            rig: Extrinsics::SIDE_BY_SIDE,
            noise_px: 0.3,
            outliers: 0.0,
            fence: None,
            depth: Depth::LogUniform([3.0, 80.0]),
            band: 1.0,
            band_centre: 0.5,
            matches: 256,
            grid: Grid::Continuous,
        }
    }
}

/// Largest number of points drawn to check that the cameras share a view, and to find a point on a fence.
const TRIES: usize = 10_000;

/// One generated pair: correspondences, and which of them are true.
#[derive(Debug, Clone, PartialEq)]
pub struct SynthPair {
    /// Correspondences, inliers and outliers in random order.
    pub matches: Vec<Match>,
    /// Whether each correspondence is true.
    pub inlier: Vec<bool>,
    /// Noise-free pixels `ul vl ur vr` of the point of each correspondence.
    pub clean: Vec<[f64; 4]>,
    /// Pixels `ul vl ur vr` that are matched, before noise: `clean` of an inlier, other pixels of an outlier. The error
    /// that a landmark keeps is included.
    pub matched: Vec<[f64; 4]>,
}

impl SynthPair {
    /// Rays of all matches in the true cameras, at unit depth.
    ///
    /// * `scene`: the scene of the pair.
    pub fn rays(&self, scene: &Scene) -> Vec<Rays> {
        self.matches.iter().map(|m| scene.rays([m.ul, m.vl, m.ur, m.vr])).collect()
    }

    /// Rays of the true matches, with their noise.
    pub fn inlier_rays(&self, scene: &Scene) -> Vec<Rays> {
        self.inliers_of(self.rays(scene))
    }

    /// Noise-free rays of the true matches.
    pub fn clean_inlier_rays(&self, scene: &Scene) -> Vec<Rays> {
        self.inliers_of(self.clean.iter().map(|&pixels| scene.rays(pixels)))
    }

    fn inliers_of(&self, all: impl IntoIterator<Item = Rays>) -> Vec<Rays> {
        let inliers = all.into_iter().zip(&self.inlier).filter(|(_, inlier)| **inlier);
        inliers.map(|(rays, _)| rays).collect()
    }
}

impl Scene {
    /// Checks the ranges, and that the cameras share a view.
    ///
    /// # Errors
    /// Names the parameter that is out of range, or says that no drawn point was seen by both cameras.
    pub fn check(&self) -> Result<()> {
        self.depth.check()?;
        self.grid.check()?;
        self.lens_errors.iter().try_for_each(LensError::check)?;
        ensure!(self.noise_px >= 0.0 && self.noise_px.is_finite(), "noise must be 0 px or more");
        ensure!((0.0..=1.0).contains(&self.outliers), "outliers must be a share from 0 to 1");
        self.fence.iter().try_for_each(Fence::check)?;
        ensure!(self.band > 0.0 && self.band <= 1.0, "band must be above 0 and at most 1");
        let (above, below) = (self.band_centre, 1.0 - self.band_centre);
        ensure!(above.min(below) > self.band / 2.0 - 1e-9, "band must be inside the image");
        ensure!(self.focal.is_finite() && self.focal >= 1.0, "focal must be at least 1 px");
        ensure!(self.size.iter().all(|&n| n >= 2), "image must be at least 2 x 2 px");
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for part in self.depth.parts() {
            ensure!(
                (0..TRIES).any(|_| self.point(part, &mut rng).is_some()),
                "no point of {TRIES} was seen by both cameras: rig or depth leave no overlap"
            );
        }
        Ok(())
    }

    /// An endless sequence of pairs, the same for the same seed. It may hang if [`Scene::check`] refuses the scene.
    pub fn pairs(&self, seed: u64) -> impl Iterator<Item = SynthPair> + '_ {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        std::iter::repeat_with(move || self.pair(&mut rng))
    }

    /// True rays at unit depth `[p_l, p_r]` of pixels `ul vl ur vr`.
    pub fn rays(&self, [ul, vl, ur, vr]: [f64; 4]) -> Rays {
        let centre @ [cx, cy] = self.centre();
        let ray = |error: &LensError, u: f64, v: f64| {
            if *error == LensError::NONE {
                return Vector3::new((u - cx) / self.focal, (v - cy) / self.focal, 1.0);
            }
            let [x, y] = error.ray(self.focal, centre, [u, v]);
            Vector3::new(x, y, 1.0)
        };
        let [left, right] = &self.lens_errors;
        [ray(left, ul, vl), ray(right, ur, vr)]
    }

    /// Right pixel of a point in the right camera frame.
    fn right_pixel(&self, p: &Vector3<f64>) -> [f64; 2] {
        let centre @ [cx, cy] = self.centre();
        let [_, error] = &self.lens_errors;
        if *error == LensError::NONE {
            return [cx + self.focal * p.x / p.z, cy + self.focal * p.y / p.z];
        }
        error.pixel(self.focal, centre, [p.x / p.z, p.y / p.z])
    }

    /// Principal point of the nominal cameras, px.
    pub(super) fn centre(&self) -> [f64; 2] {
        self.size.map(|n| f64::from(n - 1) / 2.0)
    }

    /// The next pair of a checked scene.
    pub(super) fn pair(&self, rng: &mut ChaCha8Rng) -> SynthPair {
        let mut inlier: Vec<bool> =
            (0..self.matches).map(|_| !rng.random_bool(self.outliers.clamp(0.0, 1.0))).collect();
        let mut clean: Vec<[f64; 4]> = (0..self.matches).map(|_| self.seen_point(rng).0).collect();
        let (mut matched, mut matches): (Vec<_>, Vec<_>) = inlier
            .iter()
            .zip(&clean)
            .map(|(&inlier, &seen)| {
                let matched = if inlier { seen } else { self.outlier(seen, rng) };
                let step = self.grid.step(rng);
                (matched, self.observed(matched, step, rng))
            })
            .unzip();
        // The fence is drawn last, so that all other points are the same without it.
        if let Some(fence) = &self.fence {
            let place = fence.place(self.size, rng);
            for i in 0..self.matches {
                if rng.random_bool(fence.share) {
                    let step = matches[i].step;
                    (inlier[i], clean[i]) = (false, self.point_at(&place, rng));
                    matched[i] = fence.matched(clean[i], rng);
                    matches[i] = self.observed(matched[i], step, rng);
                }
            }
        }
        SynthPair { matches, inlier, clean, matched }
    }

    /// Noise-free pixels of a point on the fence, or of any point if the cameras share too little of the fence.
    fn point_at(&self, place: &Place, rng: &mut ChaCha8Rng) -> [f64; 4] {
        let mut seen = self.seen_point(rng).0;
        for _ in 0..TRIES {
            let [u, v, ..] = seen;
            if place.covers([u, v], self.size) {
                break;
            }
            seen = self.seen_point(rng).0;
        }
        seen
    }

    /// The points and outliers of a repeated pair, with new noise.
    pub(super) fn pair_again(&self, pair: &SynthPair, rng: &mut ChaCha8Rng) -> SynthPair {
        let again = pair.matched.iter().zip(&pair.matches);
        let matches = again.map(|(&pixels, m)| self.observed(pixels, m.step, rng)).collect();
        SynthPair { matches, ..pair.clone() }
    }

    /// Pixels of one point that both cameras see, without noise, and its depth in baselines.
    ///
    /// The loop ends, because [`Scene::check`] has found such points.
    pub(super) fn seen_point(&self, rng: &mut ChaCha8Rng) -> ([f64; 4], f64) {
        let part = self.depth.part(rng);
        loop {
            if let Some(seen) = self.point(part, rng) {
                return seen;
            }
        }
    }

    /// Noise-free pixels of one point of the left view, and its depth in baselines, if the right camera sees it too.
    ///
    /// * `depth`: the part of the scene's depth that the point belongs to.
    fn point(&self, depth: Depth, rng: &mut ChaCha8Rng) -> Option<([f64; 4], f64)> {
        let [width, height] = self.size.map(f64::from);
        let middle = self.band_centre * (height - 1.0);
        let ul = rng.random_range(0.0..width - 1.0);
        let vl = middle + rng.random_range(-0.5..0.5) * self.band * (height - 1.0);
        let [ray, _] = self.rays([ul, vl, ul, vl]);
        let depth = depth.along(&ray, rng)?;
        Some((self.seen_from([ul, vl], depth)?, depth))
    }

    /// The point at noise-free pixels `ul vl ur vr`, in the left camera frame, in baselines.
    pub(super) fn point_of(&self, clean: &[f64; 4]) -> Vector3<f64> {
        let [left, right] = self.rays(*clean);
        let (turned, t) = (self.rig.rotation() * left, self.rig.translation());
        // Solves the u component of `right ~ depth R left + t` for the depth.
        left * ((t.x - right.x * t.z) / (right.x * turned.z - turned.x))
    }

    /// Pixels of a point in the left camera frame, in baselines, if both cameras see it.
    pub(super) fn seen_at(&self, point: &Vector3<f64>) -> Option<[f64; 4]> {
        let [x, y] = [point.x / point.z, point.y / point.z];
        let [error, _] = &self.lens_errors;
        let pixel = error.pixel(self.focal, self.centre(), [x, y]);
        (point.z > 0.0).then(|| self.seen_from(pixel, point.z)).flatten()
    }

    /// Pixels of the point at a left pixel and a depth, in baselines, if both cameras see it.
    pub(super) fn seen_from(&self, [ul, vl]: [f64; 2], depth: f64) -> Option<[f64; 4]> {
        let [width, height] = self.size.map(f64::from);
        let inside =
            |u: f64, v: f64| (0.0..=width - 1.0).contains(&u) && (0.0..=height - 1.0).contains(&v);
        let [ray, _] = self.rays([ul, vl, ul, vl]);
        let p_r = self.rig.rotation() * (ray * depth) + self.rig.translation().into_inner();
        let [ur, vr] = self.right_pixel(&p_r);
        (p_r.z > 0.0 && inside(ul, vl) && inside(ur, vr)).then_some([ul, vl, ur, vr])
    }

    /// Pixels of an outlier: the given left pixel, and a wrong right pixel.
    pub(super) fn outlier(&self, [ul, vl, ur, vr]: [f64; 4], rng: &mut ChaCha8Rng) -> [f64; 4] {
        let [width, height] = self.size.map(f64::from);
        if rng.random() {
            let u = rng.random_range(0.0..width - 1.0);
            [ul, vl, u, rng.random_range(0.0..height - 1.0)]
        } else {
            let u = ur + rng.random_range(-60.0..60.0);
            [ul, vl, u, vr + rng.random_range(-20.0..20.0)]
        }
    }

    /// Pixels as the matcher reports them: with noise, on its grid.
    pub(super) fn observed(&self, pixels: [f64; 4], step: f64, rng: &mut ChaCha8Rng) -> Match {
        let last = self.size.map(|n| f64::from(n - 1));
        // A coordinate that noise moves out of the image stays at its border, as with a matcher.
        let mut coordinate = |i: usize| {
            let last = last[i % 2];
            grid::rounded((pixels[i] + self.noise_px * normal(rng)).clamp(0.0, last), step, last)
        };
        Match {
            ul: coordinate(0),
            vl: coordinate(1),
            ur: coordinate(2),
            vr: coordinate(3),
            score: 1.0,
            step,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::rig::rig;

    fn first(scene: &Scene) -> SynthPair {
        scene.check().unwrap();
        scene.pairs(11).next().unwrap()
    }

    /// Depth in baselines of a noise-free point: `p_r z_r = R p_l z_l + t`, multiplied by `p_r` (cross product).
    fn depth(scene: &Scene, pixels: [f64; 4]) -> f64 {
        let [p_l, p_r] = scene.rays(pixels);
        let known = p_r.cross(&scene.rig.translation().into_inner());
        let turned = p_r.cross(&(scene.rig.rotation() * p_l));
        -known.dot(&turned) / turned.norm_squared()
    }

    fn off_axis() -> Extrinsics<f64> {
        rig([5.0, -3.0, 2.0], [4.0, -3.0]).unwrap()
    }

    #[test]
    fn points_are_within_the_depth_range() {
        let range = [30.0, 800.0];
        let scene = Scene { rig: off_axis(), depth: Depth::LogUniform(range), ..Scene::default() };
        let depths: Vec<f64> = first(&scene).clean.iter().map(|&p| depth(&scene, p)).collect();
        assert!(depths.iter().all(|z| (29.9999..800.001).contains(z)), "{depths:?}");
        assert!(depths.iter().any(|&z| z < 50.0) && depths.iter().any(|&z| z > 500.0));
    }

    #[test]
    fn points_of_a_plane_are_on_it() {
        let plane = Depth::Plane { on_axis: 12.0, slope: [-0.8, 0.5] };
        let scene = Scene { rig: off_axis(), depth: plane, ..Scene::default() };
        for pixels in first(&scene).clean {
            let [ray, _] = scene.rays(pixels);
            let off = Vector3::new(-0.8, 0.5, 1.0).dot(&ray) - 12.0 / depth(&scene, pixels);
            assert!(off.abs() < 1e-9, "{pixels:?}: {off}");
        }
    }

    #[test]
    fn points_are_within_the_band() {
        let scene = Scene { band: 0.2, band_centre: 0.7, ..Scene::default() };
        let rows: Vec<f64> = first(&scene).clean.iter().map(|[_, v, ..]| v / 1199.0).collect();
        assert!(rows.iter().all(|v| (0.6..0.8).contains(v)));
        assert!(rows.iter().any(|&v| v < 0.65) && rows.iter().any(|&v| v > 0.75));
        let outside = Scene { band_centre: 0.95, ..scene };
        assert!(outside.check().unwrap_err().to_string().contains("band"));
    }

    #[test]
    fn coordinates_lie_on_the_grid_that_the_match_names() {
        for grid in [Grid::Pixels(0.25), Grid::Pixels(1.0), Grid::Pyramid] {
            let pair = first(&Scene { grid, outliers: 0.3, ..Scene::default() });
            for m in &pair.matches {
                for x in [m.ul, m.vl, m.ur, m.vr].map(|x| x / m.step) {
                    assert!((x - x.round()).abs() < 1e-9, "{grid:?}: {m:?}");
                }
            }
            let steps =
                |step: f64| pair.matches.iter().filter(|m| m.step.total_cmp(&step).is_eq()).count();
            match grid {
                Grid::Pixels(step) => assert_eq!(steps(step), pair.matches.len()),
                _ => assert!(grid::LEVELS.iter().all(|&step| steps(step) > 10)),
            }
        }
    }

    #[test]
    fn rounding_changes_nothing_but_the_last_digits() {
        let [plain, rounded] = [Grid::Continuous, Grid::Pixels(0.5)]
            .map(|grid| first(&Scene { grid, outliers: 0.3, ..Scene::default() }));
        assert_eq!(plain.matched, rounded.matched);
        for (a, b) in plain.matches.iter().zip(&rounded.matches) {
            assert!((a.ur - b.ur).abs() <= 0.25 + 1e-9 || a.ur > 1918.5, "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_pair_seen_again_differs_by_its_noise_alone() {
        let scene = Scene { outliers: 0.3, grid: Grid::Pyramid, ..Scene::default() };
        let pair = first(&scene);
        let again = scene.pair_again(&pair, &mut ChaCha8Rng::seed_from_u64(5));
        assert_ne!(again.matches, pair.matches);
        for (a, b) in again.matches.iter().zip(&pair.matches) {
            assert!(a.step.total_cmp(&b.step).is_eq());
            assert!((a.vr - b.vr).abs() < 10.0 * scene.noise_px + a.step);
        }
        assert_eq!(SynthPair { matches: pair.matches.clone(), ..again }, pair);
    }
}
