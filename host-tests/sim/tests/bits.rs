//! Made scenes have the same bits on every system.

use sim::synth::{Scenario, ScenarioKind};

/// FNV-1a over the bits of the matches of 20 pairs.
fn checksum(kind: ScenarioKind) -> u64 {
    let mut scenario = Scenario { lens_prior: true, ..Scenario::new(kind, 20) };
    scenario.scene.outliers = 0.2;
    let matches = scenario.frames(9).unwrap().flat_map(|frame| frame.pair.matches);
    let numbers = matches.flat_map(|m| [m.ul, m.vl, m.ur, m.vr]);
    numbers.fold(0xcbf2_9ce4_8422_2325, |sum: u64, number| {
        (sum ^ number.to_bits()).wrapping_mul(0x0100_0000_01b3)
    })
}

#[test]
fn made_pairs_have_known_bits() {
    for (kind, expected) in [
        (ScenarioKind::Heterogeneous, 0x9971_e937_143d_4b4b_u64),
        (ScenarioKind::Planar, 0xcc31_c737_c1bb_0598),
        (ScenarioKind::Flight, 0x84aa_e768_b9f1_dcf8),
    ] {
        assert_eq!(format!("{:x}", checksum(kind)), format!("{expected:x}"), "{kind}");
    }
}
