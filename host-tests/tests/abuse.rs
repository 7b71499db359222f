//! The fuzz target's harness under random bytes, on any toolchain.

use host_tests::abuse::abuse;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[test]
fn arbitrary_bits_in_any_order_break_no_promise() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    for _ in 0..20_000 {
        let mut bytes = vec![0; rng.random_range(0..2048)];
        rng.fill_bytes(&mut bytes);
        abuse(&bytes);
    }
}
