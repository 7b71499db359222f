//! Tracks of a matcher, from the bytes of frames to a measurement of the yaw.

use crate::api::depth::{NONE, Tested, calibrated, off, run};
use crate::api::scene::cameras;
use crate::api::witness::tracked;
use crate::link::vectors;
use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{MotionError, Tracks, Witnessed};
use stereo_selfcal::link::{Decoder, Encoder, FrameHeader, MatchRecord, Tracking};
use stereo_selfcal::{Config, Correspondence, Reason};

const HEADER: FrameHeader = FrameHeader { grid_step: 0, fraction_bits: 8, ..vectors::HEADER };

/// The match with these rays, rounded to the resolution of the wire; `None` if a pixel is outside its image.
fn seen(rays: &RayPair<f32>) -> Option<Correspondence<f32>> {
    let cameras = cameras::<f32>();
    let left = cameras.left.pixel(rays.left().into()).ok()?;
    let right = cameras.right.pixel(rays.right().into()).ok()?;
    let c = Correspondence { left, right, score: 1.0, grid_step: 0.0 };
    let c = MatchRecord::encode(&c, &HEADER).ok()?.decode(&HEADER);
    cameras.rays(&c).is_ok().then_some(c)
}

/// A frame of matches with tracks.
fn frame(sequence: u32, matches: &[(Correspondence<f32>, u16)]) -> Vec<u8> {
    let header = FrameHeader { sequence, count: matches.len() as u16, ..HEADER };
    let (mut encoder, start) = Encoder::begin(header).unwrap();
    let mut bytes = start.to_vec();
    bytes.extend(matches.iter().flat_map(|(c, track)| encoder.push_tracked(c, *track).unwrap()));
    bytes.extend(encoder.finish().unwrap());
    bytes
}

fn feed(calibrator: &mut Tested, tracks: &mut Tracks<f32, 256>, bytes: &[u8]) {
    let mut decoder = Decoder::new();
    let mut rest = bytes;
    let mut sink = Tracking { calibrator, tracks: Some(tracks) };
    assert!(decoder.feed(&mut rest, &mut sink).unwrap().is_some());
}

#[test]
fn tracked_frames_of_a_moving_rig_tell_the_yaw_of_the_mount() {
    let knock = [0.0, 1.0, 0.0];
    let mut calibrator = calibrated(Config::robust());
    run(&mut calibrator, knock, 0.009, 0..10);
    let mut tracks = Tracks::new();
    for (at, turn) in (0..).zip([0.0, 0.03, -0.03]) {
        let quads = tracked(knock, 0.009, [0.5, 0.1, -4.0], turn);
        // Only matches within the images. Each match has its own track, and the second frame has another order.
        let both = quads.iter().filter_map(|[one, two]| Some([seen(one)?, seen(two)?]));
        let both: Vec<_> = both.zip(100 + 300 * at..).collect();
        let [before, mut after] =
            [0, 1].map(|i| both.iter().map(|(both, track)| (both[i], *track)).collect::<Vec<_>>());
        after.reverse();
        feed(&mut calibrator, &mut tracks, &frame(0, &before));
        assert!(tracks.quads().is_empty());
        let _ = calibrator.solve_pair();
        assert_eq!(calibrator.push_tracks(&mut tracks), Err(MotionError::TooFew));
        feed(&mut calibrator, &mut tracks, &frame(1, &after));
        let rays = |c: &Correspondence<f32>| cameras().rays(c).unwrap();
        let sent: Vec<_> = both.iter().rev().map(|(both, _)| both.each_ref().map(rays)).collect();
        assert!(sent.len() > 80 && tracks.quads() == sent, "{}", tracks.quads().len());
        let _ = calibrator.solve_pair();
        assert_eq!(calibrator.push_tracks(&mut tracks), Ok(Witnessed::Taken), "{turn}");
        assert!(tracks.quads().is_empty());
    }
    calibrator.apply().unwrap();
    let (details, yaw) = (calibrator.details().unwrap(), off(&calibrator, knock).y);
    assert!(yaw.abs() < 4e-4 && yaw.abs() < 2.5 * details.yaw, "{yaw} {details}");
    assert!(!calibrator.verdict().reasons.contains(Reason::Yaw), "{details}");
}

#[test]
fn a_damaged_frame_is_not_joined_and_the_next_one_is_joined_to_the_frame_before_it() {
    let mut calibrator = calibrated(Config::robust());
    run(&mut calibrator, NONE, 0.0, 0..2);
    let matches: Vec<_> = tracked(NONE, 0.0, [0.0, 0.0, -1.0], 0.0)
        .iter()
        .filter_map(|[one, _]| seen(one))
        .zip(1..)
        .collect();
    let mut tracks = Tracks::new();
    feed(&mut calibrator, &mut tracks, &frame(0, &matches));
    let mut bytes = frame(1, &matches);
    bytes[100] ^= 1;
    let mut sink = Tracking { calibrator: &mut calibrator, tracks: Some(&mut tracks) };
    assert_eq!(Decoder::new().feed(&mut &bytes[..], &mut sink), Ok(None));
    assert!(tracks.quads().is_empty() && calibrator.batch().matches().is_empty());
    feed(&mut calibrator, &mut tracks, &frame(2, &matches));
    assert_eq!(tracks.quads().len(), matches.len());
    // Without `tracks` in the sink, the tracks are ignored.
    let mut sink = Tracking::<f32, 256, 0> { calibrator: &mut calibrator, tracks: None };
    let received = Decoder::new().feed(&mut &frame(3, &matches)[..], &mut sink).unwrap();
    assert_eq!(received.unwrap().taken, matches.len());
}
