//! The calibrated rig in the files of other tools.

use anyhow::Result;

use super::Replayed;
use crate::report::Section;
use rigs::formats::{Document, Format};

/// The estimate in each format, or why the format cannot express it; empty without an estimate.
pub(super) fn files(replayed: &Replayed<'_>) -> Vec<(Format, Result<Vec<Document>>)> {
    let Some(fused) = replayed.log.fused() else { return Vec::new() };
    let meta = fused.rig(&replayed.set.meta);
    Format::ALL.iter().map(|format| (*format, format.write(&meta))).collect()
}

pub(super) fn section(replayed: &Replayed<'_>) -> Section {
    let mut section = Section::new("The rig for other tools");
    section.text(
        "The estimate as the files of OpenCV (x_2 = R x_1 + T), Kalibr (T_cn_cnm1 takes points of cam0 \
         to cam1) and ROS (camera_info, P[0][3] = -fx b), as far as each can express the lens, in rig/ \
         beside this page. Lengths are in metres.",
    );
    if replayed.log.fused().is_some_and(|fused| !fused.correction.is_none()) {
        section.text("The right camera is the corrected one, which R and t belong to.");
    }
    if replayed.set.meta.baseline_m.is_none() {
        section.text("The length of the baseline is unknown: it is written as 1.");
    }
    for (format, documents) in files(replayed) {
        let name = format.to_string();
        match documents {
            Ok(documents) => documents.into_iter().for_each(|document| {
                section.listing(format!("rig/{name}/{}", document.name), document.text);
            }),
            Err(why) => section.text(format!("Not as {name}: {why:#}.")),
        }
    }
    section
}
