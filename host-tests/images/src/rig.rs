//! The rig of some images: given, found beside them, or guessed.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use exif::{In, Tag, Value};
use host_tests::data::{Dataset, LensModel, Meta, Rows};
use selfcal_commands::conventions::{self, Unknowns};

use crate::source::{Frame, RigOf};

/// Diagonal of 35 mm film, mm.
const FILM_MM: f64 = 43.267;

/// A rig for images of a size, and what must be said about it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRig {
    /// The rig.
    pub meta: Meta,
    /// Whether its intrinsics are a guess.
    pub guessed: bool,
    /// What the user has to know.
    pub notes: Vec<String>,
}

/// What the user said about the rig.
#[derive(Debug, Clone, Default)]
pub struct RigRequest {
    /// Files of a calibration.
    pub files: Vec<PathBuf>,
    /// Focal length for a guess, px.
    pub focal_px: Option<f64>,
}

impl RigRequest {
    /// The rig: of the given files, of the focal length, of the source, or of the EXIF data of an image.
    ///
    /// * `size`: of the images, px.
    /// * `frame`: a left image.
    ///
    /// # Errors
    /// If there is none, or it is of images of another shape.
    pub fn find(&self, source: &RigOf, size: [u16; 2], frame: &Frame) -> Result<FoundRig> {
        if !self.files.is_empty() {
            return fitted(read(&self.files, size)?, size);
        }
        if let Some(focal) = self.focal_px {
            ensure!(focal.is_finite() && focal >= 1.0, "the focal length must be at least 1 px");
            return Ok(guess(focal, size, "--focal"));
        }
        match source {
            RigOf::Files(files) if !files.is_empty() => fitted(read(files, size)?, size),
            RigOf::Read(meta) => fitted(meta.as_ref().clone(), size),
            _ => match focal_of_exif(frame, size) {
                Some(focal) => Ok(guess(focal, size, "EXIF")),
                None => bail!(
                    "no rig: give its calibration (--rig FILE), or the focal length in px for a guess (--focal PX)"
                ),
            },
        }
    }
}

fn read(files: &[PathBuf], size: [u16; 2]) -> Result<Meta> {
    if let [one] = files {
        let text = std::fs::read_to_string(one).unwrap_or_default();
        let folder = one.join("meta.json").is_file();
        if folder || text.contains("\"K_l\"") || (!one.exists() && one.extension().is_none()) {
            return Dataset::find_meta(one);
        }
    }
    let unknown = Unknowns { size: Some(size), ..Unknowns::default() };
    // Most formats have the size and refuse one from elsewhere: their error is the one to show.
    conventions::import(files, Unknowns::default())
        .or_else(|why| conventions::import(files, unknown).map_err(|_| why))
}

/// The rig for images of a size: scaled if they are of the same shape.
fn fitted(meta: Meta, size: [u16; 2]) -> Result<FoundRig> {
    let [width, height] = size;
    let own = [meta.width, meta.height];
    if own == size {
        return Ok(FoundRig { meta, guessed: false, notes: Vec::new() });
    }
    let cross = |a: u16, b: u16| u32::from(a) * u32::from(b);
    ensure!(
        cross(width, own[1]) == cross(height, own[0]),
        "the rig is of images of {} x {} px, these have {width} x {height}: not the same shape, so they were cut or \
         the rig is of another camera",
        own[0],
        own[1]
    );
    let scale = f64::from(width) / f64::from(own[0]);
    let note = format!(
        "the rig is of images of {} x {} px: scaled by {scale} to {width} x {height}",
        own[0], own[1]
    );
    Ok(FoundRig { meta: scaled(&meta, scale, size), guessed: false, notes: vec![note] })
}

/// Intrinsics of an image resampled to another size. The centre of the first pixel is at 0: the border moves
/// by half a pixel.
fn scaled(meta: &Meta, scale: f64, [width, height]: [u16; 2]) -> Meta {
    let camera = |[[fx, skew, cx], [zero, fy, cy], bottom]: Rows| {
        let centre = |c: f64| (c + 0.5) * scale - 0.5;
        [[fx * scale, skew, centre(cx)], [zero, fy * scale, centre(cy)], bottom]
    };
    Meta { k_l: camera(meta.k_l), k_r: camera(meta.k_r), width, height, ..meta.clone() }
}

fn guess(focal: f64, [width, height]: [u16; 2], from: &str) -> FoundRig {
    let [cx, cy] = [width, height].map(|n| (f64::from(n) - 1.0) / 2.0);
    let k = [[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]];
    let meta = Meta {
        k_l: k,
        k_r: k,
        dist_l: vec![0.0; 5],
        dist_r: vec![0.0; 5],
        lens: LensModel::RadialTangential,
        width,
        height,
        r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        t: [-1.0, 0.0, 0.0],
        baseline_m: None,
        source: format!("a guess: focal length {focal:.0} px ({from})"),
        license: String::new(),
        sigma_r_deg: None,
        sigma_t_deg: None,
        other: serde_json::Map::new(),
    };
    let note = format!(
        "THE RIG IS A GUESS: focal length {focal:.0} px ({from}) for both cameras, principal points in the middle, no \
         distortion, side by side. Row offsets, and roll and pitch between the cameras, can be used to line up rows. \
         Yaw, t, depths and the standard deviations cannot be trusted: they depend on the lenses. Calibrate the \
         cameras once, and give the file (--rig)."
    );
    FoundRig { meta, guessed: true, notes: vec![note] }
}

