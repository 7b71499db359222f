//! Calibrator under loss of power at every word that its saves write.

use core::time::Duration;

use stereo_selfcal::store::{Persistence, ResumeError, SavePolicy, SaveReason};
use stereo_selfcal::{
    Calibrator, Config, Extrinsics, FactoryCalibration, Proposal, RestoreError, State,
};
use test_support::flash::{Fault, Flash, TEARS};

use crate::api::scene::{cameras, correspondences, rig, take};
use crate::store::rig::open;

const WORD: usize = 8;
const BLOCK: usize = 8192;

type Nor = Flash<WORD, BLOCK>;
type Controller = Calibrator<f32, 256>;

/// State that a restart must restore: extrinsics in use, their generation, the estimate.
type Memory = (Extrinsics<f32>, u32, Option<Proposal<f32>>);

fn memory(calibrator: &Controller) -> Memory {
    // The state is suspect after a restart: not compared.
    let proposal = calibrator.proposal().map(|p| {
        let mut p = p;
        p.state = State::Suspect;
        p
    });
    (*calibrator.in_use(), calibrator.generation(), proposal)
}

fn persistence(flash: Nor) -> Persistence<Nor, f32> {
    let policy = SavePolicy::new().with_shortest_interval(Duration::from_secs(1)).unwrap();
    Persistence::new(open(flash, 1), policy)
}

/// Starts a controller.
fn boot(
    persistence: &mut Persistence<Nor, f32>,
) -> (Box<Controller>, Result<bool, ResumeError<Fault>>) {
    let mut buffer = vec![0; Controller::SNAPSHOT_BYTES];
    let made = persistence.load_factory(&mut buffer).unwrap().unwrap();
    let config = Config::robust().with_automatic_apply(true);
    let mut calibrator = Box::new(Controller::new(config));
    calibrator.set_cameras(made.cameras);
    calibrator.set_factory(made.extrinsics);
    let resumed = persistence.resume(&mut calibrator, &mut buffer);
    (calibrator, resumed)
}

fn produced(factory: &Extrinsics<f32>) -> Nor {
    let mut persistence = persistence(Flash::new(3, 7));
    let mut buffer = [0; FactoryCalibration::<f32>::MAX_BYTES];
    assert_eq!(persistence.load_factory(&mut buffer), Ok(None));
    let made = FactoryCalibration { cameras: cameras(), extrinsics: *factory };
    persistence.save_factory(&made, &mut buffer).unwrap();
    assert_eq!(persistence.load_factory(&mut buffer), Ok(Some(made)));
    persistence.release().close()
}

/// One pair; the rig turns by 0.4 degrees before pair 8.
fn fly(calibrator: &mut Controller, pair: u64) {
    let knocked = if pair < 8 { 0.0 } else { 0.4 };
    let truth = rig([1.0 + knocked, -0.5, 0.8], [0.5, -0.4]);
    let _ = take(calibrator, &correspondences(&truth, 250, 0.5, pair));
    calibrator.clear_pair();
}

#[test]
fn loss_of_power_at_any_word_keeps_the_last_save_or_the_one_before() {
    let [mut buffer, mut buffer_of_saves] = [(); 2].map(|()| vec![0; Controller::SNAPSHOT_BYTES]);
    let mut keeper_in_flight = persistence(produced(&Extrinsics::SIDE_BY_SIDE));
    let (mut calibrator, resumed) = boot(&mut keeper_in_flight);
    assert_eq!(resumed, Ok(false));
    let mut last: Option<Memory> = None;
    let [mut cuts, mut reasons] = [0, 0];
    for pair in 0..14 {
        fly(&mut calibrator, pair);
        let now = Duration::from_secs(2 * pair);
        let before = keeper_in_flight.release().close();
        let again = |flash| {
            let mut persistence = persistence(flash);
            // The same policy state as before the loss of power.
            let _ = boot(&mut persistence);
            persistence
        };
        // After a restore the interval has passed.
        let mut due = |flash| {
            let mut persistence = again(flash);
            if last.is_some() {
                let earlier = now.saturating_sub(Duration::from_secs(1));
                let saved = persistence.save_if_due(&calibrator, earlier, &mut buffer_of_saves);
                assert_eq!(saved, Ok(None));
            }
            persistence
        };
        let mut whole = due(before.clone());
        let reason = whole.save_if_due(&calibrator, now, &mut buffer).unwrap();
        let after = whole.release().close();
        for cut in 0..after.operations - before.operations {
            let mut flash = before.clone();
            flash.tear = TEARS[cut as usize % TEARS.len()];
            flash.power_for = Some(cut + 1);
            let mut torn = due(flash);
            // The last write of a save may fail unnoticed.
            let saved = torn.save_if_due(&calibrator, now, &mut buffer).is_ok();
            let mut flash = torn.release().close();
            flash.power_on();
            let (mut new, resumed) = boot(&mut persistence(flash));
            let found = memory(&new);
            // After a torn first save the flash may hold only a word that cannot be read.
            let fresh = last.is_none() && resumed != Ok(true);
            let before = !saved && Some(&found) == last.as_ref();
            assert!(fresh || before || found == memory(&calibrator));
            cuts += 1;
            if cut % 97 == 0 && resumed == Ok(true) {
                assert_eq!(new.state(), State::Suspect);
                fly(&mut new, pair);
                assert_ne!(new.state(), State::Acquiring);
            }
        }
        if reason.is_some() {
            reasons += 1;
            last = Some(memory(&calibrator));
        }
        keeper_in_flight = again(after);
    }
    println!("{cuts} cuts in {reasons} saves, none lost what was saved before");
    assert!(cuts > 1000 && reasons > 3, "{cuts} {reasons}");
}

#[test]
fn a_state_learnt_from_another_factory_calibration_is_refused() {
    let mut first = persistence(produced(&Extrinsics::SIDE_BY_SIDE));
    let mut buffer = vec![0; Controller::SNAPSHOT_BYTES];
    let (mut calibrator, _) = boot(&mut first);
    (0..5).for_each(|pair| fly(&mut calibrator, pair));
    let now = Duration::ZERO;
    assert_eq!(first.save_if_due(&calibrator, now, &mut buffer), Ok(Some(SaveReason::Locked)));
    let (resumed, found) = boot(&mut first);
    assert_eq!((found, memory(&resumed)), (Ok(true), memory(&calibrator)));

    let made = FactoryCalibration { cameras: cameras(), extrinsics: rig([0.1; 3], [0.0; 2]) };
    first.save_factory(&made, &mut buffer).unwrap();
    let (fresh, found) = boot(&mut first);
    assert_eq!(found, Err(ResumeError::Record(RestoreError::OtherRig)));
    assert_eq!((fresh.proposal(), fresh.in_use()), (None, &made.extrinsics));

    first.remove().unwrap();
    assert_eq!(boot(&mut first).1, Ok(false));
    assert!(first.store().wear().erasures >= 1);
}
