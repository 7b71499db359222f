//! Figures in the form of the paper's figure 4: the effect of a calibration on depth, and the estimates on their
//! spheres.

use anyhow::{Context, Result};

use super::labels::label;
use crate::findings::Findings;
use crate::pictures::{PicturedScene, disparity_figures};
use crate::recorded_sets::SetView;
use crate::rivals::by_name;
use page::report::{Figure, Section};
use page::run::{Estimates, sphere_figure};

/// Data set and view of the spheres, which has enough pairs and outliers.
const SPHERES: [&str; 2] = ["opencv_chess_sift", "top"];

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let command = findings.request.command.as_str();
    let mut section = Section::new("Effect on depth");
    section.text(
        "The left camera looks 5 degrees too far up. Its pair is rectified by the start, by bundle adjustment \
         (the best rival with one setting for all recordings), and by both presets. A plain semi-global \
         matcher finds the disparities: where rows do not align, it finds no disparities or wrong ones.",
    );
    for name in PicturedScene::SHIPPED {
        match disparity_figures(name, command) {
            Ok(figures) => figures.into_iter().for_each(|figure| section.figure(figure)),
            Err(error) => section.alarm(format!("No pictures of {name}: {error:#}")),
        }
    }
    let [set, view] = SPHERES;
    section.text(format!(
        "The estimates of single pairs on the unit sphere, with the fused estimate and the reference: {set}, \
         {view}. One figure for each method, at the same scale.",
    ));
    match spheres(findings, command) {
        Ok(figures) => figures.into_iter().for_each(|figure| section.figure(figure)),
        Err(error) => section.alarm(format!("No spheres: {error:#}")),
    }
    section
}

/// A figure for each preset.
fn spheres(findings: &Findings<'_>, command: &str) -> Result<[Figure; 2]> {
    let [ours, published] = [estimates(findings, "robust")?, estimates(findings, "paper")?];
    let reach = ours.reach().or(published.reach());
    Ok([("robust", ours), ("paper", published)].map(|(method, estimates)| {
        let mut figure = sphere_figure(&format!("sphere_{method}"), &estimates, reach, command);
        figure.caption = format!("{}: {}", label(method), figure.caption);
        figure
    }))
}

fn estimates(findings: &Findings<'_>, method: &str) -> Result<Estimates> {
    let by = by_name(method)?;
    let [set, view] = SPHERES;
    let set = findings.sets.iter().find(|other| other.name == set);
    let seen = set.and_then(|set| set.views.iter().find(|seen| seen.view == view));
    let SetView { pairs, setting, truth, .. } = seen.context("the data set is not there")?;
    let single = |k: usize| by.fused(&pairs[k..=k], setting);
    Ok(Estimates {
        pairs: (0..pairs.len()).filter_map(single).collect(),
        fused: by.fused(pairs, setting),
        reference: *truth,
    })
}
