//! Formats with a list `cameras`: OKVIS, maplab (also ESIM and SVO), Spectacular AI, Monado. They differ in their keys.
//!
//! `T_SC` and `T_B_C` take points of a camera to the body, `imuToCamera` takes those of the IMU to the camera, and
//! `opencv_stereo_calibrate` has `R` and `T` of OpenCV. All in metres.

use anyhow::{Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// A camera of the list.
struct Camera<'a> {
    item: Value<'a>,
    /// The item, or its inner map in maplab.
    inner: Value<'a>,
}

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["cameras"])?;
    let all = file.need(&["cameras"], "a list of cameras")?;
    let camera = |n: u8| -> Result<Camera> {
        let item = all.camera(n)?;
        let inner = item.get(&["camera"]).unwrap_or_else(|| item.clone());
        Ok(Camera { item, inner })
    };
    let [left, right] = unknowns.cameras_or([0, 1]);
    let cameras = [camera(left)?, camera(right)?];
    let way = match file.get(&["opencv_stereo_calibrate"]) {
        Some(opencv) => Rigid {
            r: rig::rotation(&opencv.need(&["rotation"], "9 numbers")?)?,
            t: opencv.need(&["translation"], "3 numbers, m")?.array::<3>("a translation")?.into(),
        },
        None => Rigid::left_to_right([cameras[0].to_body()?, cameras[1].to_body()?]),
    };
    let pose = Pose::of(&way, cameras[1].item.place())?;
    let view = |side: usize| cameras[side].view(side, unknowns);
    rig::meta([view(0)?, view(1)?], &pose, format!("list of cameras: {files}"))
}

impl Camera<'_> {
    fn to_body(&self) -> Result<Rigid> {
        match (self.item.get(&["T_SC", "T_B_C"]), self.item.get(&["imuToCamera"])) {
            (Some(to_body), _) => to_body.transform(),
            (None, Some(from_imu)) => Ok(from_imu.transform()?.inverse()),
            _ => bail!(
                "{}: T_SC or T_B_C or imuToCamera is missing: expected 4 x 4 numbers",
                self.item.place()
            ),
        }
    }

    fn view(&self, side: usize, unknowns: Unknowns) -> Result<View> {
        let of = &self.inner;
        let own = match of.get(&["image_dimension"]) {
            Some(size) => Some(size.size()?),
            None => of.size_if(
                &["image_width", "imageWidth", "resolution.width"],
                &["image_height", "imageHeight", "resolution.height"],
            )?,
        };
        let size = unknowns.size(side, own, of.place())?;
        let (lens, given) = self.lens()?;
        View::try_new(self.intrinsics()?, lens, &given, size).map_err(|why| of.refuse(why))
    }

    /// `fx fy cx cy`.
    fn intrinsics(&self) -> Result<[f64; 4]> {
        let of = &self.inner;
        if let (Some(focal), Some(centre)) =
            (of.get(&["focal_length"]), of.get(&["principal_point"]))
        {
            let ([fx, fy], [cx, cy]) =
                (focal.array("two focal lengths")?, centre.array("a principal point")?);
            return Ok([fx, fy, cx, cy]);
        }
        match of.get(&["intrinsics"]) {
            Some(all) if all.get(&["fx"]).is_none() => all.array("fu fv cu cv"),
            Some(all) => all.numbers_at(["fx", "fy", "cx", "cy"]),
            None => of.numbers_at([
                "focalLengthX",
                "focalLengthY",
                "principalPointX",
                "principalPointY",
            ]),
        }
    }

    fn lens(&self) -> Result<(LensModel, Vec<f64>)> {
        let of = &self.inner;
        let models = ["distortion_type", "distortion.type", "model"];
        let lens = rig::lens_at(of, &models)?;
        let places = ["distortion_coefficients", "distortion.parameters", "distortionCoefficients"];
        if let Some(all) = of.get(&places) {
            let given = all.numbers()?;
            return Ok(match *given.as_slice() {
                // Spectacular AI's pinhole has only radial terms.
                [k1, k2, k3] if of.text_at(&models) == "pinhole" => {
                    (lens, vec![k1, k2, 0.0, 0.0, k3])
                }
                _ => (lens, given),
            });
        }
        let key = |key: &&str| format!("distortion.{key}");
        let keys: Vec<String> = rig::coefficient_keys(lens).iter().map(key).collect();
        Ok((lens, of.numbers_or_0(&keys)?))
    }
}
