//! Points of known distance in the pairs of a recording.

use std::collections::BTreeMap;
use std::path::Path;

use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use stereo_selfcal::Scalar;
use stereo_selfcal::depth::{Range, RangeReading};

use super::csv_file;

/// Readings of each pair, by the number of the pair from 0.
pub type Ranges = BTreeMap<usize, Vec<RangeReading<f64>>>;

#[derive(Serialize, Deserialize)]
struct Row {
    pair: usize,
    u: f64,
    v: f64,
    range_m: f64,
    sd_m: f64,
    along: Along,
    /// Column of the same point in the right image, px.
    #[serde(default)]
    ur: Option<f64>,
    #[serde(default)]
    vr: Option<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Along {
    Axis,
    Ray,
}

/// Reads a CSV file with the columns `pair,u,v,range_m,sd_m,along` and optionally `ur,vr`.
///
/// `pair` is the number of the pair from 0. `u,v` are px of the left image, and `ur,vr` the same point in the right
/// image. `range_m` is the distance, and `sd_m` its standard deviation, m. `along` says whether the distance is along
/// the optical axis (`axis`) or along the ray of the point (`ray`).
pub fn read(path: &Path) -> Result<Ranges> {
    let mut ranges = Ranges::new();
    for Row { pair, u, v, range_m, sd_m, along, ur, vr } in csv_file::read(path)? {
        let range = match along {
            Along::Axis => Range::AlongAxis(range_m),
            Along::Ray => Range::AlongRay(range_m),
        };
        let right = ur.zip(vr).map(<[f64; 2]>::from);
        let half = ur.is_some() != vr.is_some();
        ensure!(!half, "{}: pair {pair}: ur without vr, or vr without ur", path.display());
        ranges.entry(pair).or_default().push(RangeReading { pixel: [u, v], right, range, sd_m });
    }
    Ok(ranges)
}

/// Writes a file that [`read`] reads back.
pub fn write(path: &Path, ranges: &Ranges) -> Result<()> {
    let row = |pair: usize, reading: &RangeReading<f64>| {
        let RangeReading { pixel: [u, v], right, range, sd_m } = *reading;
        let (along, range_m) = match range {
            Range::AlongAxis(range_m) => (Along::Axis, range_m),
            Range::AlongRay(range_m) => (Along::Ray, range_m),
        };
        let [ur, vr] = right.map_or([None; 2], |right| right.map(Some));
        Row { pair, u, v, range_m, sd_m, along, ur, vr }
    };
    let all = ranges.iter().flat_map(|(pair, all)| all.iter().map(move |one| row(*pair, one)));
    csv_file::write(path, all)
}

/// A reading in the number type of a calibrator.
pub fn in_scalar<T: Scalar>(reading: &RangeReading<f64>) -> RangeReading<T> {
    let RangeReading { pixel, right, range, sd_m } = *reading;
    let range = match range {
        Range::AlongAxis(depth) => Range::AlongAxis(T::lit(depth)),
        Range::AlongRay(range) => Range::AlongRay(T::lit(range)),
    };
    let right = right.map(|pixel| pixel.map(T::lit));
    RangeReading { pixel: pixel.map(T::lit), right, range, sd_m: T::lit(sd_m) }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn readings_are_read_by_pair() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("ranges.csv");
        let heading = "pair,u,v,range_m,sd_m,along\n";
        fs::write(&path, format!("{heading}4,10,20,8.5,0.1,ray\n4,11,20,9,0.2,axis\n")).unwrap();
        let range = Range::AlongAxis(9.0);
        let reading = RangeReading { pixel: [11.0, 20.0], right: None, range, sd_m: 0.2 };
        let ranges = read(&path).unwrap();
        assert_eq!(ranges[&4][1], reading);
        write(&path, &ranges).unwrap();
        assert_eq!(read(&path).unwrap(), ranges);
        fs::write(&path, format!("{heading}4,10,20,8.5,0.1,sideways\n")).unwrap();
        assert!(format!("{:#}", read(&path).unwrap_err()).contains("ranges.csv"));
        let with_own_match = "pair,u,v,range_m,sd_m,along,ur,vr\n";
        fs::write(&path, format!("{with_own_match}4,11,20,9,0.2,axis,5,21\n")).unwrap();
        let own = RangeReading { right: Some([5.0, 21.0]), ..reading };
        assert_eq!(read(&path).unwrap()[&4], [own]);
        fs::write(&path, format!("{with_own_match}4,11,20,9,0.2,axis,5,\n")).unwrap();
        assert!(format!("{:#}", read(&path).unwrap_err()).contains("ur without vr"));
    }
}
