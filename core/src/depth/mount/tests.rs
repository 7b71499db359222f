use super::*;
use crate::algebra::normal_equations::tests::normal;
use crate::config::Config;
use crate::geometry::extrinsics::Extrinsics;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const LENS: f64 = 0.005;
const KNOCK: f64 = 0.0175;
const NOISE: f64 = 4e-4;
/// Scatter of a lens that its model does not describe.
const SCATTER: f64 = 2e-3;

fn rows(turn: f64) -> RowsYaw<f64> {
    RowsYaw { turn, variance: NOISE * NOISE }
}

/// Calls a function with a context, and a commissioned rig after a number of pairs.
fn after<R>(pairs: u32, run: impl FnOnce(MountYaw<f64>, &Context<'_, f64>) -> R) -> R {
    let (config, factory) = (Config::robust(), Extrinsics::SIDE_BY_SIDE);
    let context = Context::new(&config, &factory, 1400.0);
    let mut mount = MountYaw::new(true);
    (0..pairs).for_each(|_| mount.add(&rows(LENS), &context));
    run(mount, &context)
}

#[test]
fn a_knock_between_pairs_is_a_turn_of_the_mount_and_not_of_the_lens() {
    after(40, |mut mount, context| {
        let before = mount.reported(&rows(LENS), context);
        assert!((before.lens - LENS).abs() < 4e-4, "{before:?}");
        for late in 1..20 {
            mount.add(&rows(LENS + KNOCK), context);
            // The fused rows do not show the knock yet.
            let after = mount.reported(&rows(LENS), context);
            let [turn, lens] = [after.mount.unwrap() - KNOCK, after.lens - before.lens];
            assert!(turn.abs() < if late < 3 { 2e-3 } else { 8e-4 }, "{late}: {turn}");
            assert!(lens.abs() < 2e-4, "{late}: {lens}");
        }
    });
}

#[test]
fn a_single_wrong_witness_waits_before_and_after_a_knock_and_right_ones_are_taken() {
    for knock in [0.0, KNOCK] {
        after(20, |mut mount, context| {
            for _ in 0..5 {
                assert_eq!(mount.witness(0.0, 1e-7, &rows(LENS), context), Some(Witnessed::Taken));
            }
            let now = rows(LENS + knock);
            (0..20).for_each(|_| mount.add(&now, context));
            let wrong = mount.witness(knock - 0.008, 1e-7, &now, context);
            assert_eq!(wrong, Some(Witnessed::Waiting), "{knock}");
            let right = [(); 3].map(|()| mount.witness(knock, 1e-7, &now, context));
            assert_eq!(right, [Some(Witnessed::Taken); 3], "{knock}");
            let yaw = mount.reported(&now, context);
            let off = yaw.mount.unwrap() - knock;
            assert!(off.abs() < 5e-4 && yaw.variance < 1e-6, "{knock}: {off} {yaw:?}");
        });
    }
}

#[test]
fn after_a_restart_a_confirmed_yaw_needs_three_contradictions_and_an_unconfirmed_one_does_not() {
    for confirmed in [false, true] {
        after(20, |mut mount, context| {
            if confirmed {
                mount.witness(0.0, 1e-7, &rows(LENS), context).unwrap();
            }
            let (numbers, is_known) = mount.parts();
            mount.reset();
            mount.resume(numbers, is_known).unwrap();
            let wrong =
                [(); 3].map(|()| mount.witness(-0.008, 1e-7, &rows(LENS), context).unwrap());
            let waits = wrong.iter().filter(|found| **found == Witnessed::Waiting).count();
            assert_eq!(waits >= 2, confirmed, "{wrong:?}");
        });
    }
}

#[test]
fn rows_that_no_lens_explains_refute_the_factory_yaw_for_good() {
    after(0, |mut mount, context| {
        let far = rows(0.03);
        assert!(mount.reported(&rows(LENS), context).mount.is_some());
        for _ in 0..3 {
            mount.add(&far, context);
            let yaw = mount.reported(&far, context);
            assert!(yaw.mount.is_none() && yaw.lens == 0.0, "{yaw:?}");
            let (numbers, is_known) = mount.parts();
            let mut restored = MountYaw::new(true);
            restored.resume(numbers, is_known).unwrap();
            restored.add(&rows(0.0), context);
            assert!(restored.reported(&rows(0.0), context).mount.is_none());
        }
    });
}

#[test]
fn another_lens_correction_keeps_the_mount_and_forgets_the_lens() {
    after(30, |mut mount, context| {
        mount.witness(1e-3, 1e-7, &rows(LENS), context).unwrap();
        let before = mount.reported(&rows(LENS), context);
        mount.change_lens(context);
        (0..5).for_each(|_| mount.add(&rows(-0.004), context));
        let after = mount.reported(&rows(-0.004), context);
        assert!((after.mount.unwrap() - before.mount.unwrap()).abs() < 2e-4, "{after:?}");
        assert!((after.lens + 0.004 + after.mount.unwrap()).abs() < 2e-4, "{after:?}");
    });
}

#[test]
fn a_pair_that_shows_no_yaw_changes_nothing() {
    after(20, |mut mount, context| {
        let before = mount;
        for bad in [f64::NAN, f64::INFINITY] {
            mount.add(&RowsYaw { turn: bad, variance: 1e-7 }, context);
            mount.add(&RowsYaw { turn: 0.1, variance: bad }, context);
        }
        assert_eq!(mount, before);
        mount.add(&RowsYaw { turn: 0.1, variance: 1.0 }, context);
        let [then, now] = [before, mount].map(|of| of.reported(&rows(LENS), context));
        assert!((now.mount.unwrap() - then.mount.unwrap()).abs() < 1e-5, "{now:?}");
    });
}

#[test]
fn a_lens_that_moves_the_yaw_from_scene_to_scene_hardly_moves_the_mount() {
    let (runs, pairs) = (10_u32, 500_u32);
    let [mut turned, mut squares] = [0.0_f64; 2];
    for seed in 0..runs {
        let mut rng = ChaCha8Rng::seed_from_u64(u64::from(seed));
        after(0, |mut mount, context| {
            let mut in_use = 0.0;
            for _ in 0..pairs {
                mount.add(&rows(LENS + SCATTER * normal(&mut rng)), context);
                let now = mount.reported(&rows(LENS), context);
                squares += now.mount.unwrap().powi(2);
                if now.has_turned_from(in_use) {
                    (in_use, turned) = (now.mount.unwrap(), turned + 1.0);
                }
            }
        });
    }
    let all = f64::from(runs * pairs);
    let [turned, rms] = [turned / all, (squares / all).sqrt()];
    assert!(turned < 0.15 && rms < 1.7e-3, "{turned} {rms}");
}

#[test]
fn a_knock_turns_the_mount_although_the_lens_moves_the_yaw_from_scene_to_scene() {
    for seed in 0..10 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        after(0, |mut mount, context| {
            for pair in 0..210 {
                let knock = if pair < 200 { 0.0 } else { KNOCK };
                mount.add(&rows(LENS + knock + SCATTER * normal(&mut rng)), context);
            }
            let yaw = mount.reported(&rows(LENS), context);
            let off = yaw.mount.unwrap() - KNOCK;
            assert!(off.abs() < 4e-3 && off * off < 9.0 * yaw.variance, "{seed}: {off} {yaw:?}");
        });
    }
}
