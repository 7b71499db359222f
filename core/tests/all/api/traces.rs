//! Traces of scripted scenes in `traces/*.txt`, pair by pair: every reported number, and the checksum of the record. A
//! change of behaviour changes the traces, so it cannot be committed unnoticed.
//!
//! Update: `UPDATE_EXPECT=1 cargo test -p stereo-selfcal --test all traces`.

use core::fmt::{LowerExp, Write};

use expect_test::expect_file;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::Details;
use stereo_selfcal::{
    Calibrator, Config, Correspondence, Extrinsics, LensTracking, PairReport, Proposal, Scalar,
    Verdict, has_valid_lengths,
};

use crate::api::bias::fence;
use crate::api::disturbed::{garbage, jittered, with_outliers};
use crate::api::lens::pair_of;
use crate::api::presets::with;
use crate::api::scene::{correspondences, correspondences_within, fill, rig};
use crate::api::supervision::poor;
use crate::api::vibration::shaken;
use crate::record::{BASELINE, ROTATION, scene};

const HEADING: &str = "\
pair  outcome
      solved: passes, stop; usable, skipped, screened; cost, RMS px before > after; noise px; off the truth t, R
      estimate: state, pairs; off the truth t, R, and of what applies; sd t, R, sd with the lens t, R; weakest; reasons
      lens: focal, k1, mean k1, p1, column; correction; vibration R, t
      details: px in use, proposed, off; fits in use, proposed; yaw
      verdict: rows, depth; coverage, of the image; whether it may arm, should apply; reasons
      checksum of the record, f32";

trait Number: Scalar + LowerExp {}
impl Number for f32 {}
impl Number for f64 {}

type Pair<T> = Vec<Correspondence<T>>;

fn truth<T: Number>() -> Extrinsics<T> {
    rig(ROTATION, BASELINE)
}

fn off<T: Number>(extrinsics: &Extrinsics<T>) -> String {
    let Deviation { translation, rotation } = Deviation::between(extrinsics, &truth());
    format!("{translation:.4e} {rotation:.4e}")
}

fn solved<T: Number>(report: &PairReport<T>) -> String {
    let PairReport { passes, stop, usable, skipped, screened, noise_px, .. } = report;
    let [cost, rms] =
        [[report.cost_before, report.cost_after], [report.rms_px_before, report.rms_px_after]]
            .map(|[before, after]| format!("{before:.4e} > {after:.4e}"));
    let off = off(&report.extrinsics);
    format!("{passes} {stop}; {usable} {skipped} {screened}; {cost}, {rms}; {noise_px:.4e}; {off}")
}

fn estimate<T: Number>(proposal: &Proposal<T>) -> [String; 2] {
    let Proposal { state, pairs, sd, sd_lens, vibration, correction, .. } = proposal;
    let [best, applicable] = [&proposal.extrinsics, &proposal.applicable].map(off);
    let (weakest, weakest_sd) = proposal.weakest();
    let reasons = proposal.reasons();
    let first = format!(
        "{state} {pairs}; {best}, {applicable}; {:.4e} {:.4e}, {:.4e} {:.4e}; {weakest:?} {weakest_sd:.4e}; {reasons}",
        sd.translation, sd.rotation, sd_lens.translation, sd_lens.rotation
    );
    let lens = proposal.lens.map_or(String::new(), |lens| {
        let all = [lens.focal, lens.k1, lens.k1_mean, lens.p1, lens.principal_x_px];
        all.map(|finding| format!("{:.3e}+-{:.3e}", finding.value, finding.sd)).join(" ")
    });
    let second = format!(
        "{lens}; {:.4e} {:.4e}; {:.4e} {:.4e}",
        correction.focal, correction.k1, vibration.rotation, vibration.baseline
    );
    [first, second]
}

fn details<T: Number>(details: &Details<T>) -> String {
    let Details { in_use_px, proposed_px, off_px, fit_in_use, fit_proposed, yaw, .. } = details;
    format!(
        "{in_use_px:.4e} {proposed_px:.4e} {off_px:.4e}; {fit_in_use} {fit_proposed}; {yaw:.4e}"
    )
}

