//! Normal random numbers with the same bits on every system.

use std::convert::Infallible;

use rand::{Rng, TryRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Where the tails of `StandardNormal` begin.
const TAIL: f64 = 3.654_152_885_361_009;

/// A generator, and the last two words that it has given.
struct Noted<'a> {
    rng: &'a mut ChaCha8Rng,
    words: [u64; 2],
}

impl TryRng for Noted<'_> {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        Ok(self.rng.next_u32())
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        self.words = [self.words[1], self.rng.next_u64()];
        Ok(self.words[1])
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        self.rng.fill_bytes(bytes);
        Ok(())
    }
}

/// A number of mean 0 and standard deviation 1.
///
/// `StandardNormal` computes a number in a tail with the logarithm of the system, whose last bit differs between
/// systems. Here it is computed with that of `libm`, from the same random word.
pub(super) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let mut noted = Noted { rng, words: [0; 2] };
    let number: f64 = StandardNormal.sample(&mut noted);
    if number.abs() < TAIL {
        return number;
    }
    // The word as a fraction between 0 and 1, as `rand` makes it.
    let fraction =
        f64::from_bits((0x3ff << 52) | (noted.words[0] >> 12)) - (1.0 - f64::EPSILON / 2.0);
    (TAIL - libm::log(fraction) / TAIL).copysign(number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn numbers_equal_those_of_the_library_and_in_its_tails_nearly() {
        let [mut own, mut library] = [1, 1].map(ChaCha8Rng::seed_from_u64);
        let mut tails = 0;
        for _ in 0..100_000 {
            let (own, library): (f64, f64) =
                (normal(&mut own), StandardNormal.sample(&mut library));
            tails += u32::from(own.abs() >= TAIL);
            let ulps = own.to_bits().abs_diff(library.to_bits());
            assert!(ulps <= 2 && (ulps == 0 || own.abs() >= TAIL), "{own} {library}");
        }
        assert!((10..50).contains(&tails), "{tails}");
    }
}
