//! The core's calibrator and its published method behind the same interface, in `f32` as shipped.

use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, Extrinsics, FactoryCalibration,
    Intrinsics, Lens, Scalar,
};

use super::method::{Method, Setting, usable};
use rigs::data::{Rays, in_f64};

/// Capacity of the calibrator; it selects matches from longer pairs.
pub(crate) const CAPACITY: usize = 2048;

/// Largest distance of the image's border from its middle, px; pixels beyond are refused.
const MAX_REACH: f32 = 30_000.0;

/// [`Config::robust`].
#[derive(Debug, Clone, Copy)]
pub struct Robust;

/// [`PaperCalibrator`] with its default settings.
#[derive(Debug, Clone, Copy)]
pub struct Paper;

impl Method for Robust {
    fn name(&self) -> &'static str {
        "robust"
    }

    fn source(&self) -> &'static str {
        "this project, Config::robust, f32: whitened residuals, redescending loss, fusion by moments"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        running(pairs, setting, |cameras, start| {
            let factory = FactoryCalibration::new(cameras, start).without_yaw();
            let mut calibrator =
                Box::new(Calibrator::<f32, CAPACITY>::new(Config::robust(), &factory));
            move |pair: Vec<_>| {
                // A match that the core refuses is left out; a refused pair leaves the estimate unchanged.
                let _ = calibrator.take_pair(pair);
                calibrator.proposal().map(|proposal| proposal.extrinsics)
            }
        })
    }
}

impl Method for Paper {
    fn name(&self) -> &'static str {
        "paper"
    }

    fn source(&self) -> &'static str {
        "this project, paper::PaperCalibrator, f32: Zhao, Zhang, Chen and Fan, \"Dive Deeper into Rectifying \
         Homography for Stereo Camera Online Self-Calibration\", eqs 1-22, errata corrected"
    }

    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>> {
        running(pairs, setting, |cameras, start| {
            let mut calibrator =
                Box::new(PaperCalibrator::<f32, CAPACITY>::new(Settings::DEFAULT, cameras, start));
            move |pair: Vec<_>| {
                let _ = calibrator.take_pair(pair);
                calibrator.estimate().map(|estimate| estimate.extrinsics)
            }
        })
    }
}

/// The estimates after each pair.
///
/// * `begin`: returns a function that takes a pair and returns the estimate.
fn running<F: FnMut(Vec<Correspondence<f32>>) -> Option<Extrinsics<f32>>>(
    pairs: &[Vec<Rays>],
    setting: &Setting,
    begin: impl FnOnce(Cameras<f32>, Extrinsics<f32>) -> F,
) -> Vec<Option<Extrinsics<f64>>> {
    let pairs: Vec<Vec<Rays>> = pairs.iter().map(|rays| usable(rays)).collect();
    let Some((camera, start)) = camera(&pairs, setting).zip(in_f32(&setting.start)) else {
        return vec![None; pairs.len()];
    };
    let mut take = begin(Cameras { left: camera, right: camera }, start);
    let match_of = |[p_l, p_r]: &Rays| {
        let [left, right] = [p_l, p_r].map(|ray| camera.pixel(ray.xy().map(f32::lit)).ok());
        Some(Correspondence { left: left?, right: right?, score: 1.0, grid_step: 0.0 })
    };
    let after = pairs.iter().map(|rays| take(rays.iter().filter_map(match_of).collect()));
    after.map(|estimate| estimate.map(|found| in_f64(&found))).collect()
}

/// A pinhole with the setting's focal length, whose image is centred on the axis and holds all rays within
/// [`MAX_REACH`]. `None` if the core refuses the focal length.
fn camera(pairs: &[Vec<Rays>], setting: &Setting) -> Option<Camera<f32>> {
    let focal = f32::lit(setting.focal);
    let reach = |axis: usize| {
        let rays = pairs.iter().flatten().flatten();
        let furthest = rays.fold(0.0, |most: f64, ray| most.max(ray[axis].abs()));
        f32::lit(furthest * setting.focal).ceil().clamp(1.0, MAX_REACH)
    };
    let reach = [reach(0), reach(1)];
    let size = reach.map(|reach| (2.0 * reach).to_u16() + 1);
    let intrinsics = Intrinsics { focal: [focal; 2], principal: reach, size };
    Camera::try_new(intrinsics, Lens::Pinhole).ok()
}

fn in_f32(extrinsics: &Extrinsics<f64>) -> Option<Extrinsics<f32>> {
    let r = extrinsics.rotation().matrix().map(f32::lit);
    Extrinsics::try_new(&r, &extrinsics.translation().map(f32::lit)).ok()
}
