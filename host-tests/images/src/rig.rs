//! The rig of images: given, found beside them, or guessed.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use exif::{In, Tag, Value};
use rigs::data::Meta;
use rigs::formats::Unknowns;
use rigs::{doubts, read_rig};

use crate::resized::{self, Change};
use crate::source::{Frame, RigOf};

/// Diagonal of 35 mm film, mm.
const FILM_MM: f64 = 43.267;

/// A rig for images of a given size, and notes about it.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundRig {
    /// The rig.
    pub meta: Meta,
    /// Whether its intrinsics are a guess.
    pub guessed: bool,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// The rig under the assumption that the images were cropped from the middle instead of scaled, if both are
    /// possible.
    pub if_cut: Option<Box<Meta>>,
}

/// Origin of images whose size differs from the rig's.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Cut {
    /// Unspecified.
    #[default]
    Unknown,
    /// They were scaled.
    Scaled,
    /// They were cropped from the middle.
    Centre,
    /// They were cropped at a position, px.
    At([u16; 2]),
}

/// The user's options for the rig.
#[derive(Debug, Clone, Default)]
pub struct RigRequest {
    /// Files of a calibration.
    pub files: Vec<PathBuf>,
    /// Values that the files may lack.
    pub unknowns: Unknowns,
    /// Focal length for a guess, px.
    pub focal_px: Option<f64>,
    /// Origin of images of another size.
    pub cut: Cut,
}

impl RigRequest {
    /// Finds the rig: in the given files, from the given focal length, in the source, or in the EXIF data of an image,
    /// in this order. The rig of the source is not read if the user gives files or a focal length.
    ///
    /// * `sizes`: sizes of the left and the right images, px.
    /// * `frame`: a left image.
    ///
    /// # Errors
    /// If there is no rig, or it belongs to images of another shape.
    pub fn find(&self, source: &RigOf, sizes: [[u16; 2]; 2], frame: &Frame) -> Result<FoundRig> {
        let unknowns = Unknowns { sizes: self.unknowns.sizes.or(Some(sizes)), ..self.unknowns };
        if !self.files.is_empty() {
            return self.read(&self.files, unknowns, sizes);
        }
        if let Some(focal) = self.focal_px {
            ensure!(
                focal.is_finite() && focal >= 1.0,
                "--focal {focal}: the focal length must be at least 1 px"
            );
            return Ok(guess(focal, sizes, "--focal"));
        }
        let advice =
            "give its calibration (--rig FILE), or the focal length in px for a guess (--focal PX)";
        let missing = match source {
            RigOf::Files(files) if !files.is_empty() => {
                return self.read(files, unknowns, sizes);
            }
            RigOf::Read(meta) => return self.fitted(meta.as_ref().clone(), sizes),
            RigOf::Infos(infos) => match infos
                .rig()
                .with_context(|| format!("{advice}, since the bag has no valid one"))?
            {
                Some(meta) => return self.fitted(meta, sizes),
                None => infos.missing(),
            },
            _ => "none is beside the images".into(),
        };
        match focal_of_exif(frame, sizes[0]) {
            Some(focal) => Ok(guess(focal, sizes, "EXIF")),
            None => bail!("no calibration: {missing}; {advice}"),
        }
    }

    /// The rig of files, with the doubts about it as notes.
    fn read(
        &self,
        files: &[PathBuf],
        unknowns: Unknowns,
        sizes: [[u16; 2]; 2],
    ) -> Result<FoundRig> {
        let meta = read_rig(files, unknowns)?;
        let mut notes = doubts(&meta);
        let mut rig = self.fitted(meta, sizes)?;
        notes.append(&mut rig.notes);
        Ok(FoundRig { notes, ..rig })
    }

