//! The life of a rig, every call measured, and the rows that come of it.

use cortex_m_semihosting::debug::{self, EXIT_SUCCESS};
use stereo_selfcal::link::MatchRecord;
use stereo_selfcal::{Config, Extrinsics, Scalar, State};

use crate::calls::{self, CAPACITY, Calibrated};
use crate::frame;
use crate::lens;
use crate::pair::{self, Calls, PairCost};
use crate::probe::{Probe, Sample};
use crate::scene::{HEADER, Rig, Scene};
use crate::table::{remark, row};

/// Room for all that is learnt, in either scalar.
const ROOM: usize = Calibrated::<f64>::SNAPSHOT_BYTES;

/// Half a batch: the slope between the two is the price of a correspondence.
const HALF: usize = CAPACITY / 2;

/// How far off the rig is at first, and after a knock, degrees about each axis.
const OFF_DEGREES: f32 = 5.0;
const KNOCKED_DEGREES: f32 = 5.5;

/// Pairs that are watched after the rig has locked, and after a knock.
const WATCHED: usize = 8;

/// Batches of mismatches alone: enough to lose the rig.
const GARBAGE: usize = 12;

/// Measures everything in one scalar, prints the rows and ends the emulation.
pub fn survey<T: Scalar>() -> ! {
    let probe = Probe::new();
    let mut records = [MatchRecord::default(); CAPACITY];
    intake::<T>(&probe, &mut records);
    let mut all = passes::<T>(&probe, &mut records);
    all = all.most(&paper::<T>(&probe, &mut records));
    all = all.most(&life::<T>(&probe, &mut records));
    let others = others::<T>(&probe, &mut records);
    for (name, sample) in all.named() {
        row(format_args!("{name} at most"), "instructions", sample.instructions);
    }
    for (name, sample) in others {
        row(name, "instructions", sample.instructions);
    }
    let longest = all.named().iter().map(|(_, sample)| sample.instructions).max().unwrap_or(0);
    row("longest call", "instructions", longest);
    for (name, sample) in all.named().into_iter().chain(others) {
        row(format_args!("stack of {name}"), "bytes", sample.stack);
    }
    let size = u32::try_from(size_of::<Calibrated<T>>()).unwrap_or(u32::MAX);
    row("size_of Calibrator", "bytes", size);
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

fn fresh<T: Scalar>(config: Config) -> Calibrated<T> {
    let mut calibrator = Calibrated::new(config);
    calibrator.set_cameras(lens::pinholes());
    calibrator
}

/// What taking in a match costs.
fn intake<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) {
    let mut scene = Scene::new(Rig::off(OFF_DEGREES));
    scene.fill(records);
    let mut calibrator = fresh::<T>(Config::robust());
    let decoded = frame::decode(probe, records);
    row("decode a record mean", "instructions", mean(decoded.instructions, records.len()));
    row("stack of decoding a frame", "bytes", decoded.stack);
    let pinhole = push_all(probe, &mut calibrator, records).0;
    row("push pinhole mean", "instructions", mean(pinhole, records.len()));
    scene.fill(records);
    let (full, most) = push_all(probe, &mut calibrator, records);
    row("push into a full batch mean", "instructions", mean(full, records.len()));
    row("push into a full batch at most", "instructions", most);
    calibrator.set_cameras(lens::distorted());
    let (distorted, most) = push_all(probe, &mut calibrator, records);
    row("push radial-tangential mean", "instructions", mean(distorted, records.len()));
    row("push radial-tangential at most", "instructions", most);
}

/// Instructions of all pushes, and of the dearest.
fn push_all<T: Scalar>(
    probe: &Probe,
    calibrator: &mut Calibrated<T>,
    records: &[MatchRecord],
) -> (u32, u32) {
    records.iter().fold((0, 0), |(sum, most), record| {
        let c = pair::converted(&record.decode(&HEADER));
        let (pushed, sample) = probe.run(|| calls::push(calibrator, &c));
        assert!(pushed.is_ok(), "a match of the scene is refused");
        (sum + sample.instructions, most.max(sample.instructions))
    })
}

/// What a pass costs a correspondence, between half a batch and a whole one.
fn passes<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let mut all = Calls::default();
    for (name, config) in [("paper", Config::paper()), ("search", Config::robust())] {
        let [half, whole] = both_sizes(probe, records, || fresh::<T>(config));
        row(format_args!("pass {name}"), "instructions/match", slope(half.second, whole.second));
        if name == "paper" {
            let [half, whole] = [&half, &whole].map(|cost| cost.calls.last.instructions);
            row("pass judging paper", "instructions/match", slope(half, whole));
        }
        all = all.most(&whole.calls);
    }
    let locked = {
        let mut calibrator = fresh::<T>(Config::robust());
        let mut scene = Scene::new(Rig::off(OFF_DEGREES));
        while calibrator.state() != State::Locked {
            scene.fill(records);
            pair::take(probe, &mut calibrator, records);
        }
        calibrator
    };
    let [half, whole] = both_sizes(probe, records, || locked.clone());
    let [half_last, whole_last] = [&half, &whole].map(|cost| cost.calls.last.instructions);
    row("pass judging robust", "instructions/match", slope(half_last, whole_last));
    let health = [&half, &whole].map(|cost| cost.calls.health.instructions);
    row("pass health", "instructions/match", slope(health[0], health[1]));
    all.most(&whole.calls)
}

fn both_sizes<T: Scalar>(
    probe: &Probe,
    records: &mut [MatchRecord],
    calibrator: impl Fn() -> Calibrated<T>,
) -> [PairCost; 2] {
    let mut scene = Scene::new(Rig::off(OFF_DEGREES));
    scene.fill(records);
    [HALF, CAPACITY].map(|count| {
        let some = records.get(..count).unwrap_or_default();
        pair::take(probe, &mut calibrator(), some)
    })
}

