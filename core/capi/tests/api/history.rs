//! Events of C against the core's history.

use std::mem::MaybeUninit;

use stereo_selfcal::outcome::{Change, Event, History};
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};
use stereo_selfcal_capi::selfcal_error_t::SELFCAL_OK;
use stereo_selfcal_capi::*;

use crate::life::{Twin, bits};
use crate::rig::{Cal, get, pair, recorded};

/// The event of a calibrator, if there is a new one.
fn next(cal: &mut Cal, time: u64, pair: u32, event: &mut selfcal_event_t) -> bool {
    let mut changed = MaybeUninit::uninit();
    // SAFETY: live objects.
    let code = unsafe { selfcal_event(cal.ptr(), time, pair, event, changed.as_mut_ptr()) };
    assert_eq!(code, SELFCAL_OK);
    // SAFETY: written without an error.
    unsafe { changed.assume_init() }
}

fn assert_same(c: &selfcal_event_t, rust: &Event<f32>) {
    let verdict = &rust.verdict;
    assert_eq!((c.time, c.pair, c.generation), (rust.time, rust.pair, rust.generation));
    assert_eq!(c.changes, u32::from(rust.changes.bits()));
    assert_eq!(c.state, selfcal_state_t::from(verdict.state) as u32);
    assert_eq!(c.cause, selfcal_cause_t::from(verdict.cause) as u32);
    assert_eq!(c.reasons, u32::from(verdict.reasons.bits()) << 16);
    assert_eq!([c.may_arm, c.should_apply], [verdict.may_arm, verdict.should_apply].map(u32::from));
    assert_eq!(
        bits(&[c.rows_px, c.depth_px, c.coverage, c.image_coverage]),
        bits(&[verdict.rows_px, verdict.depth_px, verdict.coverage, verdict.image_coverage])
    );
}

#[test]
fn every_change_of_a_rig_is_the_event_of_the_history() {
    let set = recorded();
    let mut cal = Cal::new();
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    let mut twin: Twin = Calibrator::new(Config::default(), &factory);
    let mut history = History::<f32, 64>::new();
    let mut event = selfcal_event_t::default();
    for index in 0..set.pairs.len() {
        let (c, rust) = pair(&set, index);
        let _ = get!(cal, selfcal_take_pair, c.as_ptr(), c.len());
        let _ = twin.take_pair(rust);
        if twin.verdict().should_apply {
            twin.apply().unwrap();
            get!(cal, selfcal_apply).unwrap();
        }
        let number = u32::try_from(index).unwrap();
        let time = u64::from(number) * 100;
        let before = event;
        let changed = next(&mut cal, time, number, &mut event);
        match history.note(time, number, twin.verdict(), twin.in_use().generation) {
            Some(rust) => assert_same(&event, &rust),
            None => assert_eq!(event, before),
        }
        assert_eq!(changed, history.events().last().is_some_and(|last| last.pair == number));
    }
    assert!(history.total() >= 3, "{}", history.total());
}

#[test]
fn the_changes_have_the_bits_of_the_core() {
    use selfcal_change_t::*;
    let of_c = [
        SELFCAL_CHANGE_STATE,
        SELFCAL_CHANGE_ARMING,
        SELFCAL_CHANGE_APPLYING,
        SELFCAL_CHANGE_REASONS,
        SELFCAL_CHANGE_CAUSE,
        SELFCAL_CHANGE_GENERATION,
    ];
    assert_eq!(of_c.map(|bit| bit as u32), Change::ALL.map(|change| u32::from(change.code())));
}
