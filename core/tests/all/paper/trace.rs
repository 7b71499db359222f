//! Trace of a scripted run in `trace.txt`, pair by pair.
//!
//! Update: `UPDATE_EXPECT=1 cargo test -p stereo-selfcal --test all paper`.

use core::fmt::Write;

use expect_test::expect_file;
use stereo_selfcal::geometry::metrics::Deviation;

use super::{published, take};
use crate::api::scene::{correspondences, rig};
use crate::record::{BASELINE, ROTATION, scene};

const HEADING: &str = "\
pair  outcome
      solved: passes, stop; usable, skipped, screened; cost, RMS px before > after; noise px; off the truth t, R
      estimate: pairs; off the truth t, R; sd t, R; whether the axis is meaningful";

#[test]
fn the_published_method_fuses() {
    let truth = rig(ROTATION, BASELINE);
    let off = |extrinsics: &_| {
        let Deviation { translation, rotation } = Deviation::between(extrinsics, &truth);
        format!("{translation:.4e} {rotation:.4e}")
    };
    let clean = |seed| correspondences::<f32>(&rig(ROTATION, BASELINE), 250, 0.5, seed);
    let among_outliers = |seed| scene::<f32>(ROTATION, seed);
    let mut calibrator = published();
    let mut text = format!("{HEADING}\n");
    let pairs = (0..8).map(clean).chain((8..10).map(among_outliers)).chain((10..12).map(clean));
    for (i, pair) in pairs.enumerate() {
        if i == 10 {
            calibrator.reset();
            writeln!(text, "reset").unwrap();
        }
        let outcome = take(&mut calibrator, &pair);
        writeln!(text, "{outcome}").unwrap();
        if let Some(r) = outcome.pair {
            writeln!(
                text,
                "      {} {}; {} {} {}; {:.4e} > {:.4e}, {:.4e} > {:.4e}; {:.4e}; {}",
                r.passes,
                r.stop,
                r.usable,
                r.skipped,
                r.screened,
                r.cost_before,
                r.cost_after,
                r.rms_px_before,
                r.rms_px_after,
                r.noise_px,
                off(&r.extrinsics)
            )
            .unwrap();
        }
        if let Some(e) = calibrator.estimate() {
            let [t, r] = [e.sd.translation, e.sd.rotation];
            let off = off(&e.extrinsics);
            writeln!(text, "      {}; {off}; {t:.4e} {r:.4e}; {}", e.pairs, e.axis_is_meaningful)
                .unwrap();
        }
    }
    expect_file!["trace.txt"].assert_eq(&text);
}
