//! Rigs of COLMAP: `cameras.txt` with `rigs.txt`, or with `rig_config.json`.
//!
//! `sensor_from_rig` and `cam_from_rig` take points of the rig to a camera; quaternions are `w x y z`. The corner of
//! the first pixel is at `(0, 0)`, so its centre is at half a pixel. Lengths are in the unit of the model.

use anyhow::{Context, Result, bail, ensure};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// A sensor of a rig.
struct Sensor {
    /// Number in `cameras.txt`.
    camera: Option<f64>,
    /// Model and parameters of the camera in the file of the rig itself, which has no image sizes.
    own: Option<(String, Vec<f64>)>,
    from_rig: Rigid,
    place: String,
}

/// The whole rig: the first of a file.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let mut files = files.clone();
    let _ = files.beside("cameras.txt");
    let sensors = match (files.get(&["rigs.txt"]), files.get(&[""])) {
        (Some(table), _) => of_table(&table)?,
        (None, Some(config)) => of_config(&config)?,
        _ => bail!(
            "{files}: cameras.txt alone has no extrinsics: give rigs.txt or rig_config.json beside it"
        ),
    };
    let count = sensors.len();
    let chosen = unknowns.cameras_or([0, 1]).map(|n| sensors.get(usize::from(n)));
    let [Some(left), Some(right)] = chosen else {
        bail!(
            "{files}: a rig of {count} cameras: the left and the right one are chosen with --cameras, from 0"
        );
    };
    let way = left.from_rig.inverse().then(&right.from_rig);
    let pose = Pose::of(&way, &right.place)?.in_unit(unknowns.unit_m)?;
    let view = |side: usize, sensor: &Sensor| view(&files, side, sensor, unknowns);
    rig::meta([view(0, left)?, view(1, right)?], &pose, format!("COLMAP: {files}"))
}

/// Fields of a row of a rig.
const FIELDS: &str = "RIG_ID NUM_SENSORS REF_TYPE REF_ID, and TYPE ID HAS_POSE [QW QX QY QZ TX TY TZ] of each other sensor";

/// The cameras of the first row ([`FIELDS`]): the reference sensor if it is a camera, then those that have a pose.
fn of_table(table: &Value) -> Result<Vec<Sensor>> {
    let rows = table.items();
    let row =
        rows.first().with_context(|| format!("{}: expected a row with a rig", table.place()))?;
    let words = row.items();
    let word = |i: usize| {
        words.get(i).with_context(|| {
            format!("{}: the row of the rig is cut short: expected {FIELDS}", row.place())
        })
    };
    let mut sensors = Vec::new();
    let mut add = |kind: &Value, camera: f64, from_rig: Rigid| {
        if kind.text() == "CAMERA" {
            let place = row.place().to_owned();
            sensors.push(Sensor { camera: Some(camera), own: None, from_rig, place });
        }
    };
    add(word(2)?, word(3)?.number()?, Rigid::NONE);
    let mut at = 4;
    while at < words.len() {
        let (kind, camera) = (word(at)?, word(at + 1)?.number()?);
        let has_pose = word(at + 2)?.number()? != 0.0;
        at += 3;
        if has_pose {
            let mut seven = [0.0; 7];
            for (i, number) in seven.iter_mut().enumerate() {
                *number = word(at + i)?.number()?;
            }
            at += 7;
            let [w, x, y, z, a, b, c] = seven;
            let from_rig =
                Rigid::of_quaternion([w, x, y, z], [a, b, c]).map_err(|why| row.refuse(why))?;
            add(kind, camera, from_rig);
        }
    }
    Ok(sensors)
}

