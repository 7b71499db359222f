//! Recorded streams of frames.

use rigs::data::{Dataset, in_f64};
use sim::wire::Sender;
use stereo_selfcal::link::Decoder;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};
use test_support::Ended;

use crate::call;

fn set(name: &str) -> Dataset {
    Dataset::load(&Dataset::shipped().join(name)).unwrap()
}

fn selfcal(args: &[&str]) -> (bool, String, String) {
    let Ended { out, err, status } = call::selfcal(args).ended();
    (status == 0, out, err)
}

#[test]
fn a_recorded_stream_replays_as_its_set_and_a_damaged_one_as_its_whole_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (whole, bad) = (path("whole.scmf"), path("bad.scmf"));
    let (good, said, _) = selfcal(&["record", "opencv_chess_sift", &whole]);
    assert!(good && said.contains("13 frames") && said.contains("13 as sent"), "{said}");
    let (_, from_stream, heard) =
        selfcal(&["replay", &whole, "--rig", "opencv_chess_sift", "--json"]);
    assert!(heard.contains("13 whole frames\n"), "{heard}");
    let (_, from_set, _) = selfcal(&["replay", "opencv_chess_sift", "--json"]);
    let [a, b] = [from_stream, from_set]
        .map(|text| serde_json::from_str::<serde_json::Value>(&text).unwrap());
    assert_eq!([&a["pairs"], &a["state"]], [&b["pairs"], &b["state"]]);
    let apart = |field: &str| (a[field].as_f64().unwrap() - b[field].as_f64().unwrap()).abs();
    assert!(apart("e_t") < 1e-4 && apart("e_theta") < 1e-4, "{a} {b}");

    let (again, _, why) = selfcal(&["record", "opencv_chess_sift", &whole]);
    assert!(!again && why.contains("nothing is overwritten"), "{why}");
    let (_, said, _) =
        selfcal(&["record", "opencv_chess_sift", &bad, "--damaged", "0.4", "--seed", "3"]);
    let damaged: usize =
        said.split(", ").find_map(|s| s.strip_suffix(" damaged")?.parse().ok()).unwrap();
    assert!((2..10).contains(&damaged), "{said}");
    let (good, _, heard) = selfcal(&["replay", &bad, "--rig", "opencv_chess_sift"]);
    // One damaged frame has lost more than 4 bytes and takes the start of the next one.
    assert!(good && heard.contains(&format!("{} whole frames, ", 12 - damaged)), "{heard}");
    let (good, _, why) = selfcal(&["replay", &bad]);
    assert!(!good && why.contains("--rig"), "{why}");
    let (good, _, why) = selfcal(&["replay", &bad, "--rig", "aloe_sift"]);
    assert!(!good && why.contains("images"), "{why}");
    let (good, _, why) = selfcal(&["replay", "aloe_sift", "--rig", "aloe_sift"]);
    assert!(!good && why.contains("rig of its own"), "{why}");
    let (good, _, why) = selfcal(&["replay", "nothing.csv", "--rig", "aloe_sift"]);
    assert!(!good && why.contains("does not exist"), "{why}");
}

#[test]
fn a_stream_replays_to_the_bits_of_the_controller_that_received_it() {
    let set = set("opencv_chess_sift");
    let sender = Sender::of(&set).unwrap();
    let frames = (0..).zip(&set.pairs).flat_map(|(i, pair)| sender.frame(i, pair).0);
    let bytes: Vec<u8> = frames.collect();
    // Two pairs have more matches than the capacity of the controller.
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    let mut controller = Box::new(Calibrator::<f32, 256>::new(Config::robust(), &factory));
    let (mut rest, mut decoder) = (&bytes[..], Decoder::new());
    while decoder.feed(&mut rest, &mut *controller).unwrap().is_some() {
        assert!(controller.solve_pair().pair.is_some());
    }
    let expected = in_f64(&controller.proposal().unwrap().extrinsics);

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flight.scmf");
    std::fs::write(&file, bytes).unwrap();
    let replayed = |capacity: &str| -> Vec<f64> {
        let (good, out, why) = selfcal(&[
            "replay",
            file.to_str().unwrap(),
            "--rig",
            "opencv_chess_sift",
            "--capacity",
            capacity,
            "--json",
        ]);
        assert!(good, "{why}");
        let object: serde_json::Value = serde_json::from_str(&out).unwrap();
        let numbers = [&object["R"], &object["t"]].map(|part| part.as_array().unwrap().clone());
        numbers.concat().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let r = expected.rotation_row_major();
    let expected: Vec<f64> = r.iter().chain(expected.translation().iter()).copied().collect();
    assert_eq!(replayed("256"), expected);
    assert_ne!(replayed("2048"), expected);
}
