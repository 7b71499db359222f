//! Cost of the link at a receiver: host time and instructions for each correspondence.
//!
//! ```sh
//! cargo bench -p selfcal-evidence --bench link
//! ```
//!
//! Frames of the scene `near`, their bytes in pieces of a length:
//! - `decode`: the decoder alone, from bytes to correspondences;
//! - `feed`: into the batch of a fresh calibrator of 1024 correspondences, pinhole cameras.
//!
//! Streams that cost more than frames, through the decoder alone, as long as the records of a frame:
//! - `magics`: the magic of a header again and again;
//! - `within`: the same after the header of a long frame;
//! - `headers`: headers with a correct checksum, each of a frame that is cut off.
//!
//! Columns, for each correspondence with its share of header and checksum; for a stream without frames, for each 16
//! bytes, the length of a record:
//! - `ns`: median time on this host;
//! - `instr`: instructions counted by callgrind, the same for the same build; `-` without valgrind.

#[path = "../cost/callgrind.rs"]
mod callgrind;

use std::fmt;
use std::hint::black_box;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Parser;
use host_tests::stats::median;
use host_tests::synth::{ScenarioKind, Scene};
use host_tests::wire::Sender;
use stereo_selfcal::link::{Decoder, Event, FrameHeader, MatchRecord};
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};

/// Frames of each row.
const FRAMES: usize = 50;

const SEED: u64 = 1;

const MAGIC: [u8; 4] = *b"SCMF";

/// Header of a frame longer than any stream here.
const HEADER: FrameHeader = FrameHeader {
    timestamp_us: 0,
    sequence: 1,
    count: u16::MAX,
    image_size: [1920, 1200],
    grid_step: 256,
    fraction_bits: 8,
    pyramid_ratio: 64,
    dropped_before: false,
    more_found: false,
};

type Calibrator1024 = Calibrator<f32, 1024>;

#[derive(Parser)]
struct Args {
    /// Passed by cargo.
    #[arg(long, hide = true)]
    bench: bool,
    /// Receive each frame of this row once only, for callgrind to count.
    #[arg(long, hide = true)]
    row: Option<usize>,
}

/// A row of the table.
#[derive(Debug, Clone, Copy)]
struct Case {
    work: Work,
    matches: usize,
    /// Bytes of a piece.
    piece: usize,
}

#[derive(Debug, Clone, Copy)]
enum Work {
    Decode,
    Feed,
    Magics,
    MagicsWithinFrame,
    Headers,
}

impl fmt::Display for Work {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Decode => "decode",
            Self::Feed => "feed",
            Self::Magics => "magics",
            Self::MagicsWithinFrame => "within",
            Self::Headers => "headers",
        })
    }
}

/// A frame, or a stream without one, ready to be received.
#[derive(Debug, Clone)]
struct Job {
    bytes: Vec<u8>,
    /// Length of a stream without a frame, in records.
    damaged: Option<usize>,
    piece: usize,
    decoder: Decoder,
    calibrator: Option<Box<Calibrator1024>>,
}

impl Case {
    fn all() -> impl Iterator<Item = Self> {
        let works =
            [Work::Decode, Work::Feed, Work::Magics, Work::MagicsWithinFrame, Work::Headers];
        works.into_iter().flat_map(|work| {
            [64, 256].into_iter().flat_map(move |matches| {
                [16, 100, 256, 65_536].map(|piece| Self { work, matches, piece })
            })
        })
    }

    fn jobs(&self) -> Result<Vec<Job>> {
        let header = HEADER.encode()?;
        Ok(match self.work {
            Work::Decode | Work::Feed => self.frames()?,
            Work::Magics => self.damaged(&MAGIC, &MAGIC),
            Work::MagicsWithinFrame => self.damaged(&header, &MAGIC),
            Work::Headers => self.damaged(&header, &header),
        })
    }

