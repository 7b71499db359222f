//! Errors of the lenses: the true cameras less the nominal ones, which the calibrator is given.

use std::str::FromStr;

use anyhow::{Result, ensure};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::normal::normal;

/// Stream of the random numbers for lens errors drawn from the prior.
const STREAM: u64 = 2;

/// Steps of Newton's method from a pixel to its ray. Further steps change nothing.
const STEPS: usize = 10;

/// Error of one camera: true less nominal. The nominal camera has no distortion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensError {
    /// Error of the focal length, relative.
    pub focal: f64,
    /// Additional error of the vertical focal length, relative.
    pub aspect: f64,
    /// Error of the principal point, px.
    pub centre: [f64; 2],
    /// Radial coefficients `k1 k2` as in OpenCV.
    pub radial: [f64; 2],
    /// Tangential coefficients `p1 p2` as in OpenCV.
    pub tangential: [f64; 2],
    /// Apparent yaw, rad: the row of the ray `(x, y)` is off by this times `x y`, at unit depth. Row offsets do not
    /// separate this error from yaw.
    pub rows: f64,
}

/// Lens errors as the user gives them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LensErrors {
    /// Given errors of the left and the right camera.
    pub given: [LensError; 2],
    /// Whether errors drawn from the prior are added, new for every seed.
    pub prior: bool,
}

impl LensError {
    /// No error.
    pub const NONE: Self = Self {
        focal: 0.0,
        aspect: 0.0,
        centre: [0.0; 2],
        radial: [0.0; 2],
        tangential: [0.0; 2],
        rows: 0.0,
    };

    /// Standard deviations of the errors that a calibration has after a year.
    const PRIOR: Self = Self {
        focal: 0.003,
        aspect: 0.0,
        centre: [1.0; 2],
        radial: [0.005, 0.0],
        tangential: [0.001; 2],
        rows: 0.0,
    };

    /// Checks the ranges.
    ///
    /// # Errors
    /// If a part is not finite, if the error of the principal point is beyond 100 px, or if another part is beyond 0.1.
    pub(crate) fn check(&self) -> Result<()> {
        let [k, p] = [self.radial, self.tangential];
        let small = [self.focal, self.aspect, k[0], k[1], p[0], p[1], self.rows];
        ensure!(small.iter().all(|x| x.abs() <= 0.1), "lens errors must be from -0.1 to 0.1");
        let centred = self.centre.iter().all(|px| px.abs() <= 100.0);
        ensure!(centred, "error of the principal point must be from -100 to 100 px");
        Ok(())
    }

    /// Errors of both cameras drawn from the prior.
    pub(crate) fn drawn(seed: u64) -> [Self; 2] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(STREAM);
        let mut draw = |sd: f64| sd * normal(&mut rng);
        [(); 2].map(|()| Self {
            focal: draw(Self::PRIOR.focal),
            aspect: 0.0,
            centre: Self::PRIOR.centre.map(&mut draw),
            radial: [draw(Self::PRIOR.radial[0]), 0.0],
            tangential: Self::PRIOR.tangential.map(&mut draw),
            rows: 0.0,
        })
    }

    /// Sum of both errors.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            focal: self.focal + other.focal,
            aspect: self.aspect + other.aspect,
            centre: sum(self.centre, other.centre),
            radial: sum(self.radial, other.radial),
            tangential: sum(self.tangential, other.tangential),
            rows: self.rows + other.rows,
        }
    }

    /// Pixel at which the true camera sees a ray, px.
    ///
    /// * `focal`, `centre`: focal length and principal point of the nominal camera, px.
    /// * `ray`: at unit depth.
    pub(crate) fn pixel(&self, focal: f64, [cx, cy]: [f64; 2], ray: [f64; 2]) -> [f64; 2] {
        let ([x, y], _) = self.distorted(ray);
        let [fx, fy] = self.focals(focal);
        [cx + self.centre[0] + fx * x, cy + self.centre[1] + fy * y]
    }

    /// Ray at unit depth that the true camera sees at a pixel; the inverse of [`LensError::pixel`].
    pub(crate) fn ray(&self, focal: f64, [cx, cy]: [f64; 2], [u, v]: [f64; 2]) -> [f64; 2] {
        let [fx, fy] = self.focals(focal);
        let seen = [(u - cx - self.centre[0]) / fx, (v - cy - self.centre[1]) / fy];
        let mut ray = seen;
        for _ in 0..STEPS {
            let ([x, y], [[xx, xy], [yx, yy]]) = self.distorted(ray);
            let [dx, dy] = [seen[0] - x, seen[1] - y];
            let determinant = xx * yy - xy * yx;
            ray[0] += (yy * dx - xy * dy) / determinant;
            ray[1] += (xx * dy - yx * dx) / determinant;
        }
        ray
    }

    /// True focal lengths, px: horizontal and vertical.
    fn focals(&self, focal: f64) -> [f64; 2] {
        let fx = focal * (1.0 + self.focal);
        [fx, fx * (1.0 + self.aspect)]
    }

    /// The distorted ray at unit depth, and its derivatives with respect to the ray.
    fn distorted(&self, [x, y]: [f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
        let ([k1, k2], [p1, p2]) = (self.radial, self.tangential);
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * r2 * k2);
        let distorted = [
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + self.rows * x * y,
        ];
        let across = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
        let xx = radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x;
        let yy = radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
        let rows = self.rows;
        (distorted, [[xx, across], [across + rows * y, yy + rows * x]])
    }

    /// The part with this name in a key.
    fn part(&mut self, name: &str) -> Option<&mut f64> {
        Some(match name {
            "f" => &mut self.focal,
            "aspect" => &mut self.aspect,
            "cx" => &mut self.centre[0],
            "cy" => &mut self.centre[1],
            "k1" => &mut self.radial[0],
            "k2" => &mut self.radial[1],
            "p1" => &mut self.tangential[0],
            "p2" => &mut self.tangential[1],
            "a" => &mut self.rows,
            _ => return None,
        })
    }
}