/// One pair of the paper preset.
fn paper<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let mut scene = Scene::new(Rig::off(OFF_DEGREES));
    scene.fill(records);
    let cost = pair::take(probe, &mut fresh::<T>(Config::paper()), records);
    row("update paper first pair", "instructions", cost.update);
    cost.calls
}

/// From the first pair to the loss of the rig and back, in whole batches and in halves.
fn life<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let mut all = Calls::default();
    for count in [CAPACITY, HALF] {
        remark(format_args!("a life in batches of {count}"));
        let records = records.get_mut(..count).unwrap_or_default();
        let mut life = Life::<T>::begin(probe, records);
        life.acquire();
        life.hold();
        life.knock();
        life.lose();
        life.recover();
        row(format_args!("update of {count} at most"), "instructions", life.most);
        all = all.most(&life.all);
    }
    all
}

struct Life<'a, T: Scalar> {
    probe: &'a Probe,
    records: &'a mut [MatchRecord],
    calibrator: Calibrated<T>,
    scene: Scene,
    all: Calls,
    most: u32,
}

impl<'a, T: Scalar> Life<'a, T> {
    fn begin(probe: &'a Probe, records: &'a mut [MatchRecord]) -> Self {
        Self {
            probe,
            records,
            calibrator: fresh(Config::robust()),
            scene: Scene::new(Rig::off(OFF_DEGREES)),
            all: Calls::default(),
            most: 0,
        }
    }

    fn pair(&mut self) -> PairCost {
        self.scene.fill(self.records);
        let cost = pair::take(self.probe, &mut self.calibrator, self.records);
        self.all = self.all.most(&cost.calls);
        self.most = self.most.max(cost.update);
        cost
    }

    fn row(&self, name: &str, instructions: u32) {
        row(format_args!("update of {} {name}", self.records.len()), "instructions", instructions);
    }

    /// Pairs until locked.
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

    fn hold(&mut self) {
        let (mut sum, mut most) = (0, 0);
        for _ in 0..WATCHED {
            let cost = self.pair();
            assert!(cost.state == State::Locked, "a locked rig stays so while nothing moves");
            (sum, most) = (sum + cost.update, most.max(cost.update));
        }
        self.row("locked mean", mean(sum, WATCHED));
        self.row("locked at most", most);
    }

    /// The rig turns, and is followed.
    fn knock(&mut self) {
        self.scene.rig = Rig::off(KNOCKED_DEGREES);
        let mut most = 0;
        for _ in 0..WATCHED {
            let cost = self.pair();
            let suspect = cost.state == State::Suspect || self.calibrator.state() == State::Suspect;
            most = if suspect { most.max(cost.update) } else { most };
        }
        assert!(most > 0, "a knock makes the rig suspect");
        self.row("suspect at most", most);
    }

    /// Nothing but mismatches, until the rig is lost.
    fn lose(&mut self) {
        self.scene.wrong = 10;
        let most = (0..GARBAGE).map(|_| self.pair().update).max().unwrap_or(0);
        assert!(self.calibrator.state() == State::Lost, "mismatches lose the rig");
        self.row("of mismatches at most", most);
    }

    /// Good pairs of a rig that has moved meanwhile.
    fn recover(&mut self) {
        self.scene = Scene::new(Rig::off(OFF_DEGREES));
        let most = (0..WATCHED).map(|_| self.pair().update).max().unwrap_or(0);
        assert!(self.calibrator.state() == State::Locked, "the rig is found again");
        self.row("lost at most", most);
    }
}

/// Calls beside those of each pair.
fn others<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> [(&'static str, Sample); 7] {
    let mut calibrator = fresh::<T>(Config::robust());
    let mut scene = Scene::new(Rig::off(OFF_DEGREES));
    let mut solve = Sample::default();
    while calibrator.apply().is_err() {
        scene.fill(records);
        pair::fill(probe, &mut calibrator, records);
        let (report, sample) = probe.run(|| calls::solve(&mut calibrator));
        solve = solve.most(sample);
        let _ = report.map(|_| calibrator.fuse());
    }
    let extrinsics: Extrinsics<T> = *calibrator.in_use();
    let (rotations, of_rotations) = probe.run(|| calls::rotations(&extrinsics));
    let choose = probe.run(|| calls::choose(&lens::distorted(), &rotations)).1;
    let mut buffer = [0; ROOM];
    let (length, snapshot) = probe.run(|| calls::snapshot(&calibrator, &mut buffer));
    let record = buffer.get(..length.unwrap_or_default()).unwrap_or_default();
    let mut other = fresh::<T>(Config::robust());
    let (restored, restore) = probe.run(|| calls::restore(&mut other, record));
    assert!(restored.is_ok(), "a record that was just written");
    let undo = probe.run(|| calls::undo(&mut calibrator)).1;
    let reset = probe.run(|| calls::reset(&mut calibrator)).1;
    [
        ("solve_pair", solve),
        ("RectifyingRotations", of_rotations),
        ("RectifiedCamera", choose),
        ("snapshot", snapshot),
        ("restore", restore),
        ("undo", undo),
        ("reset", reset),
    ]
}

fn slope(half: u32, whole: u32) -> u32 {
    mean(whole.saturating_sub(half), CAPACITY - HALF)
}

/// To the nearest.
fn mean(sum: u32, count: usize) -> u32 {
    let count = u32::try_from(count).unwrap_or(u32::MAX);
    (sum + count / 2) / count
}
