//! Each number of a record changed alone, its checksum made right again: refused, or without harm.

use crate::api::memory::{
    BASELINE, KNOCKED, ROTATION, Tested, after, record, resealed, restored, scene,
};
use crate::api::scene::{rig, take};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Config, Correspondence, Extrinsics, RestoreError, State};
use test_support::runs;

/// Pairs of the same rig after which nothing of a wrong number may be left.
const PAIRS: u64 = 30;

/// A number and what broken hardware makes of it.
fn changes(of: f32) -> [f32; 12] {
    let [large, small] = [of * 1e6, of * 1e-6];
    [large, small, -of, 0.0, 1.0, 2.5, 1e6, 1e30, -1e30, f32::NAN, f32::INFINITY, -f32::INFINITY]
}

/// Whether an estimate is a rig: finite, and within the limit of corrections.
fn is_rig(read: &Tested<f32>) -> bool {
    let limit = 0.5;
    read.proposal().is_none_or(|proposal| {
        let off = Deviation::between(&proposal.extrinsics, &Extrinsics::SIDE_BY_SIDE);
        let sd = [proposal.sd, proposal.sd_lens];
        off.rotation <= limit
            && off.translation <= limit
            && sd.iter().all(|sd| sd.rotation.is_finite() && sd.translation.is_finite())
    })
}

/// What is wrong after good pairs; `None`: nothing.
fn harm(mut read: Tested<f32>, good: &[Vec<Correspondence<f32>>], whole: bool) -> Option<String> {
    for (k, matches) in good.iter().enumerate() {
        if !is_rig(&read) {
            return Some(format!("no rig after {k} pairs: {:?}", read.proposal()));
        }
        let _ = take(&mut read, matches);
    }
    if !whole {
        return (!is_rig(&read)).then(|| format!("no rig: {:?}", read.proposal()));
    }
    if read.state() != State::Locked {
        return Some(format!("{:?}", read.state()));
    }
    let Some(proposal) = read.proposal() else { return Some("no proposal".into()) };
    let off = Deviation::between(&proposal.extrinsics, &rig(ROTATION, BASELINE));
    let within = off.rotation <= 5.0 * proposal.sd.rotation
        && off.translation <= 5.0 * proposal.sd.translation;
    (!within).then(|| format!("{off:?} {:?}", proposal.sd))
}

/// Changes of each number of a record alone: how many are refused, and how many are not.
fn try_all(config: Config, record: &[u8]) -> [usize; 2] {
    let good: Vec<_> = (0..PAIRS).map(|k| scene(ROTATION, 300 + k)).collect();
    let mut counts = [0; 2];
    for at in (12..record.len() - 4).step_by(4) {
        let bytes: [u8; 4] = record[at..at + 4].try_into().unwrap();
        let old = f32::from_le_bytes(bytes);
        for new in changes(old).into_iter().filter(|new| new.to_le_bytes() != bytes) {
            let mut bad = record.to_vec();
            bad[at..at + 4].copy_from_slice(&new.to_le_bytes());
            let read = restored::<f32>(config, &resealed(bad));
            counts[usize::from(read.is_ok())] += 1;
            // In a campaign, all; otherwise the rest must be rigs.
            let drive = counts[1] % runs(12, 1) == 0;
            let harmed = read
                .ok()
                .and_then(|read| harm(read, if drive { &good } else { &good[..1] }, drive));
            assert_eq!(harmed, None, "number {} from {old:e} to {new:e}", at / 4 - 3);
        }
    }
    counts
}

#[test]
fn a_number_changed_alone_is_refused_or_forgotten_after_good_pairs() {
    let config = Config::robust();
    let locked = after::<f32>(config, 12);
    assert_eq!(harm(locked.clone(), &[], true), None);
    let [refused, harmless] = try_all(config, &record(&locked));
    assert!(refused > 3000 && harmless > 3000, "{refused} {harmless}");
}

#[test]
fn a_number_of_a_challenger_changed_alone_is_refused_or_forgotten_after_good_pairs() {
    let config = Config::robust();
    let mut knocked = after::<f32>(config, 10);
    for seed in 50..52 {
        take(&mut knocked, &scene(KNOCKED, seed)).unwrap();
    }
    let [refused, harmless] = try_all(config, &record(&knocked));
    assert!(refused > 5000 && harmless > 4000, "{refused} {harmless}");
}

#[test]
fn extrinsics_in_use_beyond_the_correction_limit_are_refused() {
    let config = Config::robust();
    let good = record(&after::<f32>(config, 12));
    // Of what is in use, and of what was before.
    for first in [0, 15] {
        let restore = |turn: [f64; 3], baseline: [f64; 2]| {
            let put: Extrinsics<f32> = rig(turn, baseline);
            let numbers = put.rotation().matrix().iter().chain(put.translation().iter());
            let mut record = good.clone();
            for (k, number) in numbers.enumerate() {
                let at = 12 + 4 * (first + k);
                record[at..at + 4].copy_from_slice(&number.to_le_bytes());
            }
            restored::<f32>(config, &resealed(record)).map(|_| ())
        };
        assert_eq!(restore([20.0, -15.0, 5.0], [-20.0, 20.0]), Ok(()), "{first}");
        for wrong in [70.0, -70.0, 170.0] {
            let limit = Err(RestoreError::CorrectionLimit);
            assert_eq!(restore([0.0, wrong, 0.0], [0.0; 2]), limit, "{first} {wrong}");
            assert_eq!(restore([0.0; 3], [0.0, wrong]), limit, "{first} {wrong}");
        }
    }
}