/// The first of a list of rigs, each with `cameras`.
fn of_config(config: &Value) -> Result<Vec<Sensor>> {
    let rigs = config.items();
    let rig =
        rigs.first().with_context(|| format!("{}: expected a list of rigs", config.place()))?;
    let cameras = rig.need(&["cameras"], "the cameras of a rig")?;
    let sensor = |(i, camera): (u32, &Value)| -> Result<Sensor> {
        let rotation = camera.get(&["cam_from_rig_rotation", "rel_qvec"]);
        let translation = camera.get(&["cam_from_rig_translation", "rel_tvec"]);
        let from_rig = match (rotation, translation) {
            (Some(q), Some(t)) => {
                Rigid::of_quaternion(q.array("a quaternion, w x y z")?, t.array("a translation")?)
                    .map_err(|why| q.refuse(why))?
            }
            (None, None) => Rigid::NONE,
            _ => bail!(
                camera.refuse("expected both cam_from_rig_rotation and cam_from_rig_translation")
            ),
        };
        let own = match (camera.get(&["camera_model_name"]), camera.get(&["camera_params"])) {
            (Some(model), Some(params)) => Some((model.text(), params.numbers()?)),
            _ => None,
        };
        let number = camera.get(&["camera_id"]).map(|id| id.number()).transpose()?;
        Ok(Sensor {
            camera: Some(number.unwrap_or(f64::from(i) + 1.0)),
            own,
            from_rig,
            place: camera.place().to_owned(),
        })
    };
    (0..).zip(&cameras.items()).map(sensor).collect()
}

fn view(files: &Files, side: usize, sensor: &Sensor, unknowns: Unknowns) -> Result<View> {
    if let Some((model, params)) = &sensor.own {
        let size = unknowns.size(side, None, &sensor.place)?;
        return camera(model, params, size).with_context(|| sensor.place.clone());
    }
    let table = files.find(&["cameras.txt"], "the table of the cameras, beside the rig")?;
    let rows = table.items();
    let id = |row: &&Value| row.items().first().and_then(|id| id.number().ok()) == sensor.camera;
    let row = rows.iter().find(id).with_context(|| {
        let camera = sensor.camera.unwrap_or_default();
        format!(
            "{}: camera {camera} of {} is missing: expected a row of it",
            table.place(),
            sensor.place
        )
    })?;
    let words = row.items();
    let [_, model, width, height, params @ ..] = words.as_slice() else {
        bail!(row.refuse("expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS"));
    };
    let params = params.iter().map(Value::number).collect::<Result<Vec<_>>>()?;
    camera(&model.text(), &params, [width.count()?, height.count()?])
        .with_context(|| row.place().to_owned())
}

/// A camera of a model of COLMAP.
fn camera(model: &str, params: &[f64], size: [u16; 2]) -> Result<View> {
    let (lens, focals, names) = match model {
        "SIMPLE_PINHOLE" => (LensModel::RadialTangential, 1, 0),
        "PINHOLE" => (LensModel::RadialTangential, 2, 0),
        "SIMPLE_RADIAL" => (LensModel::RadialTangential, 1, 1),
        "RADIAL" => (LensModel::RadialTangential, 1, 2),
        "OPENCV" => (LensModel::RadialTangential, 2, 4),
        "FULL_OPENCV" => (LensModel::RadialTangential, 2, 8),
        "OPENCV_FISHEYE" => (LensModel::Fisheye, 2, 4),
        "SIMPLE_RADIAL_FISHEYE" => (LensModel::Fisheye, 1, 1),
        "RADIAL_FISHEYE" => (LensModel::Fisheye, 1, 2),
        _ => bail!(
            "camera model {model}: expected SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV or a fisheye: calibrate with OPENCV"
        ),
    };
    ensure!(
        params.len() == focals + 2 + names,
        "camera model {model}: {} parameters: expected {}",
        params.len(),
        focals + 2 + names
    );
    let (focal, rest) = params.split_at(focals);
    let [cx, cy, given @ ..] = rest else { bail!("camera model {model}: no principal point") };
    let (fx, fy) = (focal[0], focal[focals - 1]);
    let mut given = given.to_vec();
    if lens == LensModel::Fisheye {
        given.resize(4, 0.0);
    }
    View::try_new([fx, fy, cx - 0.5, cy - 0.5], lens, &given, size)
}