/// Focal length from the EXIF data of a file, px.
fn focal_of_exif(frame: &Frame, size: [u16; 2]) -> Option<f64> {
    let Frame::File(path) = frame else { return None };
    focal_in(path, size).ok().flatten()
}

fn focal_in(path: &Path, [width, height]: [u16; 2]) -> Result<Option<f64>> {
    let file = File::open(path).context("cannot open")?;
    let exif = exif::Reader::new().read_from_container(&mut BufReader::new(file))?;
    let number = |tag: Tag| -> Option<f64> {
        let field = exif.get_field(tag, In::PRIMARY)?;
        match &field.value {
            Value::Rational(all) => all.first().map(exif::Rational::to_f64),
            other => other.get_uint(0).map(f64::from),
        }
        .filter(|x| x.is_finite() && *x > 0.0)
    };
    let diagonal = f64::from(width).hypot(f64::from(height));
    if let Some(film) = number(Tag::FocalLengthIn35mmFilm) {
        return Ok(Some(film / FILM_MM * diagonal));
    }
    // Pixels to a unit of the sensor: 2 is inches, 3 centimetres.
    let unit_mm = if number(Tag::FocalPlaneResolutionUnit) == Some(3.0) { 10.0 } else { 25.4 };
    let both = number(Tag::FocalLength).zip(number(Tag::FocalPlaneXResolution));
    Ok(both.map(|(mm, resolution)| mm * resolution / unit_mm))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meta() -> Meta {
        Dataset::find_meta(Path::new("opencv_chess_sift")).unwrap()
    }

    #[test]
    fn a_rig_of_twice_the_size_is_scaled_and_one_of_another_shape_is_refused() {
        let found = fitted(meta(), [320, 240]).unwrap();
        assert!(found.notes[0].contains("scaled by 0.5"), "{:?}", found.notes);
        let (whole, half) =
            (meta().cameras::<f64>().unwrap(), found.meta.cameras::<f64>().unwrap());
        // The corners of the image see the same rays.
        for (u, v) in [(-0.5, -0.5), (639.5, 479.5), (319.5, 200.0)] {
            let halved = |x: f64| 0.5 * x - 0.25;
            let [a, b] =
                [whole.left.ray([u, v]).unwrap(), half.left.ray([halved(u), halved(v)]).unwrap()];
            assert!((a - b).amax() < 1e-12, "{a} {b}");
        }
        let refused = fitted(meta(), [640, 360]).unwrap_err().to_string();
        assert!(refused.contains("not the same shape"), "{refused}");
    }

    #[test]
    fn a_guess_says_loudly_what_cannot_be_trusted() {
        let request = RigRequest { focal_px: Some(500.0), ..RigRequest::default() };
        let frame = Frame::File(PathBuf::from("none.png"));
        let found = request.find(&RigOf::Nothing, [640, 480], &frame).unwrap();
        assert!(found.guessed && found.notes[0].contains("cannot be trusted"), "{:?}", found.notes);
        found.meta.cameras::<f64>().unwrap();
        let nothing = RigRequest::default().find(&RigOf::Nothing, [640, 480], &frame);
        assert!(nothing.unwrap_err().to_string().contains("--focal"));
    }

    /// A JPEG image with EXIF data of these fields.
    fn photograph(path: &Path, fields: &[exif::Field]) {
        let mut writer = exif::experimental::Writer::new();
        for field in fields {
            writer.push_field(field);
        }
        let mut tiff = std::io::Cursor::new(Vec::new());
        writer.write(&mut tiff, false).unwrap();
        let segment = [b"Exif\0\0".to_vec(), tiff.into_inner()].concat();
        let mut jpeg = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(640, 480).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
        let (start, rest) = jpeg.get_ref().split_at(2);
        let length = u16::try_from(segment.len() + 2).unwrap().to_be_bytes();
        std::fs::write(path, [start, &[0xff, 0xe1], &length, &segment, rest].concat()).unwrap();
    }

    #[test]
    fn the_focal_length_is_that_of_the_exif_data() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("photograph.jpg");
        let field = |tag: Tag, value: Value| exif::Field { tag, ifd_num: In::PRIMARY, value };
        let ratio = |num, denom| Value::Rational(vec![exif::Rational { num, denom }]);
        let focal = |fields: &[exif::Field]| {
            photograph(&path, fields);
            let found =
                RigRequest::default().find(&RigOf::Nothing, [640, 480], &Frame::File(path.clone()));
            found.map(|rig| (rig.guessed, rig.meta.k_l[0][0]))
        };
        // 28 mm of the film's diagonal, 800 px here.
        let film = field(Tag::FocalLengthIn35mmFilm, Value::Short(vec![28]));
        let (guessed, px) = focal(&[film]).unwrap();
        assert!(guessed && (px - 28.0 / 43.267 * 800.0).abs() < 1e-9, "{px}");
        // 4 mm, and 2000 pixels a centimetre.
        let [length, resolution, unit] = [
            field(Tag::FocalLength, ratio(40, 10)),
            field(Tag::FocalPlaneXResolution, ratio(2000, 1)),
            field(Tag::FocalPlaneResolutionUnit, Value::Short(vec![3])),
        ];
        let (_, px) = focal(&[length, resolution, unit]).unwrap();
        assert!((px - 800.0).abs() < 1e-9, "{px}");
        let nothing = field(Tag::FocalLength, ratio(0, 1));
        assert!(focal(&[nothing]).unwrap_err().to_string().contains("--focal"));
    }
}