    /// The rig for images of these sizes. Images of another size than the rig's are scaled or cropped as the user says;
    /// otherwise they count as scaled if they have the same shape.
    fn fitted(&self, meta: Meta, sizes: [[u16; 2]; 2]) -> Result<FoundRig> {
        let own = meta.sizes();
        if own == sizes {
            return Ok(FoundRig { meta, guessed: false, notes: Vec::new(), if_cut: None });
        }
        let both = |sizes: [[u16; 2]; 2]| match sizes {
            [[w, h], right] if right == sizes[0] => format!("{w} x {h} px"),
            [[w, h], [x, y]] => format!("{w} x {h} px left and {x} x {y} px right"),
        };
        let is_smaller = |side: usize| (0..2).all(|i| sizes[side][i] <= own[side][i]);
        let can_be_cut = is_smaller(0) && is_smaller(1);
        let scaled =
            || resized::changed(&meta, [0, 1].map(|side| Change::scaled(own[side], sizes[side])));
        let cut = |at: Option<[u16; 2]>| -> Result<Meta> {
            ensure!(
                can_be_cut,
                "--cut: the images of {} are larger than those of the rig, {}",
                both(sizes),
                both(own)
            );
            let change = |side: usize| -> Result<Change> {
                let centre = Change::centre(own[side], sizes[side]);
                let Some(at) = at else { return Ok(centre) };
                let inside = (0..2).all(|i| {
                    u32::from(at[i]) + u32::from(sizes[side][i]) <= u32::from(own[side][i])
                });
                ensure!(
                    inside,
                    "--cut {},{}: images of {} there do not fit into those of the rig, {}",
                    at[0],
                    at[1],
                    both(sizes),
                    both(own)
                );
                Ok(Change { offset: at.map(f64::from), ..centre })
            };
            Ok(resized::changed(&meta, [change(0)?, change(1)?]))
        };
        let cross = |side: usize, i: usize| u32::from(sizes[side][i]) * u32::from(own[side][1 - i]);
        let same_shape = (0..2).all(|side| cross(side, 0) == cross(side, 1));
        let note = |what: &str| {
            format!(
                "the rig belongs to images of {}, these have {}: taken as {what}",
                both(own),
                both(sizes)
            )
        };
        let (meta, note, if_cut) = match self.cut {
            Cut::Centre => (cut(None)?, note("cropped from the middle"), None),
            Cut::At([x, y]) => (cut(Some([x, y]))?, note(&format!("cropped at {x}, {y}")), None),
            Cut::Scaled => (scaled(), note("scaled"), None),
            Cut::Unknown if same_shape => {
                let by = f64::from(sizes[0][0]) / f64::from(own[0][0]);
                let if_cut = can_be_cut.then(|| cut(None)).transpose()?.map(Box::new);
                (
                    scaled(),
                    format!(
                        "{} (scaled by {by}); if they were cropped instead, give the place: --cut centre, or --cut X,Y",
                        note("scaled")
                    ),
                    if_cut,
                )
            }
            Cut::Unknown => bail!(
                "the rig belongs to images of {}, these have {}: the shapes differ. If they were cropped, give the place: --cut centre, or --cut X,Y; \
                 otherwise the rig belongs to another camera",
                both(own),
                both(sizes)
            ),
        };
        Ok(FoundRig { meta, guessed: false, notes: vec![note], if_cut })
    }
}

/// A rig of two side-by-side pinholes with this focal length, px.
fn guess(focal: f64, sizes: [[u16; 2]; 2], from: &str) -> FoundRig {
    let k = |size: [u16; 2]| {
        let [cx, cy] = size.map(|n| (f64::from(n) - 1.0) / 2.0);
        [[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]]
    };
    let source = format!("a guess: focal length {focal:.0} px ({from})");
    let meta = Meta::side_by_side(sizes.map(k), sizes, source);
    let note = format!(
        "THE RIG IS A GUESS: focal length {focal:.0} px ({from}) for both cameras, principal points in the middle, no \
         distortion, side by side. Row offsets, and roll and pitch between the cameras, can be used to line up rows. \
         Yaw, t, depths and the standard deviations cannot be trusted: they depend on the lenses. Calibrate the \
         cameras once, and give the file (--rig)."
    );
    FoundRig { meta, guessed: true, notes: vec![note], if_cut: None }
}

