//! Records that are refused: flipped bits, and other lengths, kinds, layouts, rigs and numbers.

use super::{ROTATION, Record, after, off, restored, scene};
use crate::api::presets::{calibrated, robust, with};
use crate::api::scene::{cameras, rig, take};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::{Fisheye, RadialTangential, Rational};
use stereo_selfcal::{
    Camera, Cameras, Config, Extrinsics, FactoryCalibration, Lens, RestoreError, State,
};
use test_support::runs;

const CRC_32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

/// The record with a corrected checksum at its end.
pub(super) fn sealed<const N: usize>(mut record: [u8; N]) -> [u8; N] {
    let (body, sum) = record.split_last_chunk_mut().unwrap();
    *sum = CRC_32.checksum(body).to_le_bytes();
    record
}

/// Restores into a calibrator with pairs, checks that the restore fails and leaves it fresh, and returns the error.
fn refused(record: &[u8]) -> RestoreError {
    let mut calibrator = after::<f32>(Config::robust(), 5);
    let error = calibrator.restore(record).unwrap_err();
    assert_eq!((calibrator.state(), calibrator.proposal()), (State::Acquiring, None));
    assert_eq!(&calibrator.in_use().extrinsics, &Extrinsics::SIDE_BY_SIDE);
    error
}

#[test]
fn every_flipped_bit_and_every_other_length_is_damage() {
    let good = after::<f32>(Config::robust(), 10).snapshot();
    let mut fresh = robust::<f32>();
    for bit in 0..8 * good.len() {
        let mut bad = good;
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(fresh.restore(&bad), Err(RestoreError::Damaged), "{bit}");
    }
    for length in 0..good.len() {
        assert_eq!(fresh.restore(&good[..length]), Err(RestoreError::Damaged), "{length}");
    }
    // A longer record is refused even with a correct checksum.
    let longer = sealed(<[u8; 404]>::try_from([&good[..], &[0; 4]].concat()).unwrap());
    assert_eq!(refused(&longer), RestoreError::Damaged);
    assert_eq!(fresh.restore(&good), Ok(()));
}

#[test]
fn a_record_of_something_else_is_refused_with_its_own_error() {
    let good = after::<f32>(Config::robust(), 10).snapshot();
    let with_byte = |at: usize, byte| {
        let mut bad = good;
        bad[at] = byte;
        sealed(bad)
    };
    assert_eq!(refused(&with_byte(0, b'X')), RestoreError::Foreign);
    assert_eq!(refused(&with_byte(5, 1)), RestoreError::Foreign);
    assert_eq!([1, 6, 8].map(|l| refused(&with_byte(4, l))), [1, 6, 8].map(RestoreError::Layout));
    assert_eq!(refused(&with_byte(8, good[8] ^ 1)), RestoreError::OtherRig);
    let factory = FactoryCalibration::<f32>::guess(cameras()).to_record();
    assert_eq!(refused(&factory), RestoreError::Foreign);
    assert_eq!(FactoryCalibration::<f32>::from_record(&good), Err(RestoreError::Foreign));
    let mut other = calibrated(rig([0.1, 0.0, 0.0], [0.0; 2]));
    assert_eq!(other.restore(&good), Err(RestoreError::OtherRig));
    let narrow = Config::robust().with_max_correction_rad(0.01).unwrap();
    assert_eq!(with::<f32, 256>(narrow).restore(&good), Err(RestoreError::Config));
    // A calibrator in the other scalar takes the whole record.
    let mut double = restored::<f64>(Config::robust(), &good);
    assert_eq!(double.state(), State::Suspect);
    take(&mut double, &scene(ROTATION, 60)).unwrap();
    assert_eq!(double.state(), State::Locked);
}

/// Ranges from which the numbers of a record are drawn, from byte 20 on; 0 for a number that is not changed. No range
/// is larger than in `FORMAT.md`, but conditions between numbers, which `FORMAT.md` also states, may be broken.
fn ranges() -> Vec<f32> {
    let calibration = [0.3, 0.3, 0.3, 0.0, 0.0, 0.0, 0.0, 0.0];
    let of = |n: usize, range: f32| vec![range; n];
    let parts = [
        calibration.to_vec(),
        calibration.to_vec(),
        calibration[..6].to_vec(),
        of(15, 1e15),
        of(2, 1e15),
        of(3, 1e15),
        of(30, 1e3),
        vec![16.0, 8.0, 1.0, 1.0, 1e7, 1e7],
        vec![0.0, 0.0, 0.1, 0.1, 1e10, 1e10],
        vec![4.9e-5, 4.9e-5, 1.0, 1.0],
        vec![1.0, 1.0, 1.0, 1.0, 1.0, 0.0],
    ];
    parts.concat()
}

