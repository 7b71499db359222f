//! The flash store on arbitrary flash under any sequence of operations, held to its promises: no panic,
//! no word is written twice; the last saved record is found until a bit rots, and then no other one.

use arbitrary::{Arbitrary, Unstructured};
use stereo_selfcal::store::{LoadError, RecordKind, Store};
use test_support::flash::{Fault, Flash, TEARS};

const BLOCK: usize = 256;
const KINDS: [RecordKind; 2] = [RecordKind::Factory, RecordKind::State];

type Target = Store<Flash<8, BLOCK>>;

/// One operation on the store, or on its flash. `true` is the state, `false` the factory data.
#[derive(Debug, Clone, Arbitrary)]
enum Operation {
    /// So many bytes.
    Save(bool, u8),
    /// Then nothing of the kind is found.
    Forget(bool),
    /// Into a buffer of so many bytes.
    Load(bool, u8),
    /// Closed and opened.
    Reopen,
    /// Power is lost after so many words of a save.
    Cut(bool, u8, u8),
    /// A byte gets other bits.
    Rot(u16, u8),
    /// A block takes no more words, with an error or without; or all do again.
    WearOut(Option<(u8, bool)>),
}

/// What must be in the store.
#[derive(Debug, Default)]
struct Promise {
    held: [Option<Vec<u8>>; 2],
    ever: Vec<Vec<u8>>,
    /// The flash began erased: all that is in it was saved.
    is_known: bool,
    /// A byte went wrong: records may be older ones.
    is_rotten: bool,
}

/// Runs the operations that `bytes` stand for. `loaded` gets every payload that is loaded.
///
/// # Panics
/// If the store violates a property.
pub fn run_store(bytes: &[u8], mut loaded: impl FnMut(RecordKind, &[u8])) {
    let mut input = Unstructured::new(bytes);
    let [is_known, large] = <[bool; 2]>::arbitrary(&mut input).unwrap_or_default();
    let [pages, tear] = <[u8; 2]>::arbitrary(&mut input).unwrap_or_default();
    let mut content = vec![0xff; (2 + usize::from(pages % 3)) * BLOCK * (1 + usize::from(large))];
    if !is_known {
        let _ = input.fill_buffer(&mut content);
    }
    let mut flash = Flash::of(content, bytes.len() as u64);
    flash.tear = TEARS[usize::from(tear) % TEARS.len()];
    let page = BLOCK * (1 + usize::from(large));
    let Some(mut store) = open(flash, page) else { return };
    let mut promise = Promise { is_known, ..Promise::default() };
    promise.held = KINDS.map(|kind| load(&mut store, kind, &mut loaded));
    let mut number = 0;
    while let Ok(operation) = Operation::arbitrary(&mut input) {
        number += 1;
        let Some(left) = perform(store, page, &operation, number, &mut promise) else { return };
        store = left;
        for (kind, held) in KINDS.into_iter().zip(&mut promise.held) {
            let found = load(&mut store, kind, &mut loaded);
            let known = found.as_ref().is_none_or(|found| promise.ever.contains(found));
            assert!(known || !promise.is_known, "{operation:?}: {kind:?} was never saved");
            assert!(promise.is_rotten || found == *held, "{operation:?}: {kind:?} is another");
            *held = found;
        }
        if input.is_empty() {
            break;
        }
    }
}

/// `None` if arbitrary bytes make a record of another layout.
fn open(flash: Flash<8, BLOCK>, page: usize) -> Option<Target> {
    let [end, page] =
        [flash.bytes.len(), page].map(|bytes| u32::try_from(bytes).expect("a few kB"));
    Store::open(flash, 0..end, page).ok()
}

fn load(
    store: &mut Target,
    kind: RecordKind,
    loaded: &mut impl FnMut(RecordKind, &[u8]),
) -> Option<Vec<u8>> {
    let mut buffer = [0; 2 * BLOCK];
    match store.load(kind, &mut buffer) {
        Ok(found) => found.map(|payload| {
            loaded(kind, payload);
            payload.to_vec()
        }),
        // Pages that read 00 throughout are a fault, not flash without records.
        Err(LoadError::Flash(Fault::Ecc) | LoadError::Unstable) => None,
        Err(error) => panic!("{error}"),
    }
}

fn payload(number: usize, bytes: u8) -> Vec<u8> {
    (0..bytes).map(|i| i.wrapping_mul(7) ^ number.to_le_bytes()[0]).collect()
}

fn perform(
    mut store: Target,
    page: usize,
    operation: &Operation,
    number: usize,
    promise: &mut Promise,
) -> Option<Target> {
    match *operation {
        Operation::Save(state, bytes) => {
            let new = payload(number, bytes);
            promise.ever.push(new.clone());
            match store.save(KINDS[usize::from(state)], &new) {
                Ok(()) => promise.held[usize::from(state)] = Some(new),
                // A worn block may have taken the first of two copies.
                Err(_) => may_be_either(&mut store, state, new, promise),
            }
        }
        Operation::Forget(state) => {
            if store.remove(KINDS[usize::from(state)]).is_ok() {
                promise.held[usize::from(state)] = None;
            } else {
                promise.is_rotten = true;
            }
        }
        Operation::Load(state, bytes) => {
            let mut buffer = vec![0; usize::from(bytes)];
            let needed = promise.held[usize::from(state)].as_ref().map_or(0, Vec::len);
            let found = store.load(KINDS[usize::from(state)], &mut buffer);
            let small = matches!(found, Err(LoadError::BufferTooSmall { .. }));
            assert!(promise.is_rotten || small == (needed > buffer.len()));
        }
        Operation::Reopen => store = open(store.close(), page)?,
        Operation::Cut(state, bytes, after) => {
            let new = payload(number, bytes);
            promise.ever.push(new.clone());
            let mut flash = store.close();
            flash.power_for = Some(u32::from(after) + 1);
            store = open(flash, page)?;
            let _ = store.save(KINDS[usize::from(state)], &new);
            let mut flash = store.close();
            flash.power_on();
            store = open(flash, page)?;
            may_be_either(&mut store, state, new, promise);
        }
        Operation::Rot(at, bits) => {
            let mut flash = store.close();
            let at = usize::from(at) % flash.bytes.len();
            flash.bytes[at] ^= bits;
            promise.is_rotten |= bits != 0;
            store = open(flash, page)?;
        }
        Operation::WearOut(block) => {
            let mut flash = store.close();
            let blocks = flash.erased.len();
            flash.worn = block.map(|(block, says_so)| (usize::from(block) % blocks, says_so));
            store = open(flash, page)?;
        }
    }
    Some(store)
}

/// A save that failed: the old record is found, or the new one.
fn may_be_either(store: &mut Target, state: bool, new: Vec<u8>, promise: &mut Promise) {
    let found = load(store, KINDS[usize::from(state)], &mut |_, _| ());
    if found.as_ref() == Some(&new) {
        promise.held[usize::from(state)] = Some(new);
    }
}
