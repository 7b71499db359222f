//! Calibrator as the sink of frames.

use crate::link::stream::{Frame, HEADER};
use stereo_selfcal::link::{Decoder, FrameHeader, FrameRefusal, Received};
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, FactoryCalibration, Intrinsics, Lens, Rejection, Scalar,
};

const INTRINSICS: Intrinsics<f64> =
    Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };

fn cameras<T: Scalar>(sizes: [[u16; 2]; 2]) -> Cameras<T> {
    let [left, right] = sizes.map(|size| {
        let intrinsics = Intrinsics {
            focal: INTRINSICS.focal.map(T::lit),
            principal: INTRINSICS.principal.map(T::lit),
            size,
        };
        Camera::try_new(intrinsics, Lens::Pinhole).unwrap()
    });
    Cameras { left, right }
}

fn calibrator<T: Scalar>() -> Calibrator<T, 64> {
    of(cameras([INTRINSICS.size; 2]))
}

fn of<T: Scalar>(cameras: Cameras<T>) -> Calibrator<T, 64> {
    Calibrator::new(Config::robust(), &FactoryCalibration::guess(cameras))
}

fn feed<T: Scalar>(
    decoder: &mut Decoder,
    bytes: &[u8],
    calibrator: &mut Calibrator<T, 64>,
) -> Result<Option<Received>, FrameRefusal> {
    let mut bytes = bytes;
    let fed = decoder.feed(&mut bytes, calibrator);
    if fed.is_err() {
        assert_eq!(decoder.feed(&mut bytes, calibrator), Ok(None), "the rest of a refused frame");
    }
    fed
}

#[test]
fn the_batch_equals_the_pushed_matches_of_the_frame() {
    fn check<T: Scalar>() {
        let mut calibrator = calibrator::<T>();
        let mut by_hand = calibrator.clone();
        let frame = Frame::plain(1, 100);
        // The batch first holds another pair.
        feed(&mut Decoder::new(), &Frame::plain(0, 30).bytes(), &mut calibrator).unwrap();
        let received = feed(&mut Decoder::new(), &frame.bytes(), &mut calibrator);
        assert_eq!(received, Ok(Some(Received { header: frame.header, taken: 64 })));
        for c in &frame.matches {
            let c = stereo_selfcal::Correspondence {
                left: c.left.map(T::single),
                right: c.right.map(T::single),
                score: T::single(c.score),
                grid_step: T::single(c.grid_step),
            };
            by_hand.push(&c).unwrap();
        }
        assert_eq!(calibrator.batch().matches(), by_hand.batch().matches());
        assert_eq!([calibrator.batch().offered(), calibrator.batch().left_out()], [100, 36]);
    }
    check::<f32>();
    check::<f64>();
}

#[test]
fn matches_outside_the_image_are_refused_by_the_batch() {
    let mut frame = Frame::plain(1, 10);
    frame.matches[3].left = [1921.0, 0.0];
    let mut calibrator = calibrator::<f32>();
    let received = feed(&mut Decoder::new(), &frame.bytes(), &mut calibrator).unwrap().unwrap();
    assert_eq!((received.header.count, received.taken), (10, 9));
    assert_eq!(calibrator.batch().refused(), 1);
}

#[test]
fn a_damaged_frame_leaves_an_empty_batch() {
    let mut bytes = Frame::plain(1, 10).bytes();
    *bytes.last_mut().unwrap() ^= 1;
    let mut calibrator = calibrator::<f32>();
    assert_eq!(feed(&mut Decoder::new(), &bytes, &mut calibrator), Ok(None));
    assert!(calibrator.batch().matches().is_empty());
    // A match of another source is not hidden: the damaged frame has ended.
    assert_eq!(calibrator.batch().offered(), 0);
    calibrator.push(&Frame::plain(2, 1).matches[0]).unwrap();
    assert_eq!(calibrator.batch().matches().len(), 1);
}

