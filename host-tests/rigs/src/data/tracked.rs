//! Matches tracked from one pair to a later one: `quads/NNNN.csv` beside the pairs of a data set. `NNNN` is the number
//! of the earlier pair, from 0.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use stereo_selfcal::batch::RayPair;
use stereo_selfcal::{Cameras, Scalar};

use super::{Match, csv_file};

/// A match in a pair and in a later pair.
pub type Track = [Match; 2];

#[derive(Serialize, Deserialize)]
struct Row {
    ul1: f64,
    vl1: f64,
    ur1: f64,
    vr1: f64,
    ul2: f64,
    vl2: f64,
    ur2: f64,
    vr2: f64,
}

/// Reads the tracks that start in each of the first `pairs` pairs. A pair without a file has no tracks.
pub fn read(dir: &Path, pairs: usize) -> Result<Vec<Vec<Track>>> {
    let folder = dir.join("quads");
    let of_pair = |i| Ok(csv_file::read_pair(&folder, i)?.into_iter().map(of_row).collect());
    (0..pairs).map(of_pair).collect()
}

/// Writes the tracks that start in each pair. A pair without tracks gets no file.
pub fn write(dir: &Path, tracks: &[Vec<Track>]) -> Result<()> {
    let folder = dir.join("quads");
    fs::create_dir_all(&folder).with_context(|| format!("cannot make {}", folder.display()))?;
    for (i, all) in tracks.iter().enumerate().filter(|(_, all)| !all.is_empty()) {
        let row = |[one, two]: &Track| {
            let Match { ul: ul1, vl: vl1, ur: ur1, vr: vr1, .. } = *one;
            let Match { ul: ul2, vl: vl2, ur: ur2, vr: vr2, .. } = *two;
            Row { ul1, vl1, ur1, vr1, ul2, vl2, ur2, vr2 }
        };
        csv_file::write(&csv_file::of_pair(&folder, i), all.iter().map(row))?;
    }
    Ok(())
}

fn of_row(Row { ul1, vl1, ur1, vr1, ul2, vl2, ur2, vr2 }: Row) -> Track {
    let seen = |ul, vl, ur, vr| Match { ul, vl, ur, vr, score: 1.0, step: 0.0 };
    [seen(ul1, vl1, ur1, vr1), seen(ul2, vl2, ur2, vr2)]
}

/// Rays of the tracks. A track with a pixel that has no ray is left out.
pub fn rays_of<T: Scalar>(cameras: &Cameras<T>, tracks: &[Track]) -> Vec<[RayPair<T>; 2]> {
    let rays = |[one, two]: &Track| {
        let [one, two] = [one, two].map(|m| cameras.rays(&m.correspondence()));
        Some([one.ok()?, two.ok()?])
    };
    tracks.iter().filter_map(rays).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tracks_are_read_by_pair_and_a_wrong_file_is_named() {
        let dir = tempfile::tempdir().unwrap();
        assert!(read(dir.path(), 1).unwrap()[0].is_empty());
        let quads = dir.path().join("quads");
        fs::create_dir(&quads).unwrap();
        let heading = "ul1,vl1,ur1,vr1,ul2,vl2,ur2,vr2\n";
        fs::write(quads.join("0001.csv"), format!("{heading}1,2,3,4,5,6,7,8\n")).unwrap();
        let tracks = read(dir.path(), 2).unwrap();
        assert_eq!((tracks[0].len(), tracks[1][0][1].ur), (0, 7.0));
        write(dir.path(), &tracks).unwrap();
        assert_eq!(read(dir.path(), 2).unwrap(), tracks);
        fs::write(quads.join("0000.csv"), format!("{heading}1,2,3\n")).unwrap();
        assert!(format!("{:#}", read(dir.path(), 2).unwrap_err()).contains("0000.csv"));
    }
}
