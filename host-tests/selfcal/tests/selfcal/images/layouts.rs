//! Folders of known layouts with the calibrations of their data sets.

use std::fs;

use image::{ImageBuffer, Luma};
use rigs::data::{Dataset, Match};

use crate::call::run;
use crate::images::scene::{FOCAL, PRINCIPAL, SIZE, fits, save, small};

#[test]
fn euroc_kitti_and_middlebury_are_read_with_their_calibrations() {
    let [left, right] = small();
    let [width, height] = SIZE;
    let [cx, cy] = PRINCIPAL;
    let dir = tempfile::tempdir().unwrap();

    let euroc = dir.path().join("euroc");
    for (cam, image, x) in [("cam0", &left, 0.0), ("cam1", &right, 0.16)] {
        let folder = euroc.join("mav0").join(cam);
        fs::create_dir_all(folder.join("data")).unwrap();
        save(image, &folder.join("data/1403636579763555584.pgm"));
        let text = format!(
            "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0.0, -1.0, 0.0, 0.2,\n         1.0, 0.0, 0.0, {x},\n         \
             0.0, 0.0, 1.0, 0.0,\n         0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [{width}, {height}]\n\
             camera_model: pinhole\nintrinsics: [{FOCAL}, {FOCAL}, {cx}, {cy}]\ndistortion_model: radial-tangential\n\
             distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n"
        );
        fs::write(folder.join("sensor.yaml"), text).unwrap();
    }
    fits(0.5, &euroc, &[]);

    let kitti = dir.path().join("kitti");
    for (folder, image) in [("image_0", &left), ("image_1", &right)] {
        fs::create_dir_all(kitti.join(folder)).unwrap();
        save(image, &kitti.join(folder).join("000000.pgm"));
    }
    let p =
        |shift: f64| format!("{FOCAL:e} 0.0 {cx} {shift} 0.0 {FOCAL:e} {cy} 0.0 0.0 0.0 1.0 0.0");
    fs::write(kitti.join("calib.txt"), format!("P0: {}\nP1: {}\n", p(0.0), p(-FOCAL * 0.5)))
        .unwrap();
    fits(0.5, &kitti, &[]);

    let middlebury = dir.path().join("middlebury");
    fs::create_dir(&middlebury).unwrap();
    save(&left, &middlebury.join("im0.pgm"));
    save(&right, &middlebury.join("im1.pgm"));
    let k = format!("[{FOCAL} 0 {cx}; 0 {FOCAL} {cy}; 0 0 1]");
    let text = format!(
        "cam0={k}\ncam1={k}\ndoffs=0\nbaseline=160\nwidth={width}\nheight={height}\nndisp=64\n"
    );
    fs::write(middlebury.join("calib.txt"), text).unwrap();
    fits(0.5, &middlebury, &[]);
}

#[test]
fn tiff_of_8_and_16_bits_gives_the_matches_of_pgm() {
    let dir = tempfile::tempdir().unwrap();
    let place = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    for (image, side) in small().iter().zip(["left", "right"]) {
        save(image, place(&format!("{side}.pgm")).as_ref());
        image.save(place(&format!("{side}-8.tif"))).unwrap();
        // Full scale: 255 is 65535.
        let deep: ImageBuffer<Luma<u16>, Vec<u16>> =
            ImageBuffer::from_fn(SIZE[0], SIZE[1], |u, v| {
                Luma([257 * u16::from(image.get_pixel(u, v).0[0])])
            });
        deep.save(place(&format!("{side}-16.tiff"))).unwrap();
    }
    let matches = |ending: &str| {
        let [left, right] = ["left", "right"].map(|side| place(&format!("{side}{ending}")));
        let out = place(&format!("set{ending}"));
        let focal = FOCAL.to_string();
        let said = run(&["images", &left, &right, "--focal", &focal, "--out", &out]);
        assert_eq!(said.status, 0, "{}", said.err);
        Dataset::load(out.as_ref()).unwrap().pairs
    };
    let pgm = matches(".pgm");
    assert!(pgm.len() == 1 && pgm[0].len() > 100, "{}", pgm[0].len());
    assert!(matches("-8.tif") == pgm, "TIFF of 8 bits");
    // 16 bits are stretched over their range, so the grey values differ from those of 8 bits.
    let deep = matches("-16.tiff");
    let alike = |m: &Match| {
        let same = pgm[0].iter().find(|n| (n.ul, n.vl) == (m.ul, m.vl));
        same.is_some_and(|n| (n.ur - m.ur).hypot(n.vr - m.vr) < 0.1)
    };
    let (found, all) = (deep[0].iter().filter(|m| alike(m)).count(), pgm[0].len());
    assert!(10 * found > 8 * all, "{found} of {all}");
}
