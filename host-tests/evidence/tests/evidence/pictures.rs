//! The picture of the README.

use evidence::pictures::{KNOCKED, Motorcycle, knocked};
use images::pictures::{Disparities, disparity_picture, pair_picture};
use page::report::Picture;
use sim::stats::median;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};

#[test]
fn rows_of_a_turned_pair_align_and_its_disparities_are_found_after_calibration_only() {
    let [before, after] = knocked(5.0).unwrap().rectified;
    assert!(before.row_offset_px > 20.0 && after.row_offset_px < 0.6);
    assert!(after.valid > 2.0 * before.valid, "{} {}", before.valid, after.valid);
    assert!(before.right < 0.1 && after.right > 0.6, "{} {}", before.right, after.right);
    for one in [before, after].map(|one| one.rectification) {
        let [width, height] = one.images[0].size().map(u32::from);
        let pictures = [disparity_picture(&one).unwrap(), pair_picture(&one).unwrap()];
        for (picture, width) in pictures.into_iter().zip([width, 2 * width]) {
            let Picture::Jpeg(jpeg) = picture else { panic!("no JPEG") };
            let decoded = image::load_from_memory(&jpeg).unwrap();
            // The shape of the image is kept, at most as wide as a panel of the page.
            let shown = width.min(640);
            assert_eq!([decoded.width(), decoded.height()], [shown, height * shown / width]);
        }
    }
}

#[test]
fn the_command_makes_the_picture_of_the_readme() {
    let drawn = image::load_from_memory(&knocked(KNOCKED).unwrap().jpeg).unwrap().into_rgb8();
    let kept = image::load_from_memory(include_bytes!("../../knocked.jpg"));
    let kept = kept.unwrap().into_rgb8();
    assert_eq!(drawn.dimensions(), kept.dimensions());
    let apart: u64 = drawn.iter().zip(kept.iter()).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    let values = u64::try_from(drawn.len()).unwrap();
    let advice = "cargo evidence picture --out host-tests/evidence/knocked.jpg";
    assert!(apart < values, "the picture has changed: {advice}");
}

#[test]
fn the_published_depth_agrees_with_the_published_rig_and_with_what_is_found() {
    let scene = Motorcycle::turned(0.0).unwrap();
    let [left, right] = scene.set.cameras::<f64>().map(|c| [c.left, c.right]).unwrap();
    let [[cx, cy], [cx_r, _]] = [left, right].map(|camera| camera.intrinsics().principal);
    let target = RectifiedCamera { focal: left.mean_focal(), principal: [cx, cy] };
    let rotations = RectifyingRotations::from(&scene.set.truth().unwrap());
    let [left_image, right_image] = &scene.images;
    let found = Disparities::of(left_image, right_image, 64);
    let places = (0..500_u16).flat_map(|v| (0..741_u16).map(move |u| [u, v].map(f64::from)));
    let off = places.zip(&found.pixels).filter_map(|(pixel, d)| {
        // The right camera's principal point is further right, which reduces all disparities.
        let truth = scene.true_disparity(&rotations, &target, pixel)? - (cx_r - cx);
        Some(((*d)? - truth).abs())
    });
    let off: Vec<f64> = off.collect();
    let (count, median) = (off.len(), median(off).unwrap());
    assert!(count > 200_000 && median < 0.5, "{count} {median}");
}
