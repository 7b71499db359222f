//! A file of single pairs with the truth of each, in plain numbers that any language can write.
//!
//! Little endian. The header is the number of pairs, `u32`, and the number `n` of correspondences of each pair, `u32`.
//! Each pair follows as `f64`: `n` times `x_l y_l x_r y_r`, then `R` row by row, then `t`. Rays are at unit depth,
//! after undistortion; `p_r = R p_l + t`.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::Extrinsics;

use super::dataset::Dataset;
use super::geometry::rows;
use super::matches::Match;
use super::sign::WrongSign;

/// Count of numbers in `R` and `t`.
const TRUTH: usize = 12;

/// Length of the header, bytes.
const HEADER: usize = 8;

/// One pair.
#[derive(Debug, Clone, PartialEq)]
pub struct TruePair {
    /// `x_l y_l x_r y_r` at unit depth of each correspondence, inliers and outliers.
    pub rays: Vec<[f64; 4]>,
    /// The true extrinsics.
    pub truth: Extrinsics<f64>,
}

/// All pairs of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFile {
    /// The pairs. [`PairFile::encode`] refuses pairs that differ in the number of correspondences.
    pub pairs: Vec<TruePair>,
}

impl PairFile {
    /// Number of correspondences of the first pair; 0 without pairs.
    #[must_use]
    pub fn matches(&self) -> usize {
        self.pairs.first().map_or(0, |pair| pair.rays.len())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or as [`PairFile::decode`].
    pub fn load(path: &Path) -> Result<Self> {
        let name = path.display();
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {name}"))?;
        Self::decode(&bytes).with_context(|| format!("{name} is not a file of pairs"))
    }

    /// The rays and truths of a data set.
    ///
    /// # Errors
    /// If a pixel has no ray, or the rig is not valid.
    pub fn of(set: &Dataset) -> Result<Self> {
        let cameras = set.cameras::<f64>()?;
        let truths =
            if set.rigs.is_empty() { vec![set.truth()?; set.pairs.len()] } else { set.truths()? };
        let rays = |m: &Match| {
            let pair = cameras.rays(&m.correspondence())?;
            let ([x_l, y_l], [x_r, y_r]) = (pair.left(), pair.right());
            anyhow::Ok([x_l, y_l, x_r, y_r])
        };
        let pair = |(matches, truth): (&Vec<Match>, _)| {
            anyhow::Ok(TruePair { rays: matches.iter().map(rays).collect::<Result<_>>()?, truth })
        };
        Ok(Self { pairs: set.pairs.iter().zip(truths).map(pair).collect::<Result<_>>()? })
    }

    /// Writes a new file.
    ///
    /// # Errors
    /// If it exists or cannot be written, or as [`PairFile::encode`].
    pub fn save(&self, path: &Path) -> Result<()> {
        let name = path.display();
        ensure!(!path.exists(), "{name} exists: nothing is overwritten");
        std::fs::write(path, self.encode()?).with_context(|| format!("cannot write {name}"))
    }

    /// Decodes the bytes of a file.
    ///
    /// # Errors
    /// If the length differs from the length that the header gives, there are no pairs or no correspondences, a number
    /// is not finite, or the truth of a pair is not a stereo rig or has the wrong sign of `t` ([`WrongSign`]).
    pub fn decode(bytes: &[u8]) -> Result<Self> {
        let (header, body) =
            bytes.split_at_checked(HEADER).context("it is shorter than its header of 8 bytes")?;
        let count = |i: usize| {
            let four = [header[i], header[i + 1], header[i + 2], header[i + 3]];
            usize::try_from(u32::from_le_bytes(four))
        };
        let (pairs, matches) = (count(0)?, count(4)?);
        ensure!(
            pairs > 0 && matches > 0,
            "the header gives {pairs} pairs of {matches} correspondences"
        );
        let numbers = matches.checked_mul(4).and_then(|n| n.checked_add(TRUTH));
        let size =
            numbers.and_then(|n| n.checked_mul(8)).context("the header gives too many matches")?;
        let expected = size.checked_mul(pairs).context("the header gives too many pairs")?;
        ensure!(
            body.len() == expected,
            "{pairs} pairs of {matches} correspondences are {expected} bytes after the header, \
             there are {}",
            body.len()
        );
        let read = |(i, bytes): (usize, &[u8])| {
            TruePair::decode(bytes).with_context(|| format!("pair {i}"))
        };
        Ok(Self { pairs: body.chunks_exact(size).enumerate().map(read).collect::<Result<_>>()? })
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// If pairs differ in length, or a number of pairs or correspondences does not fit a `u32`.
    pub fn encode(&self) -> Result<Vec<u8>> {
        let matches = self.matches();
        let mut bytes = Vec::new();
        bytes.extend(u32::try_from(self.pairs.len())?.to_le_bytes());
        bytes.extend(u32::try_from(matches)?.to_le_bytes());
        for (i, pair) in self.pairs.iter().enumerate() {
            let n = pair.rays.len();
            ensure!(n == matches, "pair {i} has {n} correspondences, the first has {matches}");
            let r = pair.truth.rotation().matrix().transpose();
            let t = pair.truth.translation();
            let numbers = pair.rays.iter().flatten().chain(r.iter()).chain(t.iter());
            bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
        }
        Ok(bytes)
    }
}

impl TruePair {
    fn decode(bytes: &[u8]) -> Result<Self> {
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap_or([0xff; 8]));
        let numbers: Vec<f64> = bytes.chunks_exact(8).map(number).collect();
        ensure!(numbers.iter().all(|x| x.is_finite()), "a number is not finite");
        let (rays, truth) = numbers.split_at(numbers.len() - TRUTH);
        let (r, t) = truth.split_at(9);
        let rays = rays.chunks_exact(4).map(|c| [c[0], c[1], c[2], c[3]]).collect();
        let r = Matrix3::from_row_slice(r);
        WrongSign::check(&rows(&r), [t[0], t[1], t[2]])?;
        let truth = Extrinsics::try_new(&r, &Vector3::from_row_slice(t)).context("its R and t")?;
        Ok(Self { rays, truth })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synth::rig;

    fn file() -> PairFile {
        let truth = rig([1.0, -2.0, 0.5], [1.0, 2.0]).unwrap();
        let pair = |x: f64| TruePair { rays: vec![[x, 0.1, 0.2, 0.3], [-0.4, x, 0.5, -x]], truth };
        PairFile { pairs: vec![pair(0.25), pair(-0.75), pair(0.125)] }
    }

    #[test]
    fn a_written_file_is_read_back() {
        let file = file();
        let read = PairFile::decode(&file.encode().unwrap()).unwrap();
        assert_eq!(read.matches(), 2);
        for (a, b) in read.pairs.iter().zip(&file.pairs) {
            assert_eq!(a.rays, b.rays);
            assert!((a.truth.rotation().matrix() - b.truth.rotation().matrix()).amax() < 1e-15);
        }
    }

    #[test]
    fn a_file_written_by_hand_is_read_as_the_format_says() {
        let numbers = [0.1, 0.2, 0.3, 0.4, 0., -1., 0., 1., 0., 0., 0., 0., 1., -1., 0., 0.];
        let mut bytes = vec![1, 0, 0, 0, 1, 0, 0, 0];
        bytes.extend(numbers.iter().flat_map(|x: &f64| x.to_le_bytes()));
        let [pair] = PairFile::decode(&bytes).unwrap().pairs.try_into().unwrap();
        assert_eq!(pair.rays, [[0.1, 0.2, 0.3, 0.4]]);
        // A quarter turn from x to y.
        assert_eq!(pair.truth.rotation() * Vector3::x(), Vector3::y());
        assert_eq!(pair.truth.translation().into_inner(), -Vector3::x());
    }

    #[test]
    fn a_file_without_pairs_is_refused_with_the_reason() {
        let said = |bytes: &[u8]| format!("{:#}", PairFile::decode(bytes).unwrap_err());
        let whole = file().encode().unwrap();
        assert!(said(&whole[..5]).contains("shorter"));
        assert!(said(&whole[..whole.len() - 1]).contains("3 pairs of 2"));
        assert!(said(&[0; 8]).contains("0 pairs"));
        assert!(said(&[0xff; 8]).contains("too many"));
        let mut bad = whole.clone();
        bad[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
        assert!(said(&bad).contains("pair 0: a number is not finite"));
        let mut bad = whole;
        let r = HEADER + 8 * 8;
        bad[r..r + 8].copy_from_slice(&7.0_f64.to_le_bytes());
        assert!(said(&bad).contains("R and t"));
    }
}