/// Focal length from the EXIF data of a file, px.
fn focal_of_exif(frame: &Frame, size: [u16; 2]) -> Option<f64> {
    focal_in(frame.path()?, size).ok().flatten()
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
    // Unit of the sensor's resolution: code 2 means inches, 3 centimetres.
    let unit_mm = if number(Tag::FocalPlaneResolutionUnit) == Some(3.0) { 10.0 } else { 25.4 };
    let both = number(Tag::FocalLength).zip(number(Tag::FocalPlaneXResolution));
    Ok(both.map(|(mm, resolution)| mm * resolution / unit_mm))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn meta() -> Meta {
        rigs::data::Dataset::find_meta(Path::new("opencv_chess_sift")).unwrap()
    }

    #[test]
    fn a_rig_of_twice_the_size_is_scaled_and_one_of_another_shape_is_refused() {
        let request = RigRequest::default();
        let found = request.fitted(meta(), [[320, 240]; 2]).unwrap();
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
        assert!((found.if_cut.unwrap().k_l[0][0] - meta().k_l[0][0]).abs() < 1e-12);
        let refused = request.fitted(meta(), [[640, 360]; 2]).unwrap_err().to_string();
        assert!(
            refused.contains("the shapes differ") && refused.contains("--cut X,Y"),
            "{refused}"
        );
        let cut = RigRequest { cut: Cut::At([0, 60]), ..request };
        let found = cut.fitted(meta(), [[640, 360]; 2]).unwrap();
        assert!((found.meta.k_l[1][2] - (meta().k_l[1][2] - 60.0)).abs() < 1e-12);
    }

    #[test]
    fn a_guess_warns_of_figures_that_cannot_be_trusted() {
        let request = RigRequest { focal_px: Some(500.0), ..RigRequest::default() };
        let frame = Frame::file(PathBuf::from("none.png"));
        let found = request.find(&RigOf::Nothing, [[640, 480]; 2], &frame).unwrap();
        assert!(found.guessed && found.notes[0].contains("cannot be trusted"), "{:?}", found.notes);
        found.meta.cameras::<f64>().unwrap();
        let nothing = RigRequest::default().find(&RigOf::Nothing, [[640, 480]; 2], &frame);
        assert!(nothing.unwrap_err().to_string().contains("--focal"));
    }

    #[test]
    fn doubts_about_a_rig_file_are_notes() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("rig.yaml");
        let camera = |tx: f64| {
            format!(
                "  T_cn_cnm1: [[1, 0, 0, {tx}], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  camera_model: pinhole\n  \
                 distortion_coeffs: [0, 0, 0, 0]\n  distortion_model: radtan\n  intrinsics: [500, 500, 240, 320]\n  \
                 resolution: [640, 480]\n"
            )
        };
        std::fs::write(&file, format!("cam0:\n{}cam1:\n{}", camera(0.0), camera(-0.1))).unwrap();
        let request = RigRequest { files: vec![file], ..RigRequest::default() };
        let frame = Frame::file(PathBuf::from("none.png"));
        let found = request.find(&RigOf::Nothing, [[640, 480]; 2], &frame).unwrap();
        assert!(found.notes[0].contains("Are width and height exchanged?"), "{:?}", found.notes);
    }

    /// A JPEG image with these EXIF fields.
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
    fn the_focal_length_comes_from_the_exif_data() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("photograph.jpg");
        let field = |tag: Tag, value: Value| exif::Field { tag, ifd_num: In::PRIMARY, value };
        let ratio = |num, denom| Value::Rational(vec![exif::Rational { num, denom }]);
        let focal = |fields: &[exif::Field]| {
            photograph(&path, fields);
            let found = RigRequest::default().find(
                &RigOf::Nothing,
                [[640, 480]; 2],
                &Frame::file(path.clone()),
            );
            found.map(|rig| (rig.guessed, rig.meta.k_l[0][0]))
        };
        // 28 mm on film, whose diagonal corresponds to the 800 px of the image's diagonal.
        let film = field(Tag::FocalLengthIn35mmFilm, Value::Short(vec![28]));
        let (guessed, px) = focal(&[film]).unwrap();
        assert!(guessed && (px - 28.0 / 43.267 * 800.0).abs() < 1e-9, "{px}");
        // A focal length of 4 mm, and 2000 pixels per centimetre.
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
