//! The paper's figure of disparities before and after, as figures of a page.

use anyhow::Result;

use images::pictures::{Rectification, disparity_picture, missing_picture, pair_picture};
use page::report::{Csv, Figure, Picture};
use sim::run::SCREEN_PX;

use super::comparison::{Attempt, Scores, WRONG_PX, comparison};
use super::scene::PicturedScene;

/// Angle of the turned left view, degrees.
const DEGREES: f64 = 5.0;

/// Rectified pairs and their disparities: with the start extrinsics, and with the estimates of bundle adjustment and of
/// both presets.
///
/// * `name`: one of [`PicturedScene::SHIPPED`].
/// * `command`: command that makes the page.
///
/// # Errors
/// If there is no such scene, its files are damaged, or a picture cannot be encoded; and as [`comparison`].
pub fn disparity_figures(name: &str, command: &str) -> Result<[Figure; 2]> {
    let scene = PicturedScene::shipped(name, DEGREES)?;
    let all = comparison(&scene)?;
    let mut numbers = Csv::new(
        &format!("disparity_{name}"),
        &[
            "extrinsics",
            "row offset, median, px",
            "disparities found, share",
            "found and right, share",
            "failed",
        ],
    );
    for Attempt { name, outcome } in &all {
        let scores = outcome.as_ref().map(|(_, scores)| scores);
        let cells = match scores {
            Ok(Scores { row_offset_px, valid, right }) => {
                let right = right.map(|right| right.to_string()).unwrap_or_default();
                [row_offset_px.to_string(), valid.to_string(), right, String::new()]
            }
            Err(why) => [String::new(), String::new(), String::new(), why.clone()],
        };
        numbers.push([(*name).to_owned()].into_iter().chain(cells));
    }
    let mut pairs = numbers.clone();
    pairs.name = format!("rectified_{name}");
    let [width, height] = scene.left.size();
    let panels = |size: [u16; 2],
                  picture: fn(&Rectification) -> Result<Picture>,
                  label: fn(&Scores) -> String| {
        let panel = |Attempt { name, outcome }: &Attempt| match outcome {
            Ok((one, scores)) => Ok((picture(one)?, format!("{name}: {}", label(scores)))),
            Err(why) => {
                Ok((missing_picture(size, &format!("{name}: nothing to show")), why.clone()))
            }
        };
        all.iter().map(panel).collect::<Result<Vec<_>>>()
    };
    let disparities = Figure {
        panels: panels([width, height], disparity_picture, found)?,
        legend: Vec::new(),
        caption: disparity_caption(&scene, &all),
        command: command.to_owned(),
        numbers,
    };
    let rectified = Figure {
        panels: panels([2 * width, height], pair_picture, aligned)?,
        legend: Vec::new(),
        caption: format!(
            "Left and right image of {name}, rectified, side by side. Blue lines are level; an orange \
             line leads level from a match's end in the left image, and the match's end in the right \
             image should lie on it. All panels show the same matches: those within {SCREEN_PX} px of \
             their row by the robust preset.{}",
            failures(&all)
        ),
        command: command.to_owned(),
        numbers: pairs,
    };
    Ok([rectified, disparities])
}

fn found(scores: &Scores) -> String {
    let valid = 100.0 * scores.valid;
    let right = scores.right.map(|right| {
        format!(", {:.1} % found and within {WRONG_PX} px of the published depth", 100.0 * right)
    });
    format!("{valid:.1} % found{}", right.unwrap_or_default())
}

fn aligned(scores: &Scores) -> String {
    format!("median row offset {:.2} px", scores.row_offset_px)
}

/// Methods that could not rectify the pair, and why.
fn failures(all: &[Attempt]) -> String {
    let failed = all.iter().filter_map(|a| Some((a.name, a.outcome.as_ref().err()?)));
    let sentence = |(name, why)| format!(" {name} has nothing to show: {why}.");
    failed.map(sentence).collect::<Vec<_>>().concat()
}

fn disparity_caption(scene: &PicturedScene, all: &[Attempt]) -> String {
    let range = all.iter().find_map(|a| Some(a.outcome.as_ref().ok()?.0.range)).unwrap_or(0);
    let truth = if scene.has_depth() {
        format!(
            " Right: within {WRONG_PX} px of the published depth under the same rectification, \
             of all pixels of known depth."
        )
    } else {
        String::new()
    };
    format!(
        "Dense disparities of {}, pair {}, from yellow (near, {range} px) to dark blue (far, 0 px); grey if \
         left and right image do not agree within 1 px. The left camera is turned by {DEGREES} degrees, which \
         R = I does not include; the estimates are from all {} pairs of the recording. Semi-global matching on \
         7 x 7 census transforms, without filling holes, the same for all.{truth}{}",
        scene.set.name,
        scene.pair,
        scene.set.pairs.len(),
        failures(all)
    )
}
