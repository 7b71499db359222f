//! Over a loss of power: what was learnt is resumed bit for bit, and nothing broken is believed.

use crate::api::disturbed::with_outliers;
use crate::api::presets::{robust, with};
use crate::api::scene::{cameras, correspondences, rig, take};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{
    ApplyError, Calibrator, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration,
    Fisheye, Fused, Intrinsics, Lens, RadialTangential, Rational, RestoreError, Scalar,
    SnapshotError, State,
};

pub(crate) const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
pub(crate) const BASELINE: [f64; 2] = [0.5, -0.4];
pub(crate) const KNOCKED: [f64; 3] = [1.4, -0.5, 0.8];

const CRC_32: crc::Crc<u32> = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);

pub(crate) type Tested<T> = Calibrator<T, 256>;

pub(crate) fn scene<T: Scalar>(rotation: [f64; 3], seed: u64) -> Vec<Correspondence<T>> {
    with_outliers(correspondences(&rig(rotation, BASELINE), 250, 0.5, seed), 4)
}

/// After so many pairs of the rig, applied if that can be.
pub(crate) fn after<T: Scalar>(config: Config, pairs: u64) -> Tested<T> {
    let mut calibrator = with(config);
    for seed in 0..pairs {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    let _ = calibrator.apply();
    calibrator
}

pub(crate) fn record<T: Scalar>(calibrator: &Tested<T>) -> Vec<u8> {
    let mut buffer = vec![0xa5; Tested::<T>::SNAPSHOT_BYTES];
    calibrator.snapshot(&mut buffer).unwrap().to_vec()
}

/// A fresh calibrator of the same rig that has read the record.
pub(crate) fn restored<T: Scalar>(
    config: Config,
    record: &[u8],
) -> Result<Tested<T>, RestoreError> {
    let mut fresh = with(config);
    fresh.restore(record)?;
    Ok(fresh)
}

/// The checksum at the end made right again.
pub(crate) fn resealed(mut record: Vec<u8>) -> Vec<u8> {
    let body = record.len() - 4;
    let sum = CRC_32.checksum(&record[..body]);
    record[body..].copy_from_slice(&sum.to_le_bytes());
    record
}

/// What a restored calibrator makes of further pairs is what the one without a break makes of them.
fn resumes<T: Scalar>(config: Config, mut before: Tested<T>, next: [f64; 3]) {
    let mut after = restored(config, &record(&before)).unwrap();
    assert_eq!(after.in_use(), before.in_use());
    assert_eq!(after.generation(), before.generation());
    for seed in 100..112 {
        let matches = scene(next, seed);
        assert_eq!(take(&mut after, &matches), take(&mut before, &matches), "{seed}");
        assert_eq!(after.proposal(), before.proposal(), "{seed}");
    }
    assert_eq!(after.state(), before.state());
    assert_eq!(record(&after), record(&before));
    assert_eq!(after.undo(), before.undo());
}

#[test]
fn the_estimate_goes_on_as_without_a_break_bit_for_bit() {
    let robust = Config::robust();
    resumes::<f32>(robust, after(robust, 12), ROTATION);
    resumes::<f64>(robust, after(robust, 12), ROTATION);
    resumes::<f32>(robust, after(robust, 12), KNOCKED);
    // Acquiring, and before the first pair.
    resumes::<f32>(robust, after(robust, 2), ROTATION);
    resumes::<f32>(robust, after(robust, 0), ROTATION);
    for angle in [stereo_selfcal::Central::Mean, stereo_selfcal::Central::Median] {
        let paper = Config::paper().with_angle(angle);
        let mut calibrator = with::<f32>(paper);
        for seed in 0..40 {
            let clean = correspondences(&rig(ROTATION, BASELINE), 200, 0.5, seed);
            take(&mut calibrator, &clean).unwrap();
        }
        calibrator.apply().unwrap();
        resumes(paper, calibrator, ROTATION);
    }
}

#[test]
fn a_challenger_survives_and_takes_over_as_without_a_break() {
    let mut knocked = after::<f32>(Config::robust(), 10);
    for seed in 50..52 {
        take(&mut knocked, &scene(KNOCKED, seed)).unwrap();
    }
    assert_eq!(knocked.state(), State::Suspect);
    resumes(Config::robust(), knocked, KNOCKED);
}

#[test]
fn a_drift_that_was_followed_is_remembered() {
    let [mut x, y, z] = ROTATION;
    let mut drifting = after::<f32>(Config::robust(), 10);
    for seed in 200..300 {
        x += 0.01;
        if take(&mut drifting, &scene([x, y, z], seed)) == Ok(Fused::Renewed) {
            return resumes(Config::robust(), drifting, [x, y, z]);
        }
    }
    panic!("the drift was not noticed");
}

#[test]
fn the_estimate_is_suspect_and_not_applied_until_a_pair_confirms_it() {
    for config in [Config::robust(), Config::paper()] {
        let old = after::<f32>(config, 10);
        assert_eq!(old.state(), State::Locked);
        let mut new = restored::<f32>(config, &record(&old)).unwrap();
        assert_eq!(new.state(), State::Suspect);
        assert_eq!(new.apply(), Err(ApplyError::NotLocked(State::Suspect)));
        take(&mut new, &scene(ROTATION, 60)).unwrap();
        assert_eq!(new.state(), State::Locked);
    }
}

#[test]
fn a_standing_vehicle_does_not_count_its_scene_again_after_a_break() {
    let mut parked = after::<f32>(Config::robust(), 10);
    let view = scene(ROTATION, 80);
    assert_eq!(take(&mut parked, &view), Ok(Fused::Added));
    let pairs = parked.proposal().unwrap().pairs;
    for _ in 0..3 {
        parked = restored(Config::robust(), &record(&parked)).unwrap();
        assert_eq!(take(&mut parked, &view), Ok(Fused::Repeated));
        assert_eq!(parked.proposal().unwrap().pairs, pairs);
    }
}

#[test]
fn a_lost_estimate_comes_back_as_a_suspect_one() {
    let mut lost = after::<f32>(Config::robust(), 10);
    for seed in 0..12 {
        let _ = take(&mut lost, &crate::api::disturbed::garbage(200, seed));
    }
    assert_eq!(lost.state(), State::Lost);
    assert_eq!(restored::<f32>(Config::robust(), &record(&lost)).unwrap().state(), State::Suspect);
}

#[test]
fn frozen_and_undo_survive_and_the_generation_tells_of_a_change() {
    let mut old = after::<f32>(Config::robust(), 10);
    old.set_frozen(true);
    let mut new = restored::<f32>(Config::robust(), &record(&old)).unwrap();
    assert!(new.is_frozen());
    assert_ne!(new.generation(), robust::<f32>().generation());
    new.set_frozen(false);
    assert_eq!(new.undo().unwrap().extrinsics, Extrinsics::SIDE_BY_SIDE);
    // Two changes here and two there, to different extrinsics.
    old.set_frozen(false);
    take(&mut old, &scene(ROTATION, 70)).unwrap();
    old.apply().unwrap();
    let mut fresh = robust::<f32>();
    fresh.set_factory(rig([0.1, 0.0, 0.0], [0.0; 2]));
    fresh.set_factory(Extrinsics::SIDE_BY_SIDE);
    assert_eq!([old.generation(), fresh.generation()], [2, 2]);
    fresh.restore(&record(&old)).unwrap();
    assert_eq!((fresh.generation(), fresh.in_use()), (3, old.in_use()));
}

#[test]
fn the_longest_record_takes_as_many_bytes_as_it_says() {
    let mut suspect = after::<f32>(Config::robust(), 10);
    take(&mut suspect, &scene(KNOCKED, 50)).unwrap();
    assert_eq!(record(&suspect).len(), Tested::<f32>::SNAPSHOT_BYTES);
    assert_eq!(Tested::<f32>::SNAPSHOT_BYTES, 4240);
    let mut wide = after::<f64>(Config::robust(), 10);
    take(&mut wide, &scene(KNOCKED, 50)).unwrap();
    assert_eq!(record(&wide).len(), Tested::<f64>::SNAPSHOT_BYTES);
    let needed = Tested::<f32>::SNAPSHOT_BYTES;
    for room in [0, 3, 11, 12, 100, needed - 5, needed - 1] {
        let room = &mut vec![0; room];
        assert_eq!(suspect.snapshot(room), Err(SnapshotError::Room { needed }));
    }
    let without = Tested::<f32>::new(Config::robust());
    assert_eq!(without.snapshot(&mut []), Err(SnapshotError::NoCameras));
}

#[test]
fn any_wrong_bit_and_any_missing_or_further_byte_is_refused() {
    let good = record(&after::<f32>(Config::robust(), 6));
    let fresh = robust::<f32>();
    let refused = |bytes: &[u8]| {
        let mut tried = fresh.clone();
        assert_eq!(tried.restore(bytes), Err(RestoreError::Damaged));
        assert_eq!((tried.proposal(), tried.in_use()), (None, fresh.in_use()));
        assert_eq!(tried.generation(), fresh.generation());
    };
    for bit in 0..8 * good.len() {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        refused(&bad);
    }
    for length in 0..good.len() {
        refused(&good[..length]);
    }
    let longer = [&good[..good.len() - 4], &[0; 8]].concat();
    refused(&resealed(longer));
    let shorter = good[..good.len() - 4].to_vec();
    refused(&resealed(shorter));
}

/// Every word of a record replaced by numbers that cannot be: how many were believed, of those that are
/// not finite and of those that are.
fn believed(config: Config, good: &[u8], words: core::ops::Range<usize>) -> [usize; 2] {
    let mut believed = [0; 2];
    for at in words.step_by(4) {
        for absurd in [f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, 1e30, -1e9] {
            let mut bad = good.to_vec();
            bad[at..at + 4].copy_from_slice(&absurd.to_le_bytes());
            let Ok(mut read) = restored::<f32>(config, &resealed(bad)) else { continue };
            believed[usize::from(absurd.is_finite())] += 1;
            for seed in 60..64 {
                let _ = take(&mut read, &scene(ROTATION, seed));
                let Some(proposal) = read.proposal() else { continue };
                let sd = proposal.sd;
                assert!(sd.rotation.is_finite() && sd.translation.is_finite(), "{at} {absurd}");
            }
        }
    }
    believed
}

#[test]
fn what_cannot_be_is_refused_though_its_checksum_is_right() {
    let mut suspect = after::<f32>(Config::robust(), 6);
    take(&mut suspect, &scene(KNOCKED, 50)).unwrap();
    let good = record(&suspect);
    // Without the scene of the last pair, which may be anything.
    let vibration = good.len() - 4 - 4 * (114 + 9);
    let words = 12..vibration - 4 * 49;
    let [not_finite, large] = believed(Config::robust(), &good, words.clone());
    // Counts, whose bits may be any; a drift, a sum off the diagonal: large, and possible.
    assert!(not_finite <= 2 * 15, "{not_finite}");
    assert!(large < words.len() * 3 / 4, "{large}");
    // Samples, variances, the last two pairs, mount and lens: none that is not finite.
    let [not_finite, _] = believed(Config::robust(), &good, vibration..good.len() - 4);
    assert_eq!(not_finite, 0);

    for pairs in [1, 2] {
        let mut one = with::<f32>(Config::paper());
        for seed in 0..pairs {
            take(&mut one, &correspondences(&rig(ROTATION, BASELINE), 200, 0.5, seed)).unwrap();
        }
        let good = record(&one);
        let counts = believed(Config::paper(), &good, 12..good.len() - 4);
        // The same, and the deviations of the first pair.
        assert!(counts[0] <= 2 * 5 && counts[1] <= 40, "{counts:?}");
    }
}

/// Written by older firmware: ten pairs of the rig, and one of a knocked one. Version 1 has no scene of the last
/// pair, 1 and 2 have no noise of disparities, 4 has no second crowd.
const OLDER: [&[u8]; 3] = [
    include_bytes!("records/version_1.bin"),
    include_bytes!("records/version_2.bin"),
    include_bytes!("records/version_4.bin"),
];

#[test]
fn records_of_older_layouts_are_read() {
    for (version, record) in [1_u8, 2, 4].into_iter().zip(OLDER) {
        assert_eq!(record[4], version);
        let mut read = restored::<f32>(Config::robust(), record).unwrap();
        assert_eq!((read.state(), read.generation()), (State::Suspect, 1));
        let proposal = read.proposal().unwrap();
        let off = Deviation::between(&proposal.extrinsics, &rig(ROTATION, BASELINE));
        assert_eq!((proposal.pairs, proposal.baseline_observed), (10, true));
        assert!(off.rotation < 2e-4 && off.translation < 1e-3, "{off:?}");
        // In near scenes the noise of disparities, set from the noise, takes next to nothing away.
        assert!(proposal.sd.rotation < 2e-4 && proposal.sd.translation < 6e-4, "{proposal:?}");
        // The sums of the record go on with the same rig.
        let mut same = restored::<f32>(Config::robust(), record).unwrap();
        take(&mut same, &scene(ROTATION, 61)).unwrap();
        let next = same.proposal().unwrap();
        assert_eq!(next.pairs, 11);
        let [before, after] = [&proposal, &next].map(|p| [p.sd.rotation, p.sd.translation]);
        for (after, before) in after.into_iter().zip(before) {
            assert!((0.8..1.0).contains(&(after / before)), "{after} {before}");
        }
        // Two more of the knocked rig make three with that of the record.
        for seed in 51..53 {
            take(&mut read, &scene(KNOCKED, seed)).unwrap();
        }
        assert_eq!((read.state(), read.proposal().unwrap().pairs), (State::Locked, 3));
    }
}

#[test]
fn a_record_of_something_else_is_refused_by_what_is_different() {
    let good = record(&after::<f32>(Config::robust(), 6));
    let error = |calibrator: &mut Tested<f32>, record: &[u8]| calibrator.restore(record).err();
    assert_eq!(restored::<f64>(Config::robust(), &good).err(), Some(RestoreError::Scalar));
    assert_eq!(restored::<f32>(Config::paper(), &good).err(), Some(RestoreError::Preset));
    let mut other = robust::<f32>();
    other.set_factory(rig([0.1, 0.0, 0.0], [0.0; 2]));
    assert_eq!(error(&mut other, &good), Some(RestoreError::OtherRig));
    let mut other = robust::<f32>();
    let mut intrinsics: Intrinsics<f32> = *cameras().left.intrinsics();
    intrinsics.principal[0] += 0.5;
    let left = stereo_selfcal::Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    other.set_cameras(Cameras { left, ..cameras() });
    assert_eq!(error(&mut other, &good), Some(RestoreError::OtherRig));
    let mut bare = Tested::new(Config::robust());
    assert_eq!(error(&mut bare, &good), Some(RestoreError::NoCameras));
    let mut experienced = after::<f32>(Config::robust(), 1);
    let before = experienced.proposal();
    assert_eq!(error(&mut experienced, &good), Some(RestoreError::NotFresh));
    assert_eq!(experienced.proposal(), before);
    let narrow = Config::robust().with_max_correction_rad(0.001).unwrap();
    assert_eq!(restored::<f32>(narrow, &good).err(), Some(RestoreError::CorrectionLimit));
    for version in [0, 99] {
        let mut later = good.clone();
        later[4] = version;
        let later = resealed(later);
        assert_eq!(error(&mut robust(), &later), Some(RestoreError::Version(version)));
    }
    let made =
        FactoryCalibration::<f32> { cameras: cameras(), extrinsics: Extrinsics::SIDE_BY_SIDE };
    let mut buffer = [0; FactoryCalibration::<f32>::MAX_BYTES];
    let factory = made.to_record(&mut buffer).unwrap();
    assert_eq!(error(&mut robust(), factory), Some(RestoreError::Foreign));
    assert_eq!(FactoryCalibration::<f32>::from_record(&good), Err(RestoreError::Foreign));
}

#[test]
fn a_factory_calibration_comes_back_as_it_was_with_any_lens() {
    let lenses = [
        Lens::Pinhole,
        Lens::RadialTangential(RadialTangential::try_new([-0.3, 0.1, 1e-3, -2e-3, 0.01]).unwrap()),
        Lens::Fisheye(Fisheye::try_new([0.01, -0.02, 0.003, 1e-4]).unwrap()),
        Lens::Rational(Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]).unwrap()),
    ];
    for left in lenses {
        for right in lenses {
            let camera =
                |lens| stereo_selfcal::Camera::try_new(*cameras::<f32>().left.intrinsics(), lens);
            let cameras = Cameras { left: camera(left).unwrap(), right: camera(right).unwrap() };
            let made = FactoryCalibration { cameras, extrinsics: rig(ROTATION, BASELINE) };
            let mut buffer = [0; FactoryCalibration::<f32>::MAX_BYTES];
            let record = made.to_record(&mut buffer).unwrap();
            assert_eq!(FactoryCalibration::from_record(record), Ok(made));
            for at in 0..record.len() {
                let mut bad = record.to_vec();
                bad[at] ^= 0x10;
                assert_eq!(
                    FactoryCalibration::<f32>::from_record(&bad),
                    Err(RestoreError::Damaged)
                );
            }
            let needed = record.len();
            let error = made.to_record(&mut buffer[..needed - 1]).err();
            assert_eq!(error, Some(SnapshotError::Room { needed }));
        }
    }
    assert_eq!(
        [FactoryCalibration::<f32>::MAX_BYTES, FactoryCalibration::<f64>::MAX_BYTES],
        [184, 328]
    );
}
