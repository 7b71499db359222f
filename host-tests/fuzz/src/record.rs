//! Records of arbitrary content with valid checksums: accepted ones must give a valid calibrator.

use arbitrary::{Arbitrary, Unstructured};
use stereo_selfcal::FactoryCalibration;

use super::check::{check_estimate, check_extrinsics, check_in_use, check_verdict};
use super::{Configured, Target, configured, plausible, usual_cameras};

/// Changes to a valid record before it is read.
#[derive(Debug, Clone, Arbitrary)]
enum Change {
    /// Four bytes are replaced by any.
    Word(u16, u32),
    /// A number is scaled by a power of two.
    Scaled(u16, i8),
    /// Two numbers are swapped.
    Swapped(u16, u16),
    /// The end is cut off.
    Shorter(u16),
    /// Bytes are appended.
    Longer(Vec<u8>),
}

/// Reads the records that `bytes` encode, and continues with those accepted.
///
/// # Panics
/// If the core violates a property.
pub fn run_record(bytes: &[u8]) {
    // First the bytes as they are.
    let _ = FactoryCalibration::<f32>::from_record(bytes);
    let mut input = Unstructured::new(bytes);
    let Configured { config, other: factory, .. } = configured(&mut input);
    let pairs = u8::arbitrary(&mut input).unwrap_or_default() % 8;
    let made = FactoryCalibration::guess(usual_cameras([0; 5], false).expect("usual cameras"));
    let mut calibrator = Target::new(config, &made);
    if calibrator.restore(bytes).is_ok() {
        go_on(&mut calibrator, &made);
        calibrator.reset();
    }
    let mut record = if factory {
        made.to_record().to_vec()
    } else {
        (0..pairs).for_each(|pair| take(&mut calibrator, pair));
        let _ = calibrator.apply();
        calibrator.snapshot().to_vec()
    };
    while let Ok(change) = Change::arbitrary(&mut input) {
        apply(&change, &mut record);
        if input.is_empty() {
            break;
        }
    }
    seal(&mut record);
    if let Ok(found) = FactoryCalibration::<f32>::from_record(&record) {
        check_extrinsics(&found.extrinsics);
        assert_eq!(FactoryCalibration::from_record(&found.to_record()), Ok(found));
    }
    let mut fresh = Target::new(config, &made);
    let untouched = (fresh.in_use().extrinsics, fresh.in_use().generation);
    if fresh.restore(&record).is_ok() {
        go_on(&mut fresh, &made);
    } else {
        assert_eq!((fresh.in_use().extrinsics, fresh.in_use().generation), untouched);
        assert!(fresh.proposal().is_none());
    }
}

fn apply(change: &Change, record: &mut Vec<u8>) {
    // Header and checksum are kept, because other tests cover them.
    let words = (record.len().saturating_sub(16) / 4).max(1);
    let place = |at: u16| 12 + usize::from(at) % words * 4;
    let get = |record: &[u8], at: u16| -> [u8; 4] {
        let word = record.get(place(at)..place(at) + 4);
        word.and_then(|word| word.try_into().ok()).unwrap_or_default()
    };
    let put = |record: &mut Vec<u8>, at: u16, word: [u8; 4]| {
        if let Some(place) = record.get_mut(place(at)..place(at) + 4) {
            place.copy_from_slice(&word);
        }
    };
    match change {
        Change::Word(at, bits) => put(record, *at, bits.to_le_bytes()),
        Change::Scaled(at, exponent) => {
            let scaled = f32::from_le_bytes(get(record, *at)) * f32::from(*exponent).exp2();
            put(record, *at, scaled.to_le_bytes());
        }
        Change::Swapped(a, b) => {
            let [x, y] = [get(record, *a), get(record, *b)];
            put(record, *a, y);
            put(record, *b, x);
        }
        Change::Shorter(by) => {
            record.truncate(record.len() - usize::from(*by) % record.len().max(1));
        }
        Change::Longer(bytes) => record.extend(bytes),
    }
}

/// Corrects the checksum at the end.
pub(super) fn seal(record: &mut [u8]) {
    if let Some((body, sum)) = record.split_last_chunk_mut::<4>() {
        *sum = crc32(body).to_le_bytes();
    }
}

/// CRC-32 of IEEE 802.3, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}

/// Takes further pairs, and checks all results.
fn go_on(calibrator: &mut Target, made: &FactoryCalibration<f32>) {
    for pair in 8..12 {
        check_in_use(calibrator, made);
        if let Some(estimate) = calibrator.proposal() {
            check_estimate(&estimate);
        }
        take(calibrator, pair);
        if let Some(details) = calibrator.details() {
            assert!(details.in_use_px.is_finite() && details.proposed_px.is_finite());
        }
        check_verdict(calibrator.verdict());
        let _ = calibrator.apply();
    }
}

/// Takes a plausible pair.
fn take(calibrator: &mut Target, pair: u8) {
    calibrator.discard_pair();
    for i in 0..30_u8 {
        let [u, v] = [i.wrapping_mul(37).wrapping_add(pair), i.wrapping_mul(71) ^ pair];
        let _ = calibrator.push(&plausible([u, v, i.wrapping_mul(29).wrapping_add(pair), 1]));
    }
    let _ = calibrator.solve_pair();
}
