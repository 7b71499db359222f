//! Quads against one correspondence at a time.

use super::super::pass::{PassOver, PassSums};
use super::*;
use crate::pair::scenes::{batch, pixels, solvers};
use proptest::prelude::*;

fn sums<T: Scalar>(pass: &PassSums<T>) -> impl Iterator<Item = u64> {
    let normal = pass.normal.information.0.0.into_iter().chain(pass.normal.gradient.data.0[0]);
    let counts = [pass.usable, pass.weighted, pass.near, pass.near_squares];
    normal.chain(counts).map(|x| x.to_f64().to_bits())
}

fn agree<T: Scalar>(pixels: &[[f64; 4]], rotation: [f64; 3], t: [f64; 2], most: usize) {
    let batch = batch::<T>(pixels.iter().copied());
    for solver in solvers(&batch, rotation, t) {
        let (iterate, schedule) = (&solver.iterate, &solver.schedule);
        let [mut single, mut baseline] =
            [(); 2].map(|()| PassOver { iterate, schedule, sums: PassSums::ZERO });
        single.sweep_single(spread_over(batch.pairs(), most).map(sample));
        run_baseline(&mut baseline, batch.pairs(), most);
        assert!(sums(&single.sums).eq(sums(&baseline.sums)), "{:?}", baseline.sums);
    }
}

proptest! {
    #[test]
    fn a_pass_in_quads_is_bit_identical_to_one_correspondence_at_a_time(
        pixels in pixels(), rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1],
        t in [-0.1..0.1, -0.1..0.1], most in prop_oneof![Just(usize::MAX), 1..100_usize],
    ) {
        agree::<f64>(&pixels, rotation, t, most);
        agree::<f32>(&pixels, rotation, t, most);
    }
}
