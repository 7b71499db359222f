//! Formats with a list `cameras`: OKVIS, maplab (also ESIM and SVO), Spectacular AI, Monado. They differ in their keys.
//!
//! `T_SC` and `T_B_C` take points of a camera to the body, `imuToCamera` takes those of the IMU to the camera, and
//! `opencv_stereo_calibrate` has `R` and `T` of OpenCV. All in metres.

use anyhow::{Context, Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
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
    let count = all.items().len();
    let camera = |n: u8| -> Result<Camera> {
        let item = all.items().into_iter().nth(usize::from(n)).with_context(|| {
            format!(
                "{}: {count} cameras, there is no number {n}: choose the left and the right one (--cameras)",
                all.place()
            )
        })?;
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
        let k = camera_matrix(self.intrinsics()?);
        crate::data::check_camera_matrix(&k).map_err(|why| of.refuse(why))?;
        let numbered = |width: &str, height: &str| match (of.get(&[width]), of.get(&[height])) {
            (Some(width), Some(height)) => Ok(Some([width.count()?, height.count()?])),
            _ => anyhow::Ok(None),
        };
        let own = match of.get(&["image_dimension"]) {
            Some(size) => Some(size.size()?),
            None => numbered("image_width", "image_height")?
                .or(numbered("imageWidth", "imageHeight")?)
                .or(numbered("resolution.width", "resolution.height")?),
        };
        let size = unknowns.size(side, own, of.place())?;
        let (lens, given) = self.lens()?;
        View::with(k, lens, &given, size).map_err(|why| of.refuse(why))
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
        if let Some(all) = of.get(&["intrinsics"]).filter(|all| all.get(&["fx"]).is_none()) {
            return all.array("fu fv cu cv");
        }
        let number = |spectacular: &str, monado: &str| {
            of.need(&[spectacular, &format!("intrinsics.{monado}")], "a number, px")?.number()
        };
        Ok([
            number("focalLengthX", "fx")?,
            number("focalLengthY", "fy")?,
            number("principalPointX", "cx")?,
            number("principalPointY", "cy")?,
        ])
    }

    fn lens(&self) -> Result<(LensModel, Vec<f64>)> {
        let of = &self.inner;
        let model = of.get(&["distortion_type", "distortion.type", "model"]);
        let name = model.as_ref().map(Value::text).unwrap_or_default();
        let (lens, keys): (_, &[&str]) = match (name.as_str(), model) {
            ("equidistant" | "kannala-brandt4" | "fisheye_equidistant4", _) => {
                (LensModel::Fisheye, &["k1", "k2", "k3", "k4"])
            }
            (
                "radialtangential" | "radialtangential8" | "radial-tangential" | "radtan" | "none"
                | "pinhole" | "brown-conrady" | "pinhole_radtan5" | "pinhole_radtan8" | "",
                _,
            )
            | (_, None) => {
                (LensModel::RadialTangential, &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"])
            }
            (_, Some(model)) => bail!(model.refuse(
                "expected radialtangential, equidistant, kannala-brandt4 or pinhole: calibrate with one of them"
            )),
        };
        let places = ["distortion_coefficients", "distortion.parameters", "distortionCoefficients"];
        if let Some(all) = of.get(&places) {
            let given = all.numbers()?;
            return Ok(match *given.as_slice() {
                // Spectacular AI's pinhole has only radial terms.
                [k1, k2, k3] if name == "pinhole" => (lens, vec![k1, k2, 0.0, 0.0, k3]),
                _ => (lens, given),
            });
        }
        let number = |key: &&str| {
            let value = of.get(&[&format!("distortion.{key}")]);
            Ok(value.map(|value| value.number()).transpose()?.unwrap_or(0.0))
        };
        Ok((lens, keys.iter().map(number).collect::<Result<_>>()?))
    }
}
