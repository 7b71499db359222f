//! Quads against one correspondence at a time; the half of the batch.

extern crate std;

use super::super::pass::{PassOver, PassSums};
use super::*;
use crate::pair::scenes::{batch, pixels, solvers};
use crate::thresholds::TRACKED;
use proptest::prelude::*;
use std::vec::Vec;

fn sums<T: Scalar>(pass: &PassSums<T>) -> impl Iterator<Item = u64> {
    let normal = pass.normal.information.0.0.into_iter().chain(pass.normal.gradient.data.0[0]);
    let counts = [pass.usable, pass.weighted, pass.near, pass.near_squares];
    normal.chain(counts).map(|x| x.to_f64().to_bits())
}

fn agree<T: Scalar>(pixels: &[[f64; 4]], rotation: [f64; 3], t: [f64; 2], part: Part) {
    let batch = batch::<T>(pixels.iter().copied());
    for solver in solvers(&batch, rotation, t) {
        let (iterate, schedule) = (&solver.iterate, &solver.schedule);
        let [mut single, mut baseline] =
            [(); 2].map(|()| PassOver { iterate, schedule, sums: PassSums::ZERO });
        single.sweep_single(part.of(batch.pairs()).map(sample));
        run_baseline(&mut baseline, batch.pairs(), part);
        assert!(sums(&single.sums).eq(sums(&baseline.sums)), "{:?}", baseline.sums);
    }
}

proptest! {
    #[test]
    fn a_pass_in_quads_is_bit_identical_to_one_correspondence_at_a_time(
        pixels in pixels(), rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1],
        t in [-0.1..0.1, -0.1..0.1], part in prop_oneof![Just(Part::All), Just(Part::Half)],
    ) {
        agree::<f64>(&pixels, rotation, t, part);
        agree::<f32>(&pixels, rotation, t, part);
    }
}

/// Percentage of the half of a batch that is read at some of its places.
fn percent_read(length: usize, is_among: impl Fn(usize) -> bool) -> usize {
    let all: Vec<usize> = (0..length).collect();
    let read: Vec<_> = Part::Half.of(&all).collect();
    100 * read.iter().filter(|place| is_among(***place)).count() / read.len()
}

#[test]
fn half_of_the_batch_follows_no_period() {
    for length in (TRACKED + 1..=1024).step_by(17) {
        // Outliers in one half of the places that recur, wherever it begins.
        for period in 2..=64 {
            for first in 0..period {
                let among = |place| (place + first) % period < period / 2;
                let percent = percent_read(length, among);
                assert!(percent < 65, "{length} {period} {first}: {percent}");
            }
        }
    }
}

#[test]
fn a_pass_reads_all_of_the_batch_or_half() {
    for length in 0..=1024_usize {
        let all: Vec<usize> = (0..length).collect();
        assert!(Part::All.of(&all).eq(&all), "{length}");
        let read: Vec<_> = Part::Half.of(&all).collect();
        assert!(
            read.is_sorted_by(|a, b| a < b) && read.len().abs_diff(length / 2) <= 1,
            "{read:?}"
        );
    }
}
