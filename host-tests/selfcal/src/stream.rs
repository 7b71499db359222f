//! Matches that arrive pair by pair: from a file, or from standard input.

use std::cell::Cell;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, IsTerminal, Read};
use std::path::Path;
use std::rc::Rc;

use anyhow::{Context, Result, ensure};
use indicatif::ProgressBar;
use rigs::data::{Dataset, FrameRows, LONGEST_LINE, Match, Meta, Turn};
use sim::run::progress;
use sim::wire::{FrameReader, counted};

/// Pairs in order of arrival.
type Pairs = Box<dyn Iterator<Item = Result<Vec<Match>>>>;

/// Time of the last pair on the sender's clock, us; `None` for a recording without times.
pub(crate) type Clock = Rc<Cell<Option<u64>>>;

/// A recording whose pairs arrive one by one.
pub(crate) struct Streamed {
    /// Name of its source.
    pub(crate) name: String,
    /// The rig.
    pub(crate) meta: Meta,
    /// The pairs.
    pub(crate) pairs: Pairs,
    /// Progress of the reading.
    pub(crate) bar: ProgressBar,
    /// The clock of its sender.
    pub(crate) clock: Clock,
}

impl Streamed {
    /// Opens a file, or standard input for `-`: CSV where its first line is text, otherwise frames.
    pub(crate) fn open(place: &Path, meta: Meta) -> Result<Self> {
        let (name, source, bar) = source(place)?;
        let mut source = BufReader::new(source);
        let start = start(&mut source).with_context(|| format!("cannot read {name}"))?;
        ensure!(!start.is_empty(), "{name} is empty: there are no matches");
        let (rows, clock) = (is_text(&start), Clock::default());
        let input = Cursor::new(start).chain(source);
        let pairs: Pairs = if rows {
            let read = FrameRows::open(input).with_context(|| format!("cannot read {name}"))?;
            let named = name.clone();
            Box::new(read.map(move |pair| pair.with_context(|| format!("cannot read {named}"))))
        } else {
            let (reader, rig, name) = (FrameReader::new(input), meta.clone(), name.clone());
            let (bar, clock) = (bar.clone(), Rc::clone(&clock));
            Box::new(Frames { reader, rig, name, bar, clock, ended: false })
        };
        let counter = bar.clone();
        let pairs = Box::new(pairs.inspect(move |_| {
            // A bar of known length counts bytes.
            if counter.length().is_none() {
                counter.inc(1);
            }
        }));
        Ok(Self { name, meta, pairs, bar, clock })
    }

    /// The recording with one or both views turned.
    pub(crate) fn turned(self, turn: Turn) -> Self {
        let (name, meta) = (turn.name(&self.name), turn.meta(&self.meta));
        let pairs = Box::new(self.pairs.map(move |pair| Ok(turn.pair(&pair?))));
        Self { name, meta, pairs, ..self }
    }

    /// Reads all pairs into a data set.
    pub(crate) fn collect(self) -> Result<Dataset> {
        let pairs = self.pairs.collect::<Result<_>>()?;
        self.bar.finish_and_clear();
        Ok(Dataset { name: self.name, meta: self.meta, pairs, rigs: Vec::new() })
    }
}

/// Name, bytes, and a progress bar over the bytes, or over the pairs if the length is unknown.
fn source(place: &Path) -> Result<(String, Box<dyn Read>, ProgressBar)> {
    let pairs = || progress::counting("pairs");
    if place == Path::new("-") {
        let here = "standard input";
        ensure!(!io::stdin().is_terminal(), "{here} is a terminal: send a recording into it");
        return Ok((here.into(), Box::new(io::stdin()), pairs()));
    }
    let name = place.display().to_string();
    let file = File::open(place).with_context(|| format!("cannot read {name}"))?;
    let length = file.metadata().map_or(0, |about| about.len());
    if length == 0 {
        return Ok((name, Box::new(file), pairs()));
    }
    let bar = progress::over(usize::try_from(length)?, "bytes");
    Ok((name, Box::new(bar.wrap_read(file)), bar))
}

/// Reads up to the end of the first line, the first byte that is not text, or [`LONGEST_LINE`] bytes.
fn start(source: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut start = Vec::new();
    while start.len() < LONGEST_LINE && is_text(&start) && !start.contains(&b'\n') {
        let bytes = source.fill_buf()?;
        let Some(&byte) = bytes.first() else { break };
        start.push(byte);
        source.consume(1);
    }
    Ok(start)
}

/// Whether bytes are text so far: the last character may be cut off.
fn is_text(bytes: &[u8]) -> bool {
    let control = |byte: &u8| byte.is_ascii_control() && !b"\t\r\n".contains(byte);
    let cut_off = |why: std::str::Utf8Error| why.error_len().is_none();
    !bytes.iter().any(control) && std::str::from_utf8(bytes).err().is_none_or(cut_off)
}

/// The pairs of a stream of frames. At the end its counters are printed; a stream without a whole frame is an error.
struct Frames<R> {
    reader: FrameReader<R>,
    rig: Meta,
    name: String,
    bar: ProgressBar,
    clock: Clock,
    ended: bool,
}

impl<R: BufRead> Iterator for Frames<R> {
    type Item = Result<Vec<Match>>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let Self { reader, rig, name, bar, clock, ended } = self;
        if let Some(frame) = reader.next() {
            let frame = frame.with_context(|| format!("cannot read {name}"));
            let pair = frame.and_then(|frame| {
                clock.set(Some(frame.header.timestamp_us));
                frame.pair(rig)
            });
            *ended = pair.is_err();
            return Some(pair);
        }
        *ended = true;
        let counters = reader.counters();
        bar.suspend(|| eprintln!("{name}: {}", counted(counters)));
        (counters.good == 0).then(|| Err(anyhow::anyhow!("not one whole frame in {name}")))
    }
}
