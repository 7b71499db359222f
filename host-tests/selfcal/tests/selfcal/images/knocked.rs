//! `--knock`: the images of a good rig, from a calibration that is wrong.

use crate::call::{failure, json};

#[test]
fn a_knock_of_the_shipped_rig_is_found() {
    let json = json(&["images", "chess", "--pairs", "5", "--knock", "1", "--json"]);
    assert_eq!(json["verdict"], "recalibrate", "{json}");
    let number = |name: &str| json["run"][name].as_f64().unwrap();
    assert!(number("rms_px_before") > 5.0 && number("rms_px_after") < 0.8, "{json}");
    // The distance from the wrong start. The estimate differs from the given calibration by a few hundredths of a degree.
    assert!((number("e_theta").to_degrees() - 1.0).abs() < 0.05, "{json}");
}

#[test]
fn a_knocked_rig_is_no_reference_of_a_data_set() {
    let error = failure(&["images", "chess", "--knock", "1", "--out", "set"], 2);
    assert!(error.contains("--knock") && error.contains("--out"), "{error}");
}

#[test]
fn a_knock_beyond_the_search_of_the_matcher_is_refused() {
    let error = failure(&["images", "chess", "--knock", "7", "--json"], 1);
    assert!(error.contains("up to 6 degrees") && error.contains("--prior"), "{error}");
}
