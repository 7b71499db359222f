//! Faults of the flash that stand for a while: whether the factory record is lost, the state older than the one before,
//! or a record a mixture.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::store::{LoadError, RecordKind, Store};
use test_support::flash::{Flash, TEARS};

use crate::store::faulty::{Active, DEFECTS, Defect, Faults, Faulty};
use crate::store::rig::{Step, payload, save, scenario};
use test_support::{is_campaign, runs};

type Under<const W: usize, const E: usize> = Store<Faulty<W, E>>;

const ALL: u32 = u32::MAX;
/// Longest scenario.
const STEPS: usize = 28;

/// Payloads that may be found, newest last; `None` after removal.
#[derive(Debug, Clone, Default)]
struct History {
    /// Saved, and reported so.
    saved: Vec<Option<Vec<u8>>>,
    /// Attempted since the last one that was saved.
    attempted: Vec<Option<Vec<u8>>>,
}

impl History {
    fn note(&mut self, step: &Step, saved: bool) {
        if saved {
            self.saved.push(step.payload.clone());
            self.attempted.clear();
        } else {
            self.attempted.push(step.payload.clone());
        }
    }

    fn newest(&self) -> Option<Vec<u8>> {
        self.saved.last().cloned().flatten()
    }

    /// * `before`: number of older records that are allowed as well.
    fn allows(&self, found: Option<&Vec<u8>>, before: usize) -> bool {
        let is = |payload: &Option<Vec<u8>>| payload.as_ref() == found;
        let older = self.saved.iter().rev().take(1 + before).any(is);
        older || (self.saved.is_empty() && found.is_none()) || self.attempted.iter().any(is)
    }
}

fn open<const W: usize, const E: usize>(flash: Faulty<W, E>) -> Under<W, E> {
    let end = u32::try_from(flash.flash.bytes.len()).unwrap();
    let page = u32::try_from(E).unwrap();
    Store::open(flash, page..end, page).unwrap()
}

fn perform<const W: usize, const E: usize>(store: &mut Under<W, E>, step: &Step) -> bool {
    match &step.payload {
        Some(payload) => store.save(step.kind, payload).is_ok(),
        None => store.remove(step.kind).is_ok(),
    }
}

fn load<const W: usize, const E: usize>(
    store: &mut Under<W, E>,
    kind: RecordKind,
) -> Result<Option<Vec<u8>>, LoadError<test_support::flash::Fault>> {
    let mut buffer = [0; 4096];
    Ok(store.load(kind, &mut buffer)?.map(<[u8]>::to_vec))
}

/// Records of both kinds: factory, state.
type Histories = [History; 2];

fn index(kind: RecordKind) -> usize {
    usize::from(kind == RecordKind::State)
}

/// Flash after the first `steps` of the scenario, with the factory record saved first.
fn used<const W: usize, const E: usize>(
    pages: usize,
    steps: usize,
    bytes: (usize, usize),
) -> (Faulty<W, E>, Histories) {
    let flash = Flash::new(1 + pages, steps as u64);
    let mut store = open(Faulty { flash, faults: Faults::default() });
    let mut histories = Histories::default();
    let first = save(RecordKind::Factory, 100, bytes.0);
    for step in [first].into_iter().chain(scenario(bytes.0, bytes.1)).take(1 + steps) {
        assert!(perform(&mut store, &step));
        histories[index(step.kind)].note(&step, true);
    }
    (store.close(), histories)
}

/// Five saves of the state, and one of a factory record if `factory`.
fn five_saves<const W: usize, const E: usize>(
    store: &mut Under<W, E>,
    histories: &mut Histories,
    first: usize,
    bytes: (usize, usize),
    factory: bool,
) {
    for number in first..first + 5 {
        let step = save(RecordKind::State, number, bytes.1);
        let saved = perform(store, &step);
        histories[1].note(&step, saved);
        if factory && number == first + 2 {
            let step = save(RecordKind::Factory, number, bytes.0);
            let saved = perform(store, &step);
            histories[0].note(&step, saved);
        }
    }
}

/// A state saved while one page does not answer, and what is loaded once it answers again.
#[test]
fn a_state_saved_while_a_page_is_unreadable_is_newer_than_all_in_that_page() {
    const PAGES: usize = 3;
    let mut saves = 0;
    for (steps, page, bytes) in (0..STEPS)
        .flat_map(|steps| (0..PAGES).map(move |page| (steps, page)))
        .flat_map(|(steps, page)| sizes::<8, 512>().map(|bytes| (steps, page, bytes)))
    {
        let (flash, _) = used::<8, 512>(PAGES, steps, bytes);
        let faults = flash.faults.clone();
        faults.borrow_mut().push(Active { defect: Defect::Deaf, pages: 1 << page, after: 0 });
        let mut store = open(flash);
        let step = save(RecordKind::State, 99, bytes.1);
        if perform(&mut store, &step) {
            saves += 1;
            faults.borrow_mut().clear();
            let found = load(&mut open(store.close()), RecordKind::State).unwrap();
            assert_eq!(found, step.payload, "page {page}, {steps} steps, {bytes:?}");
        }
    }
    assert!(saves > 50, "{saves}");
}

