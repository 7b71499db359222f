//! Measures pairs in each state of a calibrator, and of rigs that creep, vibrate, see far, or have a wrong lens.

use stereo_selfcal::link::MatchRecord;
use stereo_selfcal::{Config, LensTracking, Scalar, State};

use crate::calls::{CalibratorOf, fresh};
use crate::pair::{self, Calls, PairCost};
use crate::probe::Probe;
use crate::scene::{FAR, Rig, Scene};
use crate::table::{mean, row};

/// Deviation of the rig at the start and after the knock, degrees about each axis.
pub(crate) const START_DEGREES: f32 = 5.0;
const KNOCKED_DEGREES: f32 = 5.5;

/// Number of measured pairs after the lock, after the knock, and after the loss of the estimate.
const MEASURED_PAIRS: usize = 8;

/// Number of pairs after which a lens is corrected.
const CORRECTED_PAIRS: usize = 30;

/// Number of pairs of a vibrating rig, and deflection of its cameras, degrees.
const SHAKEN_PAIRS: usize = 24;
const SHAKEN_DEGREES: f32 = 0.1;

/// Number of batches of outliers alone, enough for the state `Lost`.
const OUTLIER_BATCHES: usize = 12;

/// Measures all states, from the first pair to `Lost` and back to `Locked`.
pub(crate) fn measure<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let mut run = Run::<T>::begin(probe, records);
    run.acquire();
    run.track();
    run.knock();
    run.lose();
    run.recover();
    run.creep("creeping at most");
    run.shake("creeping and vibrating at most");
    let all = run.all;
    all.max(&corrected::<T>(probe, records)).max(&far::<T>(probe, records))
}

/// Measures pairs of a rig that vibrates before a far scene, so that the baseline in use is kept.
fn far<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let mut run = Run::<T>::begin(probe, records);
    run.scene.inverse_distances = FAR;
    while run.calibrator.state() != State::Locked {
        run.pair();
    }
    run.shake("far and vibrating at most");
    let kept = run.calibrator.proposal().is_some_and(|proposal| !proposal.baseline_observed);
    assert!(kept, "a far scene does not observe the baseline");
    run.all
}

/// Measures pairs of a rig whose right lens is corrected.
fn corrected<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let config = Config::robust().with_lens_tracking(LensTracking::Compensate);
    let mut run = Run { calibrator: fresh::<T>(config), ..Run::begin(probe, records) };
    run.scene.focal = 1.005;
    let mut most = 0;
    for _ in 0..CORRECTED_PAIRS {
        most = most.max(run.pair().update);
    }
    let correction = run.calibrator.proposal().map(|proposal| proposal.correction);
    assert!(correction.is_some_and(|by| !by.is_none()), "the focal length is corrected");
    run.row("of a corrected lens at most", most);
    run.all
}

struct Run<'a, T: Scalar> {
    probe: &'a Probe,
    records: &'a mut [MatchRecord],
    calibrator: CalibratorOf<T>,
    scene: Scene,
    all: Calls,
}

impl<'a, T: Scalar> Run<'a, T> {
    fn begin(probe: &'a Probe, records: &'a mut [MatchRecord]) -> Self {
        Self {
            probe,
            records,
            calibrator: fresh(Config::robust()),
            scene: Scene::new(Rig::off(START_DEGREES)),
            all: Calls::default(),
        }
    }

    fn pair(&mut self) -> PairCost {
        self.scene.fill(self.records);
        self.process()
    }

    fn process(&mut self) -> PairCost {
        let cost = pair::process(self.probe, &mut self.calibrator, self.records);
        self.all = self.all.max(&cost.calls);
        cost
    }

    fn row(&self, name: &str, instructions: u32) {
        row(format_args!("update of {} {name}", self.records.len()), "instructions", instructions);
    }

    /// Measures the pairs until locked.
    fn acquire(&mut self) {
        let mut most = 0;
        while self.calibrator.state() != State::Locked {
            let cost = self.pair();
            if most == 0 {
                self.row("acquiring first", cost.update);
            }
            most = most.max(cost.update);
        }
        self.row("acquiring at most", most);
    }

    /// Measures pairs in the state `Locked`.
    fn track(&mut self) {
        let (mut sum, mut most) = (0, 0);
        for _ in 0..MEASURED_PAIRS {
            let cost = self.pair();
            assert!(
                cost.state == State::Locked,
                "the state stays locked while the rig does not move"
            );
            (sum, most) = (sum + cost.update, most.max(cost.update));
        }
        self.row("locked mean", mean(sum, MEASURED_PAIRS));
        self.row("locked at most", most);
    }

    /// Measures the pairs after a knock.
    fn knock(&mut self) {
        self.scene.rig = Rig::off(KNOCKED_DEGREES);
        let mut most = 0;
        for _ in 0..MEASURED_PAIRS {
            let cost = self.pair();
            let suspect = cost.state == State::Suspect || self.calibrator.state() == State::Suspect;
            most = if suspect { most.max(cost.update) } else { most };
        }
        assert!(most > 0, "a knock makes the state suspect");
        self.row("suspect at most", most);
    }

    /// Measures batches of outliers alone, after which the state is lost.
    fn lose(&mut self) {
        self.scene.outliers = 10;
        let most = (0..OUTLIER_BATCHES).map(|_| self.pair().update).max().unwrap_or(0);
        assert!(self.calibrator.state() == State::Lost, "outliers alone lead to the state lost");
        self.row("of mismatches at most", most);
    }

    /// Measures pairs of a rig that has moved meanwhile, after which the state is locked.
    fn recover(&mut self) {
        self.scene = Scene::new(Rig::off(START_DEGREES));
        let most = (0..MEASURED_PAIRS).map(|_| self.pair().update).max().unwrap_or(0);
        assert!(self.calibrator.state() == State::Locked, "the state is locked again");
        self.row("lost at most", most);
    }

    /// Measures pairs of a scene that moves little, so that only a share of each is new.
    fn creep(&mut self, name: &str) {
        let mut most = 0;
        for _ in 0..MEASURED_PAIRS {
            self.scene.creep(self.records);
            most = most.max(self.process().update);
        }
        self.row(name, most);
    }

    /// Measures pairs of a rig that vibrates before a scene that moves little.
    fn shake(&mut self, name: &str) {
        for turn in (0..SHAKEN_PAIRS).map(|i| SHAKEN_DEGREES * [0.0, 1.0, -1.0, 0.5][i % 4]) {
            self.scene.rig = Rig::off(START_DEGREES + turn);
            self.pair();
        }
        let vibration = self.calibrator.proposal().map(|proposal| proposal.vibration);
        assert!(vibration.is_some_and(|found| !found.is_none()), "the vibration is found");
        self.creep(name);
    }
}