fn verdict<T: Number>(verdict: &Verdict<T>) -> String {
    let Verdict { rows_px, depth_px, coverage, image_coverage, may_arm, should_apply, .. } =
        verdict;
    format!(
        "{rows_px:.4e} {depth_px:.4e}; {coverage:.3} {image_coverage:.3}; {may_arm} {should_apply}; {}",
        verdict.reasons
    )
}

/// A calibrator and its trace so far.
struct Trace<T: Number> {
    config: Config,
    calibrator: Calibrator<T, 256>,
    text: String,
    applies: bool,
}

impl<T: Number> Trace<T> {
    fn new(config: Config) -> Self {
        Self { config, calibrator: with(config), text: format!("{HEADING}\n"), applies: false }
    }

    fn applying(config: Config) -> Self {
        Self { applies: true, ..Self::new(config) }
    }

    fn line(&mut self, words: &str) {
        writeln!(self.text, "      {words}").unwrap();
    }

    fn take(&mut self, pairs: impl IntoIterator<Item = Pair<T>>) {
        for matches in pairs {
            fill(&mut self.calibrator, &matches);
            let outcome = self.calibrator.solve_pair();
            writeln!(self.text, "{outcome}").unwrap();
            if let Some(report) = outcome.pair {
                self.line(&solved(&report));
            }
            self.say();
            if self.applies
                && let Err(error) = self.calibrator.apply()
            {
                self.line(&format!("not applied: {error}"));
            }
        }
    }

    fn say(&mut self) {
        assert!(has_valid_lengths(&self.calibrator));
        if let Some(proposal) = self.calibrator.proposal() {
            for words in estimate(&proposal) {
                self.line(&words);
            }
        }
        if let Some(now) = self.calibrator.details() {
            self.line(&details(&now));
        }
        self.line(&verdict(self.calibrator.verdict()));
        let checksum = self.record().last_chunk().map(|bytes| u32::from_le_bytes(*bytes));
        // The checksum is left out in `f64`, because the last bit of a generated `f64` depends on the processor.
        if let Some(checksum) = checksum.filter(|_| size_of::<T>() == size_of::<f32>()) {
            self.line(&format!("{checksum:08x}"));
        }
    }

    fn record(&self) -> Vec<u8> {
        self.calibrator.snapshot().to_vec()
    }

    /// Restarts the calibrator from its record, as after a loss of power.
    fn resume(&mut self) {
        let record = self.record();
        self.calibrator = with(self.config);
        self.calibrator.restore(&record).unwrap();
        writeln!(self.text, "restored").unwrap();
        self.say();
    }
}

fn good<T: Number>(seed: u64) -> Pair<T> {
    scene(ROTATION, seed)
}

fn far(seed: u64) -> Pair<f32> {
    with_outliers(correspondences_within(&truth(), [1000.0, 10_000.0], 250, 0.5, seed), 4)
}

const COMPENSATE: Config = Config::robust().with_lens_tracking(LensTracking::Compensate);

macro_rules! is {
    ($name:literal, $trace:expr) => {
        expect_file![concat!("traces/", $name, ".txt")].assert_eq(&$trace.text)
    };
}

#[test]
fn a_rig_is_acquired_and_applied() {
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..12).map(good));
    is!("acquired", trace);
    let mut trace = Trace::<f64>::applying(Config::robust());
    trace.take((0..8).map(good));
    is!("acquired_f64", trace);
}

#[test]
fn a_knock_is_followed() {
    let [x, y, z] = ROTATION;
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..10).map(good));
    trace.take((10..16).map(|seed| scene([x + 0.3, y, z], seed)));
    // A small step, which only change detection over several pairs notices.
    trace.take((16..40).map(|seed| scene([x + 0.3, y, z + 0.012], seed)));
    is!("knocked", trace);
}

#[test]
fn a_drift_is_followed() {
    let [x, y, z] = ROTATION;
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..10).map(good));
    trace.take((0..50_u32).map(|i| scene([x + 0.001 * f64::from(i), y, z], u64::from(i) + 10)));
    is!("drifting", trace);
}

#[test]
fn a_first_pair_of_another_rig_is_replaced() {
    let [x, y, z] = ROTATION;
    let mut trace = Trace::<f32>::new(Config::robust());
    trace.take([scene([x + 2.0, y, z - 1.0], 500)]);
    trace.take((0..5).map(good));
    is!("false_start", trace);
}