/// Sizes of factory record and state: several of them in a page.
fn sizes<const W: usize, const E: usize>() -> [(usize, usize); 2] {
    [(20, 31), (30, (E / 2 - (30_usize + 28).next_multiple_of(W) - 28) / 2)]
}

/// What is stuck at once, in all pages: the newest records are intact afterwards.
fn stuck_everywhere<const W: usize, const E: usize>() -> usize {
    let every = runs(9, 3);
    let mut cases = 0;
    for (pages, steps) in
        (2..=5).flat_map(|pages| (0..STEPS).step_by(every).map(move |steps| (pages, steps)))
    {
        for (bytes, defect) in sizes::<W, E>()
            .into_iter()
            .flat_map(|b| [(b, Defect::Deaf), (b, Defect::Stuck(0)), (b, Defect::Stuck(0xff))])
        {
            for at_boot in [false, true] {
                let (flash, mut histories) = used::<W, E>(pages, steps, bytes);
                let context =
                    format!("{defect:?}, {pages} pages, {steps} steps, {bytes:?}, {at_boot}");
                let faults = flash.faults.clone();
                let begin = || faults.borrow_mut().push(Active { defect, pages: ALL, after: 0 });
                if at_boot {
                    begin();
                }
                let mut store = open(flash);
                if !at_boot {
                    begin();
                }
                five_saves(&mut store, &mut histories, 200, bytes, false);
                let mut store = open(store.close());
                five_saves(&mut store, &mut histories, 205, bytes, false);
                if defect != Defect::Stuck(0xff) {
                    assert!(load(&mut store, RecordKind::Factory).is_err(), "{context}");
                }
                faults.borrow_mut().clear();
                assert!(histories.iter().all(|h| h.saved.len() <= 1 + STEPS), "{context}");
                let mut again = open(store.close());
                check(&mut again, &histories, 0, &context);
                five_saves(&mut again, &mut histories, 210, bytes, false);
                check(&mut again, &histories, 0, &context);
                assert_eq!(histories[1].newest(), Some(payload(214, bytes.1)), "{context}");
                cases += 1;
            }
        }
    }
    cases
}

fn check<const W: usize, const E: usize>(
    store: &mut Under<W, E>,
    histories: &Histories,
    before: usize,
    context: &str,
) {
    for (kind, history) in [RecordKind::Factory, RecordKind::State].into_iter().zip(histories) {
        let found = load(store, kind).unwrap_or_else(|e| panic!("{e}: {kind:?}, {context}"));
        let older = if kind == RecordKind::Factory { 0 } else { before };
        assert!(
            history.allows(found.as_ref(), older),
            "{kind:?}, {context}: {found:?} of {history:?}"
        );
    }
}

#[test]
fn a_bus_that_is_deaf_or_stuck_destroys_nothing() {
    let cases = [
        stuck_everywhere::<1, 224>(),
        stuck_everywhere::<4, 256>(),
        stuck_everywhere::<8, 512>(),
        stuck_everywhere::<32, 1024>(),
        stuck_everywhere::<64, 1536>(),
    ];
    println!("{cases:?} cases, no record lost");
}

#[test]
fn a_save_whose_header_does_not_read_back_is_reported() {
    let (flash, mut histories) = used::<4, 256>(3, 8, (20, 31));
    let faults = flash.faults.clone();
    let mut store = open(flash);
    faults.borrow_mut().push(Active { defect: Defect::FirstBit, pages: ALL, after: 0 });
    for kind in [RecordKind::State, RecordKind::Factory] {
        assert!(!perform(&mut store, &save(kind, 200, 20)), "{kind:?}");
    }
    faults.borrow_mut().clear();
    let mut store = open(store.close());
    check(&mut store, &histories, 0, "no header took");
    five_saves(&mut store, &mut histories, 210, (20, 31), true);
    check(&mut store, &histories, 0, "after it");
}

/// Runs for each word size, defect and pair of defects.
const SEEDS: u64 = 4;
/// As `SEEDS`, of the campaign.
const MANY_SEEDS: u64 = 200;

/// Losses by defect and by pair of defects: factory records, states, saves impossible afterwards; and runs.
type Losses = std::collections::BTreeMap<String, [usize; 4]>;

