//! The tables of `FORMAT.md` against the code.

use super::damage::sealed;
use super::{ROTATION, after, scene};
use crate::api::presets::robust;
use crate::api::scene::{cameras, rig, take};
use nalgebra::Matrix3;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::{Config, FactoryCalibration, RestoreError};

/// Byte, content and range of each row of a table.
fn table(heading: &str) -> Vec<(usize, String, String)> {
    let page = include_str!("../../../src/record/FORMAT.md");
    let section = page.split("\n## ").find(|section| section.starts_with(heading)).unwrap();
    let row = |line: &str| {
        let mut cells = line.split('|').skip(1).map(str::trim);
        let byte = cells.next()?.parse().ok()?;
        Some((byte, cells.next()?.to_owned(), cells.next()?.to_owned()))
    };
    section.lines().filter_map(row).collect()
}

/// Byte of the first row whose content contains a text.
fn place(table: &[(usize, String, String)], content: &str) -> usize {
    table
        .iter()
        .find(|(_, text, _)| text.contains(content))
        .unwrap_or_else(|| panic!("{content}"))
        .0
}

fn numbers<const N: usize>(record: &[u8], at: usize) -> [f32; N] {
    core::array::from_fn(|k| f32::from_le_bytes(record[at + 4 * k..][..4].try_into().unwrap()))
}

fn word(record: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(record[at..][..4].try_into().unwrap())
}

#[test]
fn the_table_of_the_state_matches_its_bytes() {
    let rows = table("State");
    let mut calibrator = after::<f32>(Config::robust(), 12);
    take(&mut calibrator, &scene(ROTATION, 12)).unwrap();
    calibrator.apply().unwrap();
    let (record, proposal) = (calibrator.snapshot(), calibrator.proposal().unwrap());
    assert_eq!(place(&rows, "end"), record.len());
    assert_eq!([&record[..4], &record[4..7]], [&b"SCRC"[..], &[7, 2, 1]]);
    assert_eq!(word(&record, place(&rows, "generation")), calibrator.in_use().generation);
    assert_eq!(word(&record, place(&rows, "pairs,")), 13);
    let turn = numbers::<3>(&record, place(&rows, "in use: turn"));
    assert_eq!(turn, <[f32; 3]>::from(so3::log(calibrator.in_use().extrinsics.rotation())));
    let t = numbers::<3>(&record, place(&rows, "`t` (3)"));
    assert_eq!(t, <[f32; 3]>::from(calibrator.in_use().extrinsics.translation().into_inner()));
    let estimate = place(&rows, "estimate: turn");
    assert_eq!(numbers::<6>(&record, estimate)[3..], t);
    let before = numbers::<6>(&record, place(&rows, "the previous calibration"));
    assert_ne!(before, numbers::<6>(&record, estimate));
    let [pitch, ..] = numbers::<15>(&record, place(&rows, "information of the pairs"));
    let expected = proposal.covariance.try_inverse().unwrap().m11;
    assert!((pitch / expected - 1.0).abs() < 0.1, "{pitch} {expected}");
    let [noise] = numbers(&record, place(&rows, "noise of a coordinate"));
    assert!((0.1..0.6).contains(&noise), "{noise}");
    let [inliers, crowd] = numbers(&record, place(&rows, "mean share"));
    assert!((0.5..1.0).contains(&inliers) && crowd.abs() < 0.1, "{inliers} {crowd}");
    let [claimed, ..] = numbers::<1>(&record, place(&rows, "mount: share"));
    assert_eq!(claimed, 1.0);
    assert_eq!(place(&rows, "CRC-32"), record.len() - 4);
}

#[test]
fn a_number_above_the_largest_of_its_range_is_refused() {
    let good = after::<f32>(Config::robust(), 20).snapshot();
    let [mut refused, mut accepted] = [0, 0];
    for (byte, content, range) in table("State") {
        let first = range.split(';').next().unwrap_or_default();
        let (from_0, most) = (first.starts_with("0 to "), first.trim_start_matches("0 to "));
        // The header has whole numbers.
        let (20.., Ok(most)) = (byte, most.parse::<f32>()) else { continue };
        let is_taken = |number: f32| {
            let mut record = good;
            record[byte..byte + 4].copy_from_slice(&number.to_le_bytes());
            robust::<f32>().restore(&sealed(record)) != Err(RestoreError::Absurd)
        };
        assert!(!is_taken(1.001 * most), "{content}");
        refused += 1;
        // Other numbers have further conditions.
        if from_0 {
            assert!(is_taken(0.999 * most), "{content}");
            accepted += 1;
        }
    }
    assert_eq!([refused, accepted], [17, 9]);
}

#[test]
fn the_table_of_the_factory_calibration_matches_its_bytes() {
    let rows = table("Factory calibration");
    let extrinsics = rig::<f32>(ROTATION, [0.5, -0.4]);
    let made = FactoryCalibration::new(cameras(), extrinsics).with_yaw_sd_rad(8e-4).unwrap();
    let made = made.with_baseline_m(0.12).unwrap();
    let record = made.to_record();
    assert_eq!(place(&rows, "end"), record.len());
    assert_eq!([&record[..4], &record[4..8]], [&b"SCRC"[..], &[7, 1, 0, 0]]);
    for camera in ["left camera", "right camera"] {
        let at = place(&rows, camera);
        assert_eq!(numbers(&record, at), [1400.0, 1400.0, 959.5, 599.5]);
        // 1920 by 1200.
        let size = at + place(&rows, "width") - place(&rows, "left camera");
        assert_eq!(word(&record, size), u32::from_le_bytes([0x80, 0x07, 0xb0, 0x04]));
    }
    assert_eq!(word(&record, place(&rows, "lens, `u32`")), 0);
    assert_eq!(numbers(&record, place(&rows, "coefficients")), [0.0; 8]);
    let r = Matrix3::from_row_slice(&numbers::<9>(&record, place(&rows, "`R` row by row")));
    assert_eq!(&r, extrinsics.rotation().matrix());
    let t = numbers::<3>(&record, place(&rows, "`t` (3)"));
    assert_eq!(t, <[f32; 3]>::from(extrinsics.translation().into_inner()));
    let yaw_sd = numbers(&record, place(&rows, "deviation of the yaw"));
    let baseline = numbers(&record, place(&rows, "length of the baseline"));
    assert_eq!([yaw_sd, baseline], [[8e-4], [0.12]]);
    let given = [made.yaw_sd_rad(), made.baseline_m()].map(Option::unwrap);
    assert_eq!(given, [8e-4, 0.12]);
    assert_eq!(place(&rows, "CRC-32"), record.len() - 4);
}