/// A random number within a range, of a magnitude down to 1e-12 of the range.
fn drawn(range: f32, is_signed: bool, rng: &mut ChaCha8Rng) -> f32 {
    let size = range * 10.0_f32.powf(-12.0 * rng.random::<f32>().powi(2));
    if is_signed && rng.random() { -size } else { size }
}

/// Whether a record is accepted. If so, checks that thirty good pairs lead to the truth.
fn recovers(record: &Record, seed: u64) -> bool {
    let mut calibrator = robust::<f32>();
    if calibrator.restore(record).is_err() {
        return false;
    }
    for pair in 0..30 {
        let _ = take(&mut calibrator, &scene(ROTATION, 1000 * seed + pair));
    }
    assert_eq!(calibrator.state(), State::Locked, "{seed}");
    let applied = calibrator.apply();
    assert!(applied.is_ok(), "{seed}: {applied:?}");
    let [r, t] = off(&calibrator.in_use().extrinsics, ROTATION);
    assert!(r < 5e-4 && t < 2e-3, "{seed}: {r} {t}");
    true
}

#[test]
fn after_random_numbers_within_range_thirty_good_pairs_lock_on_the_truth() {
    let good = after::<f32>(Config::robust(), 20).snapshot();
    let ranges = ranges();
    assert_eq!(20 + 4 * ranges.len() + 4, good.len());
    let mut taken = 0;
    for seed in 0..runs(300, 20_000) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut record = good;
        // About one number, a tenth of the numbers, or all are replaced. The diagonal of the information stays
        // positive.
        let share = *[0.01, 0.1, 1.0].choose(&mut rng).unwrap();
        let diagonal = [0, 2, 5, 9, 14];
        for (k, range) in ranges.iter().enumerate() {
            let place = &mut record[20 + 4 * k..24 + 4 * k];
            if *range == 0.0 || !rng.random_bool(share) {
                continue;
            }
            let place: &mut [u8; 4] = place.try_into().unwrap();
            let is_information = (22..37).contains(&k);
            let number = match k {
                _ if is_information && diagonal.contains(&(k - 22)) => drawn(1e15, false, &mut rng),
                // The old value times a factor: with larger elements hardly any draw would be positive definite.
                _ if is_information => f32::from_le_bytes(*place) * rng.random_range(-1.0..1.0),
                40 => 0.0,
                ..22 | 37..=38 | 42..72 | 80 | 81 | 89 | 90 => drawn(*range, true, &mut rng),
                _ => drawn(*range, false, &mut rng),
            };
            *place = number.to_le_bytes();
        }
        taken += u32::from(recovers(&sealed(record), seed));
    }
    println!("{taken} of {} records were taken", runs(300, 20_000));
    assert!(taken > 50, "{taken}");
}

#[test]
fn a_number_out_of_its_range_is_refused() {
    let good = after::<f32>(Config::robust(), 20).snapshot();
    for k in 0..(good.len() - 24) / 4 {
        for number in [f32::NAN, f32::INFINITY, 1e20] {
            let mut bad = good;
            bad[20 + 4 * k..24 + 4 * k].copy_from_slice(&number.to_le_bytes());
            assert_eq!(robust::<f32>().restore(&sealed(bad)), Err(RestoreError::Absurd), "{k}");
        }
    }
}

#[test]
fn a_factory_record_holds_any_lens_and_every_flipped_bit_is_noticed() {
    let lenses = [
        Lens::Pinhole,
        Lens::RadialTangential(RadialTangential::try_new([0.1, -0.2, 1e-3, 2e-3, 0.05]).unwrap()),
        Lens::Fisheye(Fisheye::try_new([0.01, -0.02, 0.03, 0.04]).unwrap()),
        Lens::Rational(Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]).unwrap()),
    ];
    for lens in lenses {
        let Cameras { left, .. } = cameras::<f32>();
        let right = Camera::try_new(*left.intrinsics(), lens).unwrap();
        let (cameras, extrinsics) = (Cameras { left, right }, rig(ROTATION, [0.5, -0.4]));
        let made = FactoryCalibration::new(cameras, extrinsics);
        let known = made.with_yaw_sd_rad(8e-4).unwrap().with_baseline_m(0.12).unwrap();
        for made in [made.without_yaw(), known] {
            let record = made.to_record();
            assert_eq!(FactoryCalibration::from_record(&record), Ok(made));
            for bit in 0..8 * record.len() {
                let mut bad = record;
                bad[bit / 8] ^= 1 << (bit % 8);
                let found = FactoryCalibration::<f32>::from_record(&bad);
                assert_eq!(found, Err(RestoreError::Damaged), "{bit}");
            }
        }
    }
}
