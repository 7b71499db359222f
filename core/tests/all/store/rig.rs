//! Store over simulated flash, and its expected content.

use stereo_selfcal::store::{LoadError, RecordKind, SaveError, Store};
use test_support::flash::{Fault, Flash};

pub(crate) const KINDS: [RecordKind; 2] = [RecordKind::Factory, RecordKind::State];

/// Save of a payload, or removal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Step {
    pub(crate) kind: RecordKind,
    pub(crate) payload: Option<Vec<u8>>,
}

/// Content of the store.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Content {
    pub(crate) factory: Option<Vec<u8>>,
    pub(crate) state: Option<Vec<u8>>,
}

impl Content {
    pub(crate) fn of(&self, kind: RecordKind) -> Option<&Vec<u8>> {
        if kind == RecordKind::Factory { self.factory.as_ref() } else { self.state.as_ref() }
    }

    pub(crate) fn after(&self, step: &Step) -> Self {
        let mut after = self.clone();
        let content =
            if step.kind == RecordKind::Factory { &mut after.factory } else { &mut after.state };
        content.clone_from(&step.payload);
        after
    }
}

/// Opens a store with pages of `page_blocks` blocks, after one block outside the store.
pub(crate) fn open<const W: usize, const E: usize>(
    flash: Flash<W, E>,
    page_blocks: usize,
) -> Store<Flash<W, E>> {
    let end = u32::try_from(flash.bytes.len()).unwrap();
    let [start, page] = [E, page_blocks * E].map(|bytes| u32::try_from(bytes).unwrap());
    Store::open(flash, start..end, page).unwrap()
}

/// Erases all pages; arguments as in [`open`].
pub(crate) fn format<const W: usize, const E: usize>(
    flash: Flash<W, E>,
    page_blocks: usize,
) -> Store<Flash<W, E>> {
    let end = u32::try_from(flash.bytes.len()).unwrap();
    let [start, page] = [E, page_blocks * E].map(|bytes| u32::try_from(bytes).unwrap());
    Store::format(flash, start..end, page).unwrap()
}

pub(crate) fn load<const W: usize, const E: usize>(
    store: &mut Store<Flash<W, E>>,
    kind: RecordKind,
) -> Result<Option<Vec<u8>>, LoadError<Fault>> {
    let mut buffer = [0; 4096];
    Ok(store.load(kind, &mut buffer)?.map(<[u8]>::to_vec))
}

/// Content of the store; an unreadable record with no other counts as none.
pub(crate) fn content<const W: usize, const E: usize>(store: &mut Store<Flash<W, E>>) -> Content {
    let [factory, state] = KINDS.map(|kind| match load(store, kind) {
        Err(LoadError::Flash(Fault::Ecc)) => None,
        loaded => loaded.unwrap(),
    });
    Content { factory, state }
}

pub(crate) fn perform<const W: usize, const E: usize>(
    store: &mut Store<Flash<W, E>>,
    step: &Step,
) -> Result<(), SaveError<Fault>> {
    match &step.payload {
        Some(payload) => store.save(step.kind, payload),
        None => store.remove(step.kind),
    }
}

/// Payload that differs by number; one in four reads as erased flash.
pub(crate) fn payload(number: usize, bytes: usize) -> Vec<u8> {
    let of = |i: usize| if number % 4 == 3 && i > 0 { 0xff } else { (number * 37 + i * 101) % 251 };
    (0..bytes).map(|i| u8::try_from(of(i)).unwrap()).collect()
}

pub(crate) fn save(kind: RecordKind, number: usize, bytes: usize) -> Step {
    Step { kind, payload: Some(payload(number, bytes)) }
}

/// First saves, several erasures, both kinds, one kind removed and saved again.
pub(crate) fn scenario(factory: usize, state: usize) -> Vec<Step> {
    let mut steps = vec![save(RecordKind::State, 0, state), save(RecordKind::Factory, 1, factory)];
    steps.extend((2..16).map(|i| save(RecordKind::State, i, state - state.min(i % 3))));
    steps.push(save(RecordKind::Factory, 16, factory));
    steps.push(Step { kind: RecordKind::State, payload: None });
    steps.extend((18..23).map(|i| save(RecordKind::State, i, state)));
    steps.push(save(RecordKind::Factory, 23, factory));
    steps.extend((24..28).map(|i| save(RecordKind::State, i, state)));
    steps
}
