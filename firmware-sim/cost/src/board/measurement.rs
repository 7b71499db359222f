//! Measures every call over the states of a rig, and prints the rows.

use cortex_m_semihosting::debug::{self, EXIT_SUCCESS};
use stereo_selfcal::depth::{MotionError, Range, RangeReading, Tracks};
use stereo_selfcal::link::MatchRecord;
use stereo_selfcal::{Config, Correspondence, Extrinsics, FactoryCalibration, Scalar, State};

use crate::calls::{self, CAPACITY, CalibratorOf, fresh};
use crate::frame::{self, Damaged};
use crate::lens;
use crate::pair::{self, Calls, PairCost};
use crate::probe::{Probe, Sample};
use crate::scene::{HEADER, Rig, Scene};
use crate::states::{self, START_DEGREES};
use crate::store;
use crate::table::{mean, row};
use crate::whole_way;

/// Half a batch: the difference to a whole one gives the cost per correspondence.
const HALF: usize = CAPACITY / 2;

/// Measures all calls in one scalar, prints the rows and ends the emulation.
pub fn measure<T: Scalar>() -> ! {
    let probe = Probe::new();
    let mut records = [MatchRecord::default(); CAPACITY];
    input::<T>(&probe, &mut records);
    published::<T>(&probe, &mut records);
    let mut all = passes::<T>(&probe, &mut records);
    all = all.max(&states::measure::<T>(&probe, &mut records));
    let others = others::<T>(&probe, &mut records);
    whole_way::measure::<T>(&probe);
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
    let size = u32::try_from(size_of::<CalibratorOf<T>>()).unwrap_or(u32::MAX);
    row("size_of Calibrator", "bytes", size);
    loop {
        debug::exit(EXIT_SUCCESS);
    }
}

/// Measures decoding and pushing a match.
fn input<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) {
    let mut scene = Scene::new(Rig::off(START_DEGREES));
    scene.fill(records);
    let mut calibrator = fresh::<T>(Config::robust());
    let decoded = frame::decode(probe, records);
    row("decode a record mean", "instructions", mean(decoded.instructions, records.len()));
    row("stack of decoding a frame", "bytes", decoded.stack);
    for (name, damaged) in [
        ("decode 16 bytes of magics mean", Damaged::Magics),
        ("decode 16 bytes of headers mean", Damaged::Headers),
    ] {
        let (instructions, records) = frame::decode_damaged(probe, damaged);
        row(name, "instructions", mean(instructions, records));
    }
    let pinhole = push_all(probe, &mut calibrator, records, |c| c).0;
    row("push pinhole mean", "instructions", mean(pinhole, records.len()));
    scene.fill(records);
    let (full, most) = push_all(probe, &mut calibrator, records, |c| c);
    row("push into a full batch mean", "instructions", mean(full, records.len()));
    row("push into a full batch at most", "instructions", most);
    calibrator.discard_pair();
    push_all(probe, &mut calibrator, records, into_one_cell);
    scene.fill(records);
    let (full, most) = push_all(probe, &mut calibrator, records, into_one_cell);
    row("push into a full cell mean", "instructions", mean(full, records.len()));
    row("push into a full cell at most", "instructions", most);
    let factory = FactoryCalibration::guess(lens::distorted());
    calibrator = CalibratorOf::new(Config::robust(), &factory);
    let (distorted, most) = push_all(probe, &mut calibrator, records, |c| c);
    row("push radial-tangential mean", "instructions", mean(distorted, records.len()));
    row("push radial-tangential at most", "instructions", most);
}

/// Moves the left pixel into one cell of the grid, so that all matches are in one list of the batch.
fn into_one_cell<T: Scalar>(c: Correspondence<T>) -> Correspondence<T> {
    let far_less = |x: T| T::lit(100.0) + x * T::lit(1.0 / 64.0);
    Correspondence { left: c.left.map(far_less), ..c }
}

/// Instructions of all pushes, and of the most expensive one.
fn push_all<T: Scalar>(
    probe: &Probe,
    calibrator: &mut CalibratorOf<T>,
    records: &[MatchRecord],
    placed: impl Fn(Correspondence<T>) -> Correspondence<T>,
) -> (u32, u32) {
    records.iter().fold((0, 0), |(sum, most), record| {
        let c = placed(pair::converted(&record.decode(&HEADER)));
        let (pushed, sample) = probe.run(|| calls::push(calibrator, &c));
        assert!(pushed.is_ok(), "a match of the scene is refused");
        (sum + sample.instructions, most.max(sample.instructions))
    })
}

/// Measures the cost per correspondence of a pass, from half a batch and a whole one.
fn passes<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> Calls {
    let [half, whole] = both_sizes(probe, records, || fresh::<T>(Config::robust()));
    row("pass search", "instructions/match", slope(half.second, whole.second));
    let all = whole.calls;
    let locked = {
        let mut calibrator = fresh::<T>(Config::robust());
        let mut scene = Scene::new(Rig::off(START_DEGREES));
        while calibrator.state() != State::Locked {
            scene.fill(records);
            pair::process(probe, &mut calibrator, records);
        }
        calibrator
    };
    let [half, whole] = both_sizes(probe, records, || locked.clone());
    let [half_last, whole_last] = [&half, &whole].map(|cost| cost.calls.last.instructions);
    row("pass evaluating robust", "instructions/match", slope(half_last, whole_last));
    let details = [&half, &whole].map(|cost| cost.calls.details.instructions);
    row("pass details", "instructions/match", slope(details[0], details[1]));
    all.max(&whole.calls)
}

