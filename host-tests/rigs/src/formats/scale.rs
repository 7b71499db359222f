//! A baseline as a vector in metres, and as a direction with a length.
//!
//! Rounding changes most pairs of a unit vector and a length on the way to their product and back. So `split` looks for
//! the nearest pair whose product is the vector to the bit: a vector from a file is written back unchanged.

use anyhow::{Result, ensure};
use nalgebra::Vector3;

/// A length this close to 1 was written for a baseline of unknown length.
const NEAR_ONE: f64 = 1e-12;

/// Largest variation of the length, in ulps either way. A few are enough, unless the mantissa of a number nearly equals
/// that of the length: then rounding hardly varies.
const ULPS: usize = 4096;

/// `T = b t`; length 1 for an unknown one.
pub(super) fn scaled(t: [f64; 3], baseline_m: Option<f64>) -> [f64; 3] {
    baseline_m.map_or(t, |b| t.map(|x| x * b))
}

/// The length, unless it is 1, which stands for an unknown one.
pub(super) fn known(length: f64) -> Option<f64> {
    ((length - 1.0).abs() >= NEAR_ONE).then_some(length)
}

/// Unit `t` and length of `T`; `None` for a length of 1.
pub(super) fn split(scaled: [f64; 3]) -> Result<([f64; 3], Option<f64>)> {
    let length = Vector3::from(scaled).norm();
    ensure!(
        length.is_normal(),
        "the translation {scaled:?} has no direction: expected three finite numbers that are not all 0"
    );
    if known(length).is_none() {
        return Ok((scaled, None));
    }
    let longer = std::iter::successors(Some(length), |b| Some(b.next_up()));
    let shorter = std::iter::successors(Some(length), |b| Some(b.next_down()));
    // Lengths around the norm, the nearest first.
    let mut near = longer.zip(shorter).take(ULPS).flat_map(<[f64; 2]>::from);
    let exact = near.find_map(|b| Some((direction(scaled, b)?, Some(b))));
    Ok(exact.unwrap_or((scaled.map(|x| x / length), Some(length))))
}

/// `t` with `b t = T` to the bit, if there is one.
fn direction(scaled: [f64; 3], b: f64) -> Option<[f64; 3]> {
    let one = |x: f64| {
        let t = x / b;
        [t, t.next_up(), t.next_down()].into_iter().find(|t| (t * b).to_bits() == x.to_bits())
    };
    let [x, y, z] = scaled.map(one);
    Some([x?, y?, z?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_vector_of_any_length_is_the_product_of_its_parts_to_the_bit() {
        let mut random = ChaCha8Rng::seed_from_u64(1);
        for _ in 0..20_000 {
            let size = 10.0_f64.powf(random.random_range(-3.0..3.0));
            let [y, z] = std::array::from_fn(|_| random.random_range(-0.3..0.3) * size);
            let given = [-size, y, z];
            let (t, b) = split(given).unwrap();
            assert_eq!(scaled(t, b).map(f64::to_bits), given.map(f64::to_bits), "{given:?}");
            assert!((Vector3::from(t).norm() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_direction_stays_as_it_is_and_has_no_length() {
        let t = [-0.999_936_272_559_068_6, 0.011_266_989_436_188_637, -0.000_711_174_887_924_816_8];
        assert_eq!(split(scaled(t, None)).unwrap(), (t, None));
    }

    #[test]
    fn a_translation_without_direction_is_refused() {
        for t in [[0.0; 3], [f64::NAN, 0.0, 0.0], [f64::INFINITY, 0.0, 0.0]] {
            assert!(split(t).unwrap_err().to_string().contains("no direction"));
        }
    }
}
