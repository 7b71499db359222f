//! `rigs.csv`: the rig of each pair, for a data set whose rig moves. Row-major `R`, then unit `t`.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;

use super::geometry::{Rows, matrix, rows};
use super::sign::WrongSign;

/// Name of the file in the folder of a data set.
const FILE: &str = "rigs.csv";

const COLUMNS: [&str; 12] =
    ["r11", "r12", "r13", "r21", "r22", "r23", "r31", "r32", "r33", "t1", "t2", "t3"];

/// The rig of one pair in the form of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rig {
    /// Rotation, left to right camera frame.
    pub r: Rows,
    /// Unit baseline direction, right camera frame.
    pub t: [f64; 3],
}

impl Rig {
    /// Conversion to the core's type.
    ///
    /// # Errors
    /// If `R` and `t` do not describe a stereo rig.
    pub fn extrinsics(&self) -> Result<Extrinsics<f64>> {
        Ok(Extrinsics::try_new(&matrix(&self.r), &Vector3::from(self.t))?)
    }
}

impl From<&Extrinsics<f64>> for Rig {
    fn from(extrinsics: &Extrinsics<f64>) -> Self {
        Self {
            r: rows(extrinsics.rotation().matrix()),
            t: extrinsics.translation().into_inner().into(),
        }
    }
}

/// The rigs of a folder's `rigs.csv`; empty without this file.
///
/// * `pairs`: the number of rigs that the file must have.
pub(super) fn read(dir: &Path, pairs: usize) -> Result<Vec<Rig>> {
    let path = dir.join(FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    let read = || -> Result<Vec<Rig>> {
        let mut file = csv::Reader::from_path(&path)?;
        ensure!(file.headers()? == COLUMNS[..], "the columns must be {}", COLUMNS.join(","));
        let rig = |(pair, row): (usize, csv::Result<[f64; 12]>)| {
            let [r11, r12, r13, r21, r22, r23, r31, r32, r33, t1, t2, t3] = row?;
            let t = [t1, t2, t3];
            let r = [[r11, r12, r13], [r21, r22, r23], [r31, r32, r33]];
            WrongSign::check(&r, t).with_context(|| format!("rig of pair {pair}"))?;
            Ok(Rig { r, t })
        };
        let rigs = file.deserialize().enumerate().map(rig).collect::<Result<Vec<Rig>>>()?;
        ensure!(rigs.len() == pairs, "{} rigs for {pairs} pairs", rigs.len());
        Ok(rigs)
    };
    read().with_context(|| format!("cannot read {}", path.display()))
}

/// Writes the file, unless there are no rigs.
pub(super) fn write(dir: &Path, rigs: &[Rig]) -> Result<()> {
    if rigs.is_empty() {
        return Ok(());
    }
    let path = dir.join(FILE);
    let write = || -> Result<()> {
        let mut file = csv::Writer::from_writer(fs::File::create_new(&path)?);
        file.write_record(COLUMNS)?;
        for Rig { r, t } in rigs {
            file.serialize((r, t))?;
        }
        Ok(file.flush()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::dataset::Dataset;
    use nalgebra::{Rotation3, Vector3};
    use stereo_selfcal::Extrinsics;

    fn moving() -> Dataset {
        let mut set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
        let turned = |turn: f64| {
            let r = Rotation3::from_euler_angles(turn, 0.005, -turn);
            let t = Vector3::new(-1.0, turn, 0.03);
            Rig::from(&Extrinsics::try_new(r.matrix(), &t).unwrap())
        };
        set.rigs = (0..13).map(|i| turned(f64::from(i) / 400.0)).collect();
        set
    }

    #[test]
    fn the_rig_of_each_pair_loads_back_equal_to_the_bit() {
        let dir = tempfile::tempdir().unwrap();
        let copy = dir.path().join("opencv_chess_corners");
        moving().save(&copy).unwrap();
        assert_eq!(Dataset::load(&copy).unwrap(), moving());
    }

    #[test]
    fn a_missing_rig_and_a_wrong_column_are_named() {
        let dir = tempfile::tempdir().unwrap();
        let error = || format!("{:#}", read(dir.path(), 13).unwrap_err());
        write(dir.path(), &moving().rigs[1..]).unwrap();
        assert!(error().contains("rigs.csv") && error().contains("12 rigs for 13 pairs"));
        let text = fs::read_to_string(dir.path().join(FILE)).unwrap();
        fs::write(dir.path().join(FILE), text.replacen("r12", "r21", 1)).unwrap();
        assert!(error().contains("columns"), "{}", error());
    }
}