fn both_sizes<T: Scalar>(
    probe: &Probe,
    records: &mut [MatchRecord],
    calibrator: impl Fn() -> CalibratorOf<T>,
) -> [PairCost; 2] {
    let mut scene = Scene::new(Rig::off(START_DEGREES));
    scene.fill(records);
    [HALF, CAPACITY].map(|count| {
        let some = records.get(..count).unwrap_or_default();
        pair::process(probe, &mut calibrator(), some)
    })
}

/// Measures one pair of the published method: a pass, the evaluation, and all calls.
fn published<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) {
    Scene::new(Rig::off(START_DEGREES)).fill(records);
    let [half, whole] = [HALF, CAPACITY]
        .map(|count| pair::published::<T>(probe, records.get(..count).unwrap_or_default()));
    row("pass paper", "instructions/match", slope(half.second, whole.second));
    row("pass evaluating paper", "instructions/match", slope(half.last, whole.last));
    row("update paper first pair", "instructions", whole.update);
}

/// Measures the calls outside of a pair.
fn others<T: Scalar>(probe: &Probe, records: &mut [MatchRecord]) -> [(&'static str, Sample); 14] {
    let factory = FactoryCalibration::guess(lens::pinholes());
    let factory = factory.with_baseline_m(0.2).unwrap_or(factory);
    let mut calibrator = CalibratorOf::<T>::new(Config::robust(), &factory);
    let mut scene = Scene::new(Rig::off(START_DEGREES));
    let mut solve = Sample::default();
    while calibrator.apply().is_err() {
        scene.fill(records);
        pair::fill(probe, &mut calibrator, records);
        let (_, sample) = probe.run(|| calls::solve(&mut calibrator));
        solve = solve.max(sample);
    }
    let extrinsics: Extrinsics<T> = calibrator.in_use().extrinsics;
    let [range, step_of_tracks, tracks] = witnesses(probe, &mut calibrator, records);
    let (rotations, of_rotations) = probe.run(|| calls::rotations(&extrinsics));
    let rectified = probe.run(|| calls::rectified_camera(&lens::distorted(), &rotations)).1;
    let (record, snapshot) = probe.run(|| calls::snapshot(&calibrator));
    let mut other = fresh::<T>(Config::robust());
    let (restored, restore) = probe.run(|| calls::restore(&mut other, &record));
    assert!(restored.is_ok(), "the record was just written");
    let [open, save_if_due, save, resume] = store::measure(probe, &calibrator);
    let undo = probe.run(|| calls::undo(&mut calibrator)).1;
    let reset = probe.run(|| calls::reset(&mut calibrator)).1;
    [
        ("solve_pair", solve),
        ("push_range at most", range),
        ("advance_tracks at most", step_of_tracks),
        ("push_tracks", tracks),
        ("RectifyingRotations", of_rotations),
        ("RectifiedCamera", rectified),
        ("snapshot", snapshot),
        ("restore", restore),
        ("undo", undo),
        ("reset", reset),
        ("Store::open", open),
        ("save_if_due", save_if_due),
        ("save at most", save),
        ("resume", resume),
    ]
}

/// Measures witnesses of the mount yaw over a fused batch: points of known distance, and 256 tracks of a rig at rest.
fn witnesses<T: Scalar>(
    probe: &Probe,
    calibrator: &mut CalibratorOf<T>,
    records: &[MatchRecord],
) -> [Sample; 3] {
    let mut range = Sample::default();
    for record in records.iter().step_by(CAPACITY / 16) {
        let c: Correspondence<T> = pair::converted(&record.decode(&HEADER));
        let (depth, sd_m) = (Range::AlongAxis(T::lit(10.0)), T::lit(0.1));
        let reading = RangeReading { pixel: c.left, right: None, range: depth, sd_m };
        range = range.max(probe.run(|| calls::push_range(calibrator, &reading)).1);
    }
    let mut tracks = Tracks::<T, CAPACITY>::new();
    for _ in 0..2 {
        tracks.begin();
        for (track, pair) in (1..).zip(calibrator.batch().matches()) {
            tracks.push(track, pair);
        }
        tracks.end();
    }
    let (mut step, mut ended) = (Sample::default(), false);
    while !ended {
        let (found, sample) = probe.run(|| calls::advance_tracks(calibrator, &mut tracks));
        (step, ended) = (step.max(sample), found.is_some());
    }
    // A rig at rest shows no motion, so the tracks are still there.
    let (found, all) = probe.run(|| calls::push_tracks(calibrator, &mut tracks));
    assert!(found == Err(MotionError::NoMotion), "the rig is at rest");
    [range, step, all]
}

fn slope(half: u32, whole: u32) -> u32 {
    mean(whole.saturating_sub(half), CAPACITY - HALF)
}
