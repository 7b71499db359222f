//! The flash store on arbitrary flash under any sequence of operations, checked for its guarantees: no panic, and no
//! word written twice. The last saved record is found, as long as no bit of the flash has changed by itself.

use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use stereo_selfcal::FactoryCalibration;
use stereo_selfcal::store::{SavePolicy, Store};
use test_support::flash::{Flash, TEARS};

use super::record::seal;
use super::{Target, usual_cameras};

const BLOCK: usize = 1024;

type Nor = Flash<8, BLOCK>;

/// One operation on the store, or on its flash. `true` is the state, `false` the factory calibration.
#[derive(Debug, Clone, Arbitrary)]
enum Operation {
    Save(bool),
    /// The store is closed and opened.
    Reopen,
    /// Power is lost after so many written words and erased blocks of a save.
    Cut(bool, u8),
    /// A byte changes some bits.
    Rot(u16, u8),
    /// A block accepts no further word, with or without an error; or all blocks work again.
    WearOut(Option<(u8, bool)>),
}

/// A store, and the numbers that its records must have: the factory calibration first, then the state.
///
/// A record carries its number as the length of the baseline, m, or as the generation.
struct Kept {
    store: Store<Nor, f32>,
    fresh: Target,
    held: [Option<u16>; 2],
    saved: u16,
}

/// Runs the operations that `bytes` encode; returns the number of records found, summed over the operations.
///
/// # Panics
/// If the store violates a property.
#[must_use]
pub fn run_store(bytes: &[u8]) -> u32 {
    let mut input = Unstructured::new(bytes);
    let is_erased = bool::arbitrary(&mut input).unwrap_or_default();
    let [blocks, tear] = <[u8; 2]>::arbitrary(&mut input).unwrap_or_default();
    let mut content = vec![0xff; 2 * (2 + usize::from(blocks % 3)) * BLOCK];
    if !is_erased {
        let _ = input.fill_buffer(&mut content);
    }
    let mut flash = Nor::of(content, bytes.len() as u64);
    flash.tear = TEARS[usize::from(tear) % TEARS.len()];
    let fresh = Target::new(stereo_selfcal::Config::robust(), &made());
    let mut kept = Kept { store: open(flash), fresh, held: [None; 2], saved: 0 };
    kept.held = kept.found();
    let (mut is_rotten, mut found) = (false, 0);
    while let Ok(operation) = Operation::arbitrary(&mut input) {
        let held = kept.held;
        let may_be_new = kept.perform(&operation, &mut is_rotten);
        let now = kept.found();
        for ((new, old), expected) in now.into_iter().zip(held).zip(kept.held) {
            let is_known = new == expected || may_be_new && (new == Some(kept.saved) || new == old);
            assert!(is_known || is_rotten, "{operation:?}: {new:?}, not {expected:?}");
            found += u32::from(new.is_some());
        }
        kept.held = now;
        if input.is_empty() {
            break;
        }
    }
    found
}

fn made() -> FactoryCalibration<f32> {
    FactoryCalibration::guess(usual_cameras([0; 5], false).expect("usual cameras"))
}

fn open(flash: Nor) -> Store<Nor, f32> {
    let end = u32::try_from(flash.bytes.len()).expect("a few kB");
    let policy = SavePolicy::default();
    Store::open(flash, 0..end / 2, end / 2..end, policy).expect("whole blocks")
}

impl Kept {
    /// Numbers of the factory calibration and of the state that the store finds; `None` without a record.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "as many as saves")]
    fn found(&mut self) -> [Option<u16>; 2] {
        let factory = self.store.load_factory().ok().flatten();
        let factory = factory.and_then(|made| Some(made.baseline_m()? as u16));
        let mut calibrator = self.fresh.clone();
        let resumed = self.store.resume(&mut calibrator) == Ok(true);
        [factory, resumed.then(|| calibrator.in_use().generation as u16)]
    }

    /// Saves the next number; returns whether it was saved.
    fn save(&mut self, state: bool) -> bool {
        self.saved += 1;
        let number = self.saved;
        if !state {
            let made = made().with_baseline_m(number.into()).expect("some metres");
            return self.store.save_factory(&made).is_ok();
        }
        let mut record = self.fresh.snapshot();
        record[12..16].copy_from_slice(&u32::from(number).to_le_bytes());
        seal(&mut record);
        let mut calibrator = self.fresh.clone();
        calibrator.restore(&record).expect("another generation");
        self.store.save(&calibrator, Duration::ZERO).is_ok()
    }

    fn with_flash(&mut self, change: impl FnOnce(&mut Nor)) {
        // The store cannot be moved out of `self`, so a blank one takes its place while the flash changes.
        let blank = Nor::of(vec![0xff; 4 * BLOCK], 0);
        let mut flash = std::mem::replace(&mut self.store, open(blank)).close();
        change(&mut flash);
        self.store = open(flash);
    }

    /// Performs an operation; returns whether the number of a save that failed may be found.
    fn perform(&mut self, operation: &Operation, is_rotten: &mut bool) -> bool {
        match *operation {
            Operation::Save(state) => {
                let is_saved = self.save(state);
                if is_saved {
                    self.held[usize::from(state)] = Some(self.saved);
                }
                return !is_saved;
            }
            Operation::Reopen => self.with_flash(|_| ()),
            Operation::Cut(state, words) => {
                self.with_flash(|flash| flash.power_for = Some(u32::from(words) + 1));
                let _ = self.save(state);
                self.with_flash(Flash::power_on);
                return true;
            }
            Operation::Rot(at, bits) => {
                self.with_flash(|flash| {
                    let at = usize::from(at) % flash.bytes.len();
                    flash.rot = Some((1, at, bits));
                });
                *is_rotten |= bits != 0;
            }
            Operation::WearOut(block) => self.with_flash(|flash| {
                let blocks = flash.erased.len();
                flash.worn = block.map(|(block, says)| (usize::from(block) % blocks, says));
            }),
        }
        false
    }
}
