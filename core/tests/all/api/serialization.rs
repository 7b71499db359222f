//! Parameters, cameras, extrinsics and results as JSON, there and back.

use core::fmt::Debug;

use crate::api::scene::{cameras, correspondences, rig, take};
use serde::{Serialize, de::DeserializeOwned};
use stereo_selfcal::geometry::{
    Fisheye, RadialTangential, Rational, RectifiedCamera, RectifyingRotations,
};
use stereo_selfcal::outcome::Event;
use stereo_selfcal::{
    Calibrator, Camera, Config, Extrinsics, FactoryCalibration, Lens, PairReport, Proposal,
    Rejection, Scalar,
};

fn comes_back<T: Serialize + DeserializeOwned + PartialEq + Debug>(value: &T) -> String {
    let text = serde_json::to_string(value).unwrap();
    assert_eq!(&serde_json::from_str::<T>(&text).unwrap(), value, "{text}");
    text
}

fn refused<T: DeserializeOwned + Debug>(text: &str) -> String {
    serde_json::from_str::<T>(text).unwrap_err().to_string()
}

fn factory<T: Scalar>(lens: Lens<T>) -> FactoryCalibration<T> {
    let mut cameras = cameras();
    cameras.left = Camera::try_new(*cameras.left.intrinsics(), lens).unwrap();
    let extrinsics = rig([3.0, -2.0, 4.0], [3.0, -3.0]);
    FactoryCalibration::new(cameras, extrinsics).with_yaw_sd_rad(8e-4).unwrap()
}

#[test]
fn a_rig_comes_back_bit_for_bit() {
    let brown = RadialTangential::try_new([-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115]).unwrap();
    comes_back(&factory::<f64>(Lens::RadialTangential(brown)));
    let fisheye = Fisheye::try_new([-0.013, 0.027, -0.031, 0.011]).unwrap();
    comes_back(&factory::<f32>(Lens::Fisheye(fisheye)));
    let rational = Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2]).unwrap();
    comes_back(&factory::<f64>(Lens::Rational(rational)));
    comes_back(&factory::<f32>(Lens::Pinhole));
}

#[test]
fn extrinsics_are_plain_arrays_and_are_checked() {
    let text = comes_back(&Extrinsics::<f32>::SIDE_BY_SIDE);
    let plain =
        r#"{"rotation":[1.0,0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0],"translation":[-1.0,0.0,0.0]}"#;
    assert_eq!(text, plain);
    let in_metres = plain.replace("-1.0", "-0.12");
    let extrinsics: Extrinsics<f32> = serde_json::from_str(&in_metres).unwrap();
    assert_eq!(extrinsics, Extrinsics::SIDE_BY_SIDE);
    let reflected = plain.replacen("1.0", "-1.0", 1);
    assert!(refused::<Extrinsics<f32>>(&reflected).contains("R is not a rotation"));
}

#[test]
fn cameras_and_parameters_are_checked() {
    let good = comes_back(&cameras::<f32>());
    let message = refused::<stereo_selfcal::Cameras<f32>>(&good.replace("1400.0", "-1400.0"));
    assert!(message.contains("focal length"), "{message}");
    let message = refused::<RadialTangential<f32>>("[0.0, 0.0, 0.0, 0.0, 2000.0]");
    assert!(message.contains("distortion"), "{message}");
    let good = comes_back(&Config::robust());
    let message = refused::<Config>(&good.replace(":1000,", ":3,"));
    assert!(message.contains("memory must be at least 20 pairs"), "{message}");
    let good = comes_back(&factory::<f32>(Lens::Pinhole).with_baseline_m(0.12).unwrap());
    for (number, absurd, named) in [("0.0008", "2.0", "yaw"), ("0.12", "-0.12", "baseline")] {
        assert!(good.contains(number), "{good}");
        let message = refused::<FactoryCalibration<f32>>(&good.replacen(number, absurd, 1));
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn results_come_back() {
    let factory = FactoryCalibration::guess(cameras());
    let mut calibrator = Calibrator::<f32, 256>::new(Config::robust(), &factory);
    let truth = rig([1.0, -0.5, 0.8], [0.5, -0.4]);
    for seed in 0..5 {
        take(&mut calibrator, &correspondences(&truth, 250, 0.5, seed)).unwrap();
    }
    let outcome = calibrator.take_pair(correspondences(&truth, 250, 0.5, 5));
    let pair: PairReport<f32> = outcome.pair.unwrap();
    let (verdict, details) = (*calibrator.verdict(), calibrator.details().unwrap());
    let proposal: Proposal<f32> = calibrator.proposal().unwrap();
    comes_back(&verdict);
    comes_back(&details);
    comes_back(&proposal);
    comes_back(&pair);
    comes_back(&Event::START.next(7, 1, &verdict, 1).unwrap());
    let rotations = RectifyingRotations::from(&proposal.extrinsics);
    comes_back(&RectifiedCamera::try_choose(&cameras(), &rotations, 0.0).unwrap());
    comes_back(&Rejection::TooFew { usable: 3, needed: 12 });
}
