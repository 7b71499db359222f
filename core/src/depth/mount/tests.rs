use super::*;
use crate::config::Config;
use crate::geometry::extrinsics::Extrinsics;

const LENS: f64 = 0.005;
const KNOCK: f64 = 0.0175;
const NOISE: f64 = 2e-3;

/// Returns the yaw that the rows show over `pairs` pairs, of which the last `knocked` pairs follow a knock. It is the
/// mean over the pairs, because nothing has detected the knock.
fn rows(pairs: u32, knocked: u32) -> RowsYaw<f64> {
    let [all, part] = [pairs, knocked].map(f64::from);
    RowsYaw { turn: LENS + KNOCK * part / all, variance: NOISE * NOISE / all }
}

#[test]
fn a_knock_that_is_in_the_sums_before_its_detection_counts_as_a_turn_of_the_mount() {
    let (config, factory) = (Config::robust(), Extrinsics::SIDE_BY_SIDE);
    let context = Context::new(&config, &factory, 1400.0);
    // The estimate attributes nearly all of this yaw to the lens, and the rest to the mount.
    let share = MountYaw::CALIBRATED.with_rows(&rows(40, 0), &context).lens();
    assert!((share - LENS).abs() < 4e-4, "{share}");
    for late in [3, 8, 15, 20] {
        let mut mount = MountYaw::CALIBRATED;
        (1..40).for_each(|pairs| mount.note(|| Some(rows(pairs, 0)), &context));
        (1..=late).for_each(|n| mount.note(|| Some(rows(40 + n, n)), &context));
        // Even before the detection, a turn of the rows beyond chance counts as a turn of the mount.
        let before = mount.with_rows(&rows(40 + late, late), &context);
        assert!((before.lens() - LENS).abs() < 1e-3, "{late}: {before:?}");
        mount.change(&rows(40 + late, late), &context);
        let after = mount.with_rows(&rows(20, 20), &context);
        let (turn, lens) = (after.mount() - KNOCK, after.lens() - LENS);
        assert!(turn.abs() < 8e-4 && lens.abs() < 8e-4, "{late}: {turn} {lens}");
    }
}

#[test]
fn witness_measurements_from_before_a_turn_of_the_mount_support_no_yaw_after_it() {
    let (config, factory) = (Config::robust(), Extrinsics::SIDE_BY_SIDE);
    let context = Context::new(&config, &factory, 1400.0);
    let before = rows(20, 0);
    for turns in [false, true] {
        let mut mount = MountYaw::CALIBRATED;
        for _ in 0..5 {
            assert_eq!(mount.witness(0.0, 1e-7, &before, &context), Some(Witnessed::Taken));
        }
        if turns {
            mount.change(&before, &context);
        }
        let rows = if turns { rows(20, 20) } else { before };
        let yaw = if turns { KNOCK } else { 0.0 };
        // One wrong measurement, then right ones.
        let wrong = mount.witness(yaw - 0.008, 1e-7, &rows, &context);
        assert_eq!(wrong, Some(if turns { Witnessed::Taken } else { Witnessed::Waiting }));
        let right = [(); 3].map(|()| mount.witness(yaw, 1e-7, &rows, &context));
        assert_eq!(right[2], Some(Witnessed::Taken), "{turns}: {right:?}");
        let off = mount.with_rows(&rows, &context).mount() - yaw;
        assert!(off.abs() < 1e-3, "{turns}: {off}");
    }
}

#[test]
fn after_a_restart_a_confirmed_yaw_needs_three_contradictions_and_an_unconfirmed_one_does_not() {
    let (config, factory) = (Config::robust(), Extrinsics::SIDE_BY_SIDE);
    let context = Context::new(&config, &factory, 1400.0);
    let rows = rows(20, 0);
    for confirmed in [false, true] {
        let mut mount = MountYaw::CALIBRATED;
        if confirmed {
            mount.witness(0.0, 1e-7, &rows, &context).unwrap();
        }
        let (numbers, flags) = mount.parts();
        mount.reset();
        mount.resume(numbers, flags).unwrap();
        let wrong = [(); 3].map(|()| mount.witness(-0.008, 1e-7, &rows, &context).unwrap());
        let waits = wrong.iter().filter(|found| **found == Witnessed::Waiting).count();
        assert_eq!(waits >= 2, confirmed, "{wrong:?}");
    }
}

#[test]
fn rows_within_chance_of_the_earlier_rows_do_not_turn_the_mount() {
    let (config, factory) = (Config::robust(), Extrinsics::SIDE_BY_SIDE);
    let context = Context::new(&config, &factory, 1400.0);
    let mut mount = MountYaw::CALIBRATED;
    (1..80).for_each(|pairs| mount.note(|| Some(rows(pairs, 0)), &context));
    let known = mount.with_rows(&rows(80, 0), &context);
    for sign in [-1.0, 1.0] {
        let off = RowsYaw { turn: LENS + sign * 5e-4, ..rows(80, 0) };
        let yaw = mount.with_rows(&off, &context);
        assert!((yaw.mount() - known.mount()).abs() < 1e-4, "{yaw:?} {known:?}");
    }
}