impl LensErrors {
    fn set(&mut self, key: &str, value: f64) -> Option<()> {
        let (name, side) = key.split_once('_')?;
        let sides = match side {
            "l" => 0..1,
            "r" => 1..2,
            "both" => 0..2,
            _ => return None,
        };
        for error in &mut self.given[sides] {
            *error.part(name)? = value;
        }
        Some(())
    }
}

impl FromStr for LensErrors {
    type Err = String;

    /// Reads items separated by commas: `prior`, or a key and its value such as `f_r=0.1%` or `k1_both=0.02`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut errors = Self::default();
        for item in text.split(',').map(str::trim) {
            if item == "prior" {
                errors.prior = true;
                continue;
            }
            let (key, value) =
                item.split_once('=').ok_or_else(|| format!("`{item}` is not key=value"))?;
            let (number, unit) = value.strip_suffix('%').map_or((value, 1.0), |n| (n, 0.01));
            let number: f64 =
                number.parse().map_err(|_| format!("`{value}` is not a number here"))?;
            errors.set(key, number * unit).ok_or_else(|| {
                format!(
                    "`{key}` is not one of f, aspect, cx, cy, k1, k2, p1, p2, a with _l, _r or _both"
                )
            })?;
        }
        for error in &errors.given {
            error.check().map_err(|error| error.to_string())?;
        }
        Ok(errors)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stats::rms;
    use nalgebra::Vector2;
    use stereo_selfcal::geometry::RadialTangential;
    use stereo_selfcal::{Camera, Intrinsics, Lens};

    const CENTRE: [f64; 2] = [319.5, 239.5];
    const FOCAL: f64 = 400.0;

    fn wrong() -> LensError {
        let text = "f_r=2%,aspect_r=-1%,cx_r=7,cy_r=-3,k1_r=-0.08,k2_r=0.03,p1_r=0.002,p2_r=-0.001";
        text.parse::<LensErrors>().unwrap().given[1]
    }

    #[test]
    fn a_camera_of_the_core_with_the_true_lens_sees_the_same_rays() {
        let LensError { radial: [k1, k2], tangential: [p1, p2], .. } = wrong();
        let lens = RadialTangential::try_new([k1, k2, p1, p2, 0.0]).unwrap();
        let focal = [FOCAL * 1.02, FOCAL * 1.02 * 0.99];
        let intrinsics = Intrinsics { focal, principal: [326.5, 236.5], size: [640, 480] };
        let camera = Camera::try_new(intrinsics, Lens::RadialTangential(lens)).unwrap();
        for pixel in [[0.0, 0.0], [639.0, 0.0], [320.0, 240.0], [30.0, 470.0]] {
            let ray = wrong().ray(FOCAL, CENTRE, pixel);
            let back = wrong().pixel(FOCAL, CENTRE, ray);
            let core = camera.ray(pixel).unwrap();
            assert!((Vector2::from(ray) - core).norm() < 1e-12, "{ray:?} {core}");
            assert!((Vector2::from(back) - Vector2::from(pixel)).norm() < 1e-10, "{back:?}");
        }
    }

    #[test]
    fn rows_are_off_by_the_product_of_the_coordinates_and_the_ray_is_found_again() {
        let wrong = LensError { rows: 0.01, ..LensError::NONE };
        for [x, y] in [[0.5, 0.3], [-0.4, 0.2], [0.0, 0.3]] {
            let pixel = wrong.pixel(FOCAL, CENTRE, [x, y]);
            let right = LensError::NONE.pixel(FOCAL, CENTRE, [x, y]);
            assert_eq!(pixel[0].to_bits(), right[0].to_bits());
            assert!((pixel[1] - right[1] - 0.01 * x * y * FOCAL).abs() < 1e-10, "{pixel:?}");
            let back = wrong.ray(FOCAL, CENTRE, pixel);
            assert!((back[0] - x).hypot(back[1] - y) < 1e-12, "{back:?}");
        }
    }

    #[test]
    fn keys_are_read_and_an_unknown_one_is_named() {
        let errors: LensErrors = "f_both=0.2%, cx_r=1,prior".parse().unwrap();
        assert!(errors.prior && errors.given.iter().all(|e| (e.focal - 0.002).abs() < 1e-15));
        assert_eq!(errors.given.map(|e| e.centre[0].to_bits()), [0.0, 1.0].map(f64::to_bits));
        assert_eq!("prior".parse::<LensErrors>().unwrap().given, [LensError::NONE; 2]);
        for (text, said) in [
            ("f", "key=value"),
            ("f_r=x", "number"),
            ("g_r=1", "is not one of"),
            ("f_x=1", "is not one of"),
            ("f_r=1", "-0.1 to 0.1"),
            ("cx_r=nan", "principal"),
        ] {
            let error = text.parse::<LensErrors>().unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }

    #[test]
    fn errors_of_the_prior_follow_their_seed_and_the_size_of_the_prior() {
        assert_eq!(LensError::drawn(3), LensError::drawn(3));
        let all: Vec<LensError> = (0..2000).flat_map(LensError::drawn).collect();
        let rms = |part: fn(&LensError) -> f64| rms(all.iter().map(part)).unwrap();
        for (found, sd) in [
            (rms(|e| e.focal), 0.003),
            (rms(|e| e.centre[1]), 1.0),
            (rms(|e| e.radial[0]), 0.005),
            (rms(|e| e.tangential[1]), 0.001),
        ] {
            assert!((found / sd - 1.0).abs() < 0.06, "{found} {sd}");
        }
    }
}
