//! The fuzz targets' harnesses under random bytes, on any toolchain.

use std::fs;
use std::path::Path;

use fuzz::{run_bags, run_images, run_rigs, run_tables};
use fuzz::{run_calibrator, run_decoder, run_frames, run_record, run_store};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use test_support::runs;

fn random_bytes_into(harness: fn(&[u8]), runs: usize) {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_121);
    for _ in 0..runs {
        let mut bytes = vec![0; rng.random_range(0..2048)];
        rng.fill_bytes(&mut bytes);
        harness(&bytes);
    }
}

/// Seeds of the fuzzer, and inputs that once violated a property.
#[test]
fn the_corpus_keeps_the_guarantees() {
    type Harness = fn(&[u8]);
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus");
    let harnesses: [(&str, Harness); 9] = [
        ("bags", run_bags),
        ("images", run_images),
        ("rigs", run_rigs),
        ("tables", run_tables),
        ("calibrator", run_calibrator),
        ("decoder", run_decoder),
        ("frames", run_frames),
        ("record", run_record),
        ("store", |bytes| {
            let _ = run_store(bytes);
        }),
    ];
    for (target, harness) in harnesses {
        let inputs = fs::read_dir(corpus.join(target)).unwrap();
        let read = |input: std::io::Result<fs::DirEntry>| fs::read(input.unwrap().path()).unwrap();
        let inputs: Vec<_> = inputs.map(read).collect();
        assert!(inputs.len() > 5, "{target}");
        for bytes in &inputs {
            harness(bytes);
        }
    }
}

#[test]
fn arbitrary_calls_in_any_order_keep_the_guarantees() {
    random_bytes_into(run_calibrator, runs(4_000, 20_000));
}

#[test]
fn arbitrary_streams_in_any_cut_keep_the_guarantees_of_the_decoder() {
    random_bytes_into(run_decoder, runs(5_000, 20_000));
}

#[test]
fn arbitrary_frames_keep_the_guarantees_of_the_calibrator() {
    random_bytes_into(run_frames, runs(5_000, 20_000));
}

#[test]
fn arbitrary_records_keep_the_guarantees() {
    random_bytes_into(run_record, runs(2_000, 5_000));
}

#[test]
fn any_flash_and_any_operations_keep_the_guarantees_of_the_store() {
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_122);
    let mut loaded = 0_u32;
    let operations = runs(1_000, 4_000);
    for _ in 0..operations {
        let mut bytes = vec![0; rng.random_range(0..3000)];
        rng.fill_bytes(&mut bytes);
        loaded += run_store(&bytes);
    }
    assert!(loaded > 25 * operations, "{loaded}");
}

#[test]
fn files_of_any_bytes_are_read_or_refused_by_name() {
    for harness in [run_bags, run_images, run_rigs, run_tables] {
        random_bytes_into(harness, runs(200, 20_000));
    }
}
