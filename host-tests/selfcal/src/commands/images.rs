//! `selfcal images`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::over_images::page;
use anyhow::{Result, ensure};
use clap::Args;
use images::verdict::Report;
use rigs::formats::{Document, Format};

use crate::over_images::{Ran, SourceArgs};

/// From images to the calibrated rig: match every pair, run the calibrator over the matches, and report how far the rig
/// is off.
///
/// A folder is EuRoC (mav0/cam0/data), KITTI (image_0, image_1, or image_2, image_3), Middlebury (im0.png, im1.png),
/// left/ and right/, or left*.png and right*.png. Images are PNG, JPEG, PGM, TIFF, BMP or WebP of 8 or 16 bits. In a
/// bag they are raw (mono, colour, Bayer, YUV 4:2:2, NV12) or compressed, and camera_info gives the rig (for rectified
/// topics by P alone). Images are paired by time stamp (names in nanoseconds, headers of messages), by the number in
/// their names, or in order.
///
/// The calibrator starts from the rig's extrinsics; e_t and e_theta are the distance of the estimate from them. Pairs
/// that cannot be read or matched are skipped, named and counted. Ctrl-C ends the run and keeps the pairs done.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal images chess --knock 1 --report page
  selfcal images left/ right/ --rig camchain.yaml --report page
  selfcal images 'cam/left*.png' 'cam/right*.png' --rig intrinsics.yml extrinsics.yml --rig-out calibrated
  selfcal images MH_01_easy --every 10 --frames flight.scmf --out matches
  selfcal images flight.mcap --left-topic /left/image_raw --right-topic /right/image_raw
  selfcal images phone_left/ phone_right/ --focal 1200")]
pub(crate) struct ImagesArgs {
    #[command(flatten)]
    source: SourceArgs,

    /// Write a page into this folder: images before and after, rows, disparities, health, all numbers as CSV, and
    /// the calibrated rig for OpenCV, Kalibr and ROS in rig/. Files of an earlier page are replaced.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,

    /// Write the calibrated rig for OpenCV, Kalibr and ROS into subfolders of this folder; none of them may exist.
    #[arg(long, value_name = "DIR")]
    rig_out: Option<PathBuf>,

    /// Write rig and matches as a data set for `selfcal replay`, pair by pair; the folder must be empty or not exist.
    /// Not with --knock, because the rig of a data set is its reference.
    #[arg(long, value_name = "DIR", conflicts_with = "knock")]
    out: Option<PathBuf>,

    /// Write the matches as the frames that an FPGA sends, in 1/256 px; must not exist. For `selfcal replay FILE
    /// --rig`, and for the controller under emulation.
    #[arg(long, value_name = "FILE")]
    frames: Option<PathBuf>,

    /// Exit with the status of `selfcal check`: 0 good, 10 improvable, 20 recalibrate, 30 unknown; otherwise 0.
    #[arg(long)]
    status: bool,

    /// Print only one JSON object on standard output. Angles in rad.
    #[arg(long)]
    pub(super) json: bool,
}

/// Runs `selfcal images`.
pub(crate) fn images(args: &ImagesArgs) -> Result<ExitCode> {
    ensure!(
        args.source.rigs().len() <= 1,
        "--rig is given {} times: one rig is calibrated; `selfcal check` compares several",
        args.source.rigs().len()
    );
    if let Some(dir) = &args.rig_out {
        for format in Format::ALL {
            let folder = dir.join(format.to_string());
            ensure!(!folder.exists(), "{} exists: nothing is overwritten", folder.display());
        }
    }
    if let Some(dir) = &args.out {
        let full = dir.exists() && std::fs::read_dir(dir)?.next().is_some();
        ensure!(!full, "{} is not empty: nothing is overwritten", dir.display());
    }
    let ran = args.source.run(args.frames.as_deref(), args.out.as_deref(), args.json)?;
    let report = Report::of(&ran.session, ran.rig.guessed)?;
    let written = args.write(&ran, &report)?;
    let status = if args.status { report.verdict.status() } else { 0 };
    let mut out = io::stdout();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
        return Ok(status.into());
    }
    if ran.session.stopped {
        writeln!(out, "stopped after {} pairs", ran.session.pairs)?;
    }
    writeln!(out, "{}\n\n{report}", report.summary)?;
    for words in report.coverage.iter().flat_map(|coverage| &coverage.words) {
        writeln!(out, "{words}")?;
    }
    for (what, path) in written {
        writeln!(out, "{what:<18} {}", path.display())?;
    }
    Ok(status.into())
}

impl ImagesArgs {
    fn write(&self, ran: &Ran, report: &Report) -> Result<Vec<(&'static str, PathBuf)>> {
        let mut written = Vec::new();
        if let Some(path) = &self.frames {
            written.push(("frames", path.clone()));
            if ran.session.left_out > 0 {
                eprintln!("{} matches left out: they do not fit a frame", ran.session.left_out);
            }
        }
        if let Some(dir) = &self.out {
            written.push(("data set", dir.clone()));
        }
        if let Some(dir) = &self.rig_out {
            written.extend(rigs(ran, dir)?);
        }
        if let Some(dir) = &self.report {
            written.push(("page", page::write(&ran.session, report, dir)?));
        }
        Ok(written)
    }
}

fn rigs(ran: &Ran, dir: &Path) -> Result<Vec<(&'static str, PathBuf)>> {
    let meta = ran.session.log.try_fused()?.rig(&ran.session.set.meta);
    let mut written = Vec::new();
    for format in Format::ALL {
        // Kalibr cannot store a `k3`. If a format fails, the others are still written.
        match format.write(&meta) {
            Ok(documents) => {
                let paths = Document::save_all(&documents, &dir.join(format.to_string()))?;
                written.extend(paths.into_iter().map(|path| ("rig", path)));
            }
            Err(why) => eprintln!("not as {format}: {why:#}"),
        }
    }
    Ok(written)
}