#[test]
fn an_estimate_locks_and_stays_locked_among_outliers() {
    let mut trace = Trace::<f32>::new(Config::robust());
    trace.take((0..6).map(|seed| poor(ROTATION, 50, seed)));
    trace.take((6..9).map(good));
    trace.take((9..24).map(|seed| poor(ROTATION, 60, seed)));
    is!("outliers", trace);
}

#[test]
fn rubbish_loses_the_rig_and_good_pairs_find_it() {
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..6).map(good));
    trace.take((0..12).map(|seed| garbage(250, seed)));
    trace.take((6..9).map(good));
    is!("rubbish", trace);
}

#[test]
fn far_scenes_determine_the_rotation() {
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..8).map(far));
    trace.take((8..12).map(good));
    trace.take((12..14).map(far));
    is!("far", trace);
}

#[test]
fn small_batches_are_searched_twice() {
    let mut trace = Trace::<f32>::new(Config::robust());
    trace.take((0..10).map(|seed| with_outliers(correspondences(&truth(), 40, 0.5, seed), 3)));
    trace.take((10..14).map(|seed| with_outliers(correspondences(&truth(), 16, 0.5, seed), 8)));
    is!("small", trace);
}

#[test]
fn a_still_scene_counts_once() {
    let still = good::<f32>(0);
    let mut trace = Trace::<f32>::new(Config::robust());
    trace.take((0..3).map(good));
    trace.take((0..5).map(|seed| jittered(&still, 0.5, seed)));
    trace.resume();
    trace.take((5..8).map(|seed| jittered(&still, 0.5, seed)));
    trace.take((8..10).map(good));
    is!("still", trace);
}

#[test]
fn a_second_crowd_is_doubted() {
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..4).map(|seed| fence(122, 3.0, seed)));
    trace.take((4..8).map(|seed| fence(80, 6.0, seed)));
    trace.take((8..12).map(good));
    is!("crowds", trace);
}

#[test]
fn a_wrong_lens_is_reported_and_compensated() {
    let wrong = |seed| pair_of(&truth(), 0.003, 0.002, seed);
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..12).map(wrong));
    is!("lens_reported", trace);
    let mut trace = Trace::<f32>::applying(COMPENSATE);
    trace.take((0..24).map(wrong));
    trace.resume();
    trace.take((24..27).map(wrong));
    is!("lens_compensated", trace);
}

#[test]
fn a_vibrating_rig_is_averaged() {
    let steady = |seed| correspondences::<f32>(&shaken(0.0, seed), 200, 0.5, seed);
    let vibrating = |seed| correspondences::<f32>(&shaken(0.1, seed), 200, 0.5, seed);
    let mut trace = Trace::<f32>::applying(Config::robust());
    trace.take((0..6).map(steady));
    trace.take((6..36).map(vibrating));
    trace.resume();
    trace.take((36..40).map(vibrating));
    is!("vibrating", trace);
    let wrong = |seed| pair_of(&shaken(0.05, seed), 0.003, 0.0, seed);
    let mut trace = Trace::<f32>::applying(COMPENSATE);
    trace.take((0..40).map(wrong));
    is!("vibrating_lens", trace);
}

#[test]
fn a_limited_correction_is_refused_beyond() {
    let [x, y, z] = ROTATION;
    let mut trace = Trace::<f32>::applying(Config::robust().with_max_correction_rad(0.03).unwrap());
    trace.take((0..6).map(good));
    trace.take((6..14).map(|seed| scene([x + 0.6, y, z], seed)));
    is!("limited", trace);
}

#[test]
fn more_matches_than_fit_are_selected_and_steps_of_a_grid_are_noise() {
    let mut trace = Trace::<f32>::new(Config::robust());
    trace.take((0..3).map(|seed| with_outliers(correspondences(&truth(), 1000, 0.5, seed), 4)));
    trace.take((3..6).map(|seed| {
        let all = correspondences::<f32>(&truth(), 600, 0.5, seed);
        let on_grid = |(i, c): (u16, Correspondence<f32>)| Correspondence {
            score: f32::from(i % 7) / 7.0,
            grid_step: [0.0, 1.0, 4.0][usize::from(i % 3)],
            ..c
        };
        (0..).zip(all).map(on_grid).collect()
    }));
    is!("selected", trace);
}
