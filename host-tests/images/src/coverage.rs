//! Coverage of both images by the matches of a run, near and far, and advice in words on where to point the cameras.

use rigs::data::{Dataset, Match};
use serde::Serialize;
use sim::run::{Estimate, offsets};
use stereo_selfcal::Calibration;
use stereo_selfcal::geometry::LensCorrection;

/// Names of the rows and columns of cells of an image.
const ROWS: [&str; 3] = ["upper", "middle", "lower"];
const COLUMNS: [&str; 3] = ["left", "middle", "right"];

/// Limits of near and far, baselines.
const DEPTHS: [f64; 2] = [15.0, 40.0];

/// Largest row offset of a match that counts, px.
const IN_ROW_PX: f64 = 2.0;

/// Least number of matches that covers a cell or a depth.
const ENOUGH: usize = 5;

/// Number of matches in a cell of an image, by depth.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Cell {
    /// Nearer than 15 baselines.
    pub near: usize,
    /// Between 15 and 40 baselines.
    pub between: usize,
    /// Beyond 40 baselines.
    pub far: usize,
}

impl Cell {
    fn all(self) -> usize {
        self.near + self.between + self.far
    }
}

/// Matches of a run, by place and depth.
#[derive(Debug, Clone, Serialize)]
pub struct Coverage {
    /// Cells of the left and the right image: three rows of three cells.
    pub cells: [[[Cell; 3]; 3]; 2],
    /// Missing coverage, and advice on where to point the cameras.
    pub words: Vec<String>,
}

impl Coverage {
    /// Counts the matches in row under an estimate; `None` if the rig is not valid.
    pub fn of(set: &Dataset, estimate: &Estimate) -> Option<Self> {
        let calibration = set.meta.calibration(&estimate.extrinsics, &LensCorrection::NONE).ok()?;
        let sizes = set.meta.sizes().map(|size| size.map(f64::from));
        let mut cells = [[[Cell::default(); 3]; 3]; 2];
        for m in set.pairs.iter().flatten() {
            let Some(depth) = depth(&calibration, m) else { continue };
            for (side, place) in [[m.ul, m.vl], [m.ur, m.vr]].into_iter().enumerate() {
                let cell = |i: usize| (((place[i] + 0.5) / sizes[side][i] * 3.0) as usize).min(2);
                let cell = &mut cells[side][cell(1)][cell(0)];
                let [near, far] = DEPTHS;
                *(if depth < near {
                    &mut cell.near
                } else if depth > far {
                    &mut cell.far
                } else {
                    &mut cell.between
                }) += 1;
            }
        }
        Some(Self { cells, words: words(&cells) })
    }
}

/// Depth of a match, baselines; infinite without a positive disparity. `None` if the match has no ray or is not in row.
fn depth(calibration: &Calibration<f64>, m: &Match) -> Option<f64> {
    let [disparity, row, _] = offsets(calibration, m)?;
    let in_row = row.abs() * calibration.cameras.mean_focal() <= IN_ROW_PX;
    in_row.then_some(if disparity > 0.0 { 1.0 / disparity } else { f64::INFINITY })
}

/// Missing coverage and advice, in words.
fn words(cells: &[[[Cell; 3]; 3]; 2]) -> Vec<String> {
    let mut words = Vec::new();
    let name = |row: usize, column: usize| match (row, column) {
        (1, 1) => "middle".to_owned(),
        (1, _) => COLUMNS[column].to_owned(),
        (_, 1) => ROWS[row].to_owned(),
        _ => format!("{} {}", ROWS[row], COLUMNS[column]),
    };
    for (side, cells) in ["left", "right"].iter().zip(cells) {
        let all = (0..3).flat_map(|row| (0..3).map(move |column| (row, column)));
        let empty: Vec<(usize, usize)> =
            all.filter(|(row, column)| cells[*row][*column].all() < ENOUGH).collect();
        if empty.is_empty() {
            continue;
        }
        let places: Vec<String> = empty.iter().map(|(row, column)| name(*row, *column)).collect();
        let corners = empty.iter().filter(|(row, column)| *row != 1 && *column != 1).count();
        let why = if corners > 0 {
            "; matches in the corners tell yaw from pitch and from the lens: point the corners at texture"
        } else {
            ": point it at texture"
        };
        words.push(format!("{side} image: hardly any matches at the {}{why}", places.join(", ")));
    }
    let sum = |of: fn(&Cell) -> usize| cells[0].as_flattened().iter().map(of).sum::<usize>();
    let [near, far] = DEPTHS;
    if sum(|cell| cell.near) < ENOUGH {
        words.push(format!(
            "hardly anything nearer than {near} baselines: point the cameras at something near, for t and for yaw"
        ));
    }
    if sum(|cell| cell.far) < ENOUGH {
        words.push(format!(
            "hardly anything beyond {far} baselines: point the cameras at something far to tell R from t"
        ));
    }
    let halves = [0, 2].map(|row| cells[0][row].iter().map(|cell| cell.near).sum::<usize>());
    if sum(|cell| cell.near) >= ENOUGH && halves.iter().any(|near| *near < ENOUGH) {
        let row = if halves[0] < ENOUGH { ROWS[0] } else { ROWS[2] };
        words.push(format!("nothing near in the {row} third: near points above and below the middle tell t from pitch"));
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use sim::run::{Start, replay};
    use sim::synth::{Scenario, ScenarioKind};
    use stereo_selfcal::Config;

    fn coverage(kind: ScenarioKind, keep: impl Fn(&Match) -> bool) -> Coverage {
        let mut set = Scenario::new(kind, 6).dataset(3).unwrap();
        set.pairs.iter_mut().for_each(|pair| pair.retain(&keep));
        let log = replay::<f32>(&set, Config::robust(), Start::Guess, |_| ()).unwrap();
        Coverage::of(&set, log.fused().unwrap()).unwrap()
    }

    #[test]
    fn full_coverage_gives_no_advice_and_missing_coverage_is_named() {
        let whole = coverage(ScenarioKind::Near, |_| true);
        assert_eq!(whole.words, [""; 0], "{whole:?}");
        let total: usize = whole.cells[0].as_flattened().iter().map(|cell| cell.all()).sum();
        assert!(total > 1000, "{total}");
        let cut = coverage(ScenarioKind::Near, |m| m.vl > 400.0 || m.ul > 640.0);
        let text = cut.words.join("\n");
        assert!(
            text.contains("left image: hardly any matches at the upper left")
                && text.contains("yaw"),
            "{text}"
        );
        let far = coverage(ScenarioKind::Far, |_| true);
        assert!(far.words.iter().any(|words| words.contains("something near")), "{:?}", far.words);
    }
}
