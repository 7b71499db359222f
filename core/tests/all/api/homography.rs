//! Rectifying homographies and the new camera, by the conventions of `cv::stereoRectify`.

use crate::api::scene::{FOCAL, SIZE, cameras, correspondences, rig};
use nalgebra::{Matrix3, Vector2, Vector3};
use stereo_selfcal::geometry::{
    RadialTangential, RectifiedCamera, RectifyError, RectifyingRotations,
};
use stereo_selfcal::{Camera, Cameras, Extrinsics, Intrinsics, Lens};

fn map(h: &Matrix3<f64>, [u, v]: [f64; 2]) -> Vector2<f64> {
    let p = h * Vector3::new(u, v, 1.0);
    p.xy() / p.z
}

fn distorted() -> Cameras<f64> {
    let lens = |k1| {
        Lens::RadialTangential(RadialTangential::try_new([k1, 0.05, 1e-3, -1e-3, 0.0]).unwrap())
    };
    let camera = |k1, cx| {
        let intrinsics =
            Intrinsics { focal: [534.0, 531.0], principal: [cx, 240.0], size: [640, 480] };
        Camera::try_new(intrinsics, lens(k1)).unwrap()
    };
    Cameras { left: camera(-0.28, 342.0), right: camera(-0.3, 327.0) }
}

#[test]
fn rows_coincide_and_disparity_is_positive_under_the_homographies() {
    let truth = rig::<f64>([2.0, -3.0, 1.0], [3.0, -2.0]);
    let rotations = RectifyingRotations::from(&truth);
    let camera = RectifiedCamera::try_choose(&cameras(), &rotations, 0.0).unwrap();
    let [left, right] = camera.homographies(&cameras(), &rotations);
    for c in correspondences::<f64>(&truth, 500, 0.0, 5) {
        let [l, r] = [map(&left, c.left), map(&right, c.right)];
        assert!((l.y - r.y).abs() < 1e-9 && l.x > r.x, "{l} {r}");
    }
}

/// Whether a camera sees a rectified pixel.
///
/// * `r`: rectifying rotation of the camera.
/// * `k`: rectified camera.
fn seen(camera: &Camera<f64>, r: &Matrix3<f64>, k: &RectifiedCamera<f64>, pixel: [f64; 2]) -> bool {
    let [cx, cy] = k.principal;
    let [u, v] = pixel;
    let ray = r.transpose() * Vector3::new((u - cx) / k.focal, (v - cy) / k.focal, 1.0);
    let Ok([u, v]) = camera.pixel(ray.xy() / ray.z) else { return false };
    let [width, height] = camera.intrinsics().size.map(f64::from);
    (-0.5..width - 0.5).contains(&u) && (-0.5..height - 0.5).contains(&v)
}

#[test]
fn alpha_0_shows_no_pixel_that_a_camera_does_not_see() {
    let rotations = RectifyingRotations::from(&rig::<f64>([1.0, -2.0, 1.5], [2.0, -1.0]));
    for cameras in [cameras(), distorted()] {
        let chosen = RectifiedCamera::try_choose(&cameras, &rotations, 0.0).unwrap();
        let [width, height] = cameras.left.intrinsics().size.map(|n| f64::from(n) - 1.0);
        for i in 0..=50 {
            let s = f64::from(i) / 50.0;
            let border =
                [[s * width, 0.0], [s * width, height], [0.0, s * height], [width, s * height]];
            for pixel in border {
                assert!(
                    seen(&cameras.left, rotations.left().matrix(), &chosen, pixel),
                    "{pixel:?}"
                );
                assert!(
                    seen(&cameras.right, rotations.right().matrix(), &chosen, pixel),
                    "{pixel:?}"
                );
            }
        }
    }
}

#[test]
fn alpha_1_keeps_every_pixel_of_both_cameras() {
    let rotations = RectifyingRotations::from(&rig::<f64>([1.0, -2.0, 1.5], [2.0, -1.0]));
    for cameras in [cameras(), distorted()] {
        let chosen = RectifiedCamera::try_choose(&cameras, &rotations, 1.0).unwrap();
        let [cx, cy] = chosen.principal;
        let [width, height] = cameras.left.intrinsics().size.map(|n| f64::from(n) - 1.0);
        for (camera, r) in [(&cameras.left, rotations.left()), (&cameras.right, rotations.right())]
        {
            for corner in [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]] {
                let ray = camera.ray(corner).unwrap();
                let p = r * Vector3::new(ray.x, ray.y, 1.0);
                let pixel = [cx + chosen.focal * p.x / p.z, cy + chosen.focal * p.y / p.z];
                let inside = |x: f64, n: f64| (-1e-6..=n + 1e-6).contains(&x);
                assert!(inside(pixel[0], width) && inside(pixel[1], height), "{pixel:?}");
            }
        }
    }
}

#[test]
fn a_rectified_rig_keeps_its_camera() {
    let rotations = RectifyingRotations::from(&Extrinsics::<f64>::SIDE_BY_SIDE);
    for alpha in [0.0, 0.5, 1.0] {
        let chosen = RectifiedCamera::try_choose(&cameras(), &rotations, alpha).unwrap();
        assert!((chosen.focal - FOCAL).abs() < 1e-9, "{chosen:?}");
        let middle = SIZE.map(|n| (f64::from(n) - 1.0) / 2.0);
        assert!((Vector2::from(chosen.principal) - Vector2::from(middle)).norm() < 1e-9);
    }
}

#[test]
fn views_that_cannot_be_shown_are_refused() {
    let plain = RectifyingRotations::from(&Extrinsics::<f64>::SIDE_BY_SIDE);
    let refused = |rotations: &RectifyingRotations<f64>, alpha| {
        RectifiedCamera::try_choose(&cameras(), rotations, alpha).unwrap_err()
    };
    assert_eq!(refused(&plain, -0.1), RectifyError::Alpha);
    assert_eq!(refused(&plain, f64::NAN), RectifyError::Alpha);
    let apart = RectifyingRotations::from(&rig::<f64>([0.0, 80.0, 0.0], [0.0, 0.0]));
    assert!(matches!(refused(&apart, 0.0), RectifyError::Behind(_) | RectifyError::NoCommonView));
}
