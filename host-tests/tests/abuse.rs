//! The fuzz targets' harnesses under random bytes, on any toolchain.

use host_tests::abuse::abuse;
use host_tests::store_abuse::abuse_store;
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

#[test]
fn any_flash_and_any_operations_break_no_promise_of_the_store() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_122);
    let mut loaded = 0_u32;
    for _ in 0..4000 {
        let mut bytes = vec![0; rng.random_range(0..3000)];
        rng.fill_bytes(&mut bytes);
        abuse_store(&bytes, |_, _| loaded += 1);
    }
    assert!(loaded > 100_000, "{loaded}");
}