    /// A stream as long as the records of a frame.
    fn damaged(&self, first: &[u8], again: &[u8]) -> Vec<Job> {
        let bytes = first.iter().chain(again.iter().cycle()).copied();
        let bytes = bytes.take(self.matches * MatchRecord::BYTES).collect();
        let (piece, damaged) = (self.piece, Some(self.matches));
        let job = Job { bytes, damaged, piece, decoder: Decoder::new(), calibrator: None };
        vec![job; FRAMES]
    }

    fn frames(&self) -> Result<Vec<Job>> {
        let scene = Scene { matches: self.matches, ..ScenarioKind::Near.scene() };
        scene.check()?;
        let sender = Sender::new(scene.size, [0.0])?;
        let calibrator = match self.work {
            Work::Feed => {
                let factory = FactoryCalibration::guess(scene.dataset(0, SEED)?.cameras()?);
                Some(Box::new(Calibrator1024::new(Config::robust(), &factory)))
            }
            _ => None,
        };
        let frames = (0..).zip(scene.pairs(SEED).take(FRAMES));
        Ok(frames
            .map(|(sequence, pair)| Job {
                bytes: sender.frame(sequence, &pair.matches).0,
                damaged: None,
                piece: self.piece,
                decoder: Decoder::new(),
                calibrator: calibrator.clone(),
            })
            .collect())
    }
}

impl Job {
    /// The measured work: the correspondences of the frame if it is whole, or the length of a stream without a frame.
    fn run(self) -> Option<usize> {
        let Self { bytes, damaged, piece, mut decoder, mut calibrator } = self;
        let mut whole = damaged;
        for mut piece in bytes.chunks(piece) {
            if let Some(calibrator) = &mut calibrator {
                while let Ok(Some(received)) = decoder.feed(&mut piece, &mut **calibrator) {
                    whole = Some(received.taken);
                }
            } else {
                while let Some(event) = decoder.next(&mut piece) {
                    if let Event::Finished(header) = black_box(event) {
                        whole = Some(header.count.into());
                    }
                }
            }
        }
        whole
    }
}

fn main() -> Result<()> {
    let args = Args::parse();
    if let Some(row) = args.row {
        let case = Case::all().nth(row).context("no such row")?;
        println!("{}", taken(&callgrind::run_once(case.jobs()?, Job::run)?)?);
        return Ok(());
    }
    let counts = callgrind::is_present();
    if !counts {
        println!("valgrind was not found: no instruction counts\n");
    }
    println!("RAM of a decoder: {} bytes\n", size_of::<Decoder>());
    println!("| work   | matches | bytes at once |    ns | instr |");
    println!("|---|--:|--:|--:|--:|");
    for (row, case) in Case::all().enumerate() {
        let Case { work, matches, piece } = case;
        let (correspondences, ns) = timed(&case.jobs()?)?;
        let count = counts.then(|| callgrind::count(row)).transpose()?;
        let same = count.as_ref().is_none_or(|c| c.said == correspondences.to_string());
        ensure!(same, "the counted run took in other matches than the timed one: {case:?}");
        let each = count
            .map_or("-".into(), |c| format!("{:.1}", c.instructions / as_f64(correspondences)));
        println!("| {:6} | {matches:7} | {piece:13} | {ns:5.1} | {each:>5} |", work.to_string());
    }
    Ok(())
}

/// Correspondences of all frames, which must all be whole.
fn taken(answers: &[Option<usize>]) -> Result<usize> {
    answers.iter().copied().sum::<Option<usize>>().context("a frame was lost")
}

/// Correspondences, and the median time of each, ns.
fn timed(jobs: &[Job]) -> Result<(usize, f64)> {
    let mut answers = Vec::new();
    let mut times = Vec::new();
    for job in jobs.iter().cycle().take(20 * jobs.len()) {
        let job = job.clone();
        let start = Instant::now();
        answers.push(black_box(job.run()));
        times.push(start.elapsed().as_secs_f64() * 1e9);
    }
    let correspondences = taken(&answers[..jobs.len()])?;
    let mean = as_f64(correspondences) / as_f64(jobs.len());
    Ok((correspondences, median(times).context("no job")? / mean))
}

fn as_f64(n: usize) -> f64 {
    u32::try_from(n).map_or(f64::INFINITY, f64::from)
}