/// One or two defects at random times in ten saves, a restart between, in some runs a loss of power.
fn run<const W: usize, const E: usize>(
    defects: &[Defect],
    seed: u64,
    cuts: bool,
    losses: &mut Losses,
) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let pages = random.random_range(2..=5);
    let bytes = sizes::<W, E>()[random.random_range(0..2)];
    let (mut flash, mut histories) = used::<W, E>(pages, random.random_range(0..STEPS), bytes);
    let faults = flash.faults.clone();
    flash.flash.tear = TEARS[random.random_range(0..TEARS.len())];
    flash.flash.random = ChaCha8Rng::seed_from_u64(seed);
    let active = defects.iter().map(|defect| Active {
        defect: *defect,
        pages: if random.random_ratio(1, 3) { ALL } else { 1 << random.random_range(0..pages) },
        after: if random.random() { 0 } else { random.random_range(0..400) },
    });
    let active: Vec<_> = active.collect();
    let at_boot: bool = random.random();
    let factory = random.random_ratio(1, 4);
    let mut store = if at_boot {
        faults.borrow_mut().extend(&active);
        open(flash)
    } else {
        let store = open(flash);
        faults.borrow_mut().extend(&active);
        store
    };
    for first in [200, 210] {
        if cuts && random.random() {
            let mut flash = store.close();
            flash.flash.power_for = Some(random.random_range(1..400));
            store = open(flash);
        }
        five_saves(&mut store, &mut histories, first, bytes, factory);
        let mut flash = store.close();
        flash.flash.power_on();
        store = open(flash);
    }
    faults.borrow_mut().clear();
    let mut store = open(store.close());
    let loss =
        losses.entry(format!("{defects:?}{}", if cuts { " and cuts" } else { "" })).or_default();
    loss[3] += 1;
    let allows = |store: &mut Under<W, E>, histories: &Histories, loss: &mut [usize; 4]| {
        for (kind, history) in [RecordKind::Factory, RecordKind::State].into_iter().zip(histories) {
            let before = usize::from(kind == RecordKind::State);
            let fine = load(store, kind).is_ok_and(|found| history.allows(found.as_ref(), before));
            loss[index(kind)] += usize::from(!fine);
        }
    };
    allows(&mut store, &histories, loss);
    let step = save(RecordKind::State, 300, bytes.1);
    loss[2] += usize::from(!perform(&mut store, &step));
}

/// Single defects, and every pair of them; with losses of power and without.
fn all_defects(seeds: core::ops::Range<u64>) -> Losses {
    let mut losses = Losses::new();
    let pairs =
        DEFECTS.iter().enumerate().flat_map(|(i, a)| DEFECTS[i..].iter().map(move |b| [*a, *b]));
    for defects in pairs {
        let defects = if defects[0] == defects[1] { &defects[..1] } else { &defects[..] };
        if is_campaign() {
            println!("{defects:?}");
        }
        every_size(defects, seeds.clone(), &mut losses);
    }
    losses
}

/// With losses of power and without.
fn every_size(defects: &[Defect], seeds: impl IntoIterator<Item = u64>, losses: &mut Losses) {
    for (seed, cuts) in seeds.into_iter().flat_map(|seed| [(seed, false), (seed, true)]) {
        run::<1, 224>(defects, seed, cuts, losses);
        run::<4, 256>(defects, seed, cuts, losses);
        run::<8, 512>(defects, seed, cuts, losses);
        run::<32, 1024>(defects, seed, cuts, losses);
        run::<64, 1536>(defects, seed, cuts, losses);
    }
}

#[test]
fn faults_of_two_kinds_at_once_lose_no_record() {
    if is_campaign() {
        report(&all_defects(SEEDS..SEEDS + MANY_SEEDS), 1);
    } else {
        report(&all_defects(0..SEEDS), 0);
    }
}

/// Two pages: while one is erased the other falls silent, over a restart, and then answers again.
#[test]
fn a_page_that_falls_silent_while_the_other_is_erased_keeps_its_records() {
    let mut losses = Losses::new();
    for defect in DEFECTS {
        every_size(&[defect], [12, 61, 71, 136, 143, 154, 162, 173], &mut losses);
    }
    report(&losses, 0);
}

/// Prints the losses: no record may be lost, nor a save be impossible later, but by wrong bits in reads.
///
/// * `stuck`: saves that may be impossible after wrong bits, of 1000.
fn report(losses: &Losses, stuck: usize) {
    let mut sums = [[0; 4]; 2];
    for (defects, loss) in losses {
        let [factory, state, stuck, runs] = loss;
        println!(
            "{defects}: {factory} factory records, {state} states, {stuck} saves lost of {runs}"
        );
        let sum = &mut sums[usize::from(defects.contains("Flips"))];
        sum.iter_mut().zip(loss).for_each(|(sum, n)| *sum += n);
    }
    println!(
        "factory records, states, saves lost, runs: {:?}; with wrong bits {:?}",
        sums[0], sums[1]
    );
    let [exact, flipped] = sums;
    assert_eq!(exact[..3], [0; 3], "{losses:?}");
    assert_eq!(flipped[..2], [0; 2], "{losses:?}");
    assert!(flipped[2] * 1000 <= stuck * flipped[3], "{losses:?}");
}