#[test]
fn a_frame_cut_off_anywhere_gives_no_pair() {
    let (old, new) = (Frame::plain(1, 60).bytes(), Frame::plain(2, 50).bytes());
    for cut in 0..=new.len() {
        let mut calibrator = calibrator::<f32>();
        let mut decoder = Decoder::new();
        feed(&mut decoder, &old, &mut calibrator).unwrap();
        let fed = feed(&mut decoder, &new[..cut], &mut calibrator).unwrap();
        let held = match (cut < FrameHeader::BYTES, cut < new.len()) {
            // Before the header is whole, the batch still holds the previous frame.
            (true, _) => 60,
            (false, true) => 0,
            (false, false) => 50,
        };
        assert_eq!(
            (calibrator.batch().matches().len(), fed.is_some()),
            (held, held == 50),
            "{cut}"
        );
        let outcome = calibrator.solve_pair();
        let too_few = Err(Rejection::TooFew { usable: 0, needed: 12 });
        assert_eq!(outcome.fused == too_few, held == 0, "{cut}");
        // The call of `solve_pair` has lost nothing: the frame continues.
        if held == 0 {
            let rest = feed(&mut decoder, &new[cut..], &mut calibrator).unwrap().unwrap();
            assert_eq!((rest.taken, calibrator.batch().matches().len()), (50, 50), "{cut}");
        }
    }
}

#[test]
fn the_second_half_of_a_frame_that_was_given_up_is_dropped() {
    let bytes = Frame::plain(1, 50).bytes();
    let by_hand = Frame::plain(9, 20).matches;
    for (end, taken) in [(0_u8, Some(0)), (1, None)] {
        let mut calibrator = calibrator::<f32>();
        let mut decoder = Decoder::new();
        let (first, second) = bytes.split_at(400);
        feed(&mut decoder, first, &mut calibrator).unwrap();
        calibrator.discard_pair();
        for c in &by_hand {
            calibrator.push(c).unwrap();
        }
        let mut second = second.to_vec();
        *second.last_mut().unwrap() ^= end;
        let fed = feed(&mut decoder, &second, &mut calibrator).unwrap();
        assert_eq!(fed.map(|received| received.taken), taken);
        assert_eq!(calibrator.batch().matches().len(), by_hand.len());
    }
}

#[test]
fn a_frame_of_another_image_size_is_refused_and_counted_and_the_batch_stays() {
    let mut calibrator = calibrator::<f32>();
    let mut decoder = Decoder::new();
    feed(&mut decoder, &Frame::plain(1, 10).bytes(), &mut calibrator).unwrap();
    let mut other = Frame::plain(2, 20);
    other.header.image_size = [1280, 1200];
    let bytes = [other.bytes(), Frame::plain(3, 12).bytes()].concat();
    let mut rest = bytes.as_slice();
    let refused = decoder.feed(&mut rest, &mut calibrator);
    assert_eq!(refused, Err(FrameRefusal::ImageSize([1280, 1200])));
    assert_eq!(calibrator.batch().matches().len(), 10);
    let next = decoder.feed(&mut rest, &mut calibrator).unwrap().unwrap();
    assert_eq!((next.header.sequence, next.taken), (3, 12));
    assert_eq!((decoder.counters().refused, decoder.counters().good), (1, 2));
    assert_eq!(decoder.counters().gaps, 0, "a refused frame is not missing");
}

#[test]
fn the_left_camera_must_have_the_size_of_the_images_and_the_right_one_its_own() {
    let received = |sizes| {
        let mut calibrator = of::<f32>(cameras(sizes));
        feed(&mut Decoder::new(), &Frame::plain(1, 1).bytes(), &mut calibrator)
    };
    let refused = Err(FrameRefusal::ImageSize([1920, 1200]));
    assert_eq!(received([[1919, 1200], [1920, 1200]]), refused);
    for right in [[1920, 1199], [2448, 2048]] {
        assert!(received([[1920, 1200], right]).is_ok_and(|fed| fed.is_some()));
    }
}

#[test]
fn a_frame_is_refused_while_a_pair_is_solved() {
    let mut calibrator = calibrator::<f32>();
    let mut decoder = Decoder::new();
    feed(&mut decoder, &Frame::plain(1, 50).bytes(), &mut calibrator).unwrap();
    let mut alone = calibrator.clone();
    let expected = alone.solve_pair();

    assert_eq!(calibrator.advance_pair(), None);
    let fed = feed(&mut decoder, &Frame::plain(2, 50).bytes(), &mut calibrator);
    assert_eq!(fed, Err(FrameRefusal::Busy));
    // A damaged frame is refused as well.
    let header = FrameHeader { sequence: 3, ..HEADER };
    let damaged = [&header.encode().unwrap()[..], &[0; 4]].concat();
    assert_eq!(feed(&mut decoder, &damaged, &mut calibrator), Err(FrameRefusal::Busy));
    let outcome = (0..200).find_map(|_| calibrator.advance_pair()).unwrap();
    assert_eq!(outcome, expected);
    let fed = feed(&mut decoder, &Frame::plain(4, 50).bytes(), &mut calibrator);
    assert_eq!(fed.unwrap().unwrap().taken, 50);
}
