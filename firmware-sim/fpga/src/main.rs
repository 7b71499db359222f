//! Calibrates a recorded rig from the pins of the simulated framer, and compares all bits with the replay.

use std::cell::RefCell;
use std::process::ExitCode;
use std::rc::Rc;

use anyhow::{Context, Result, bail, ensure};
use firmware_sim::{App, Event, start};
use fpga_sim::bench::{Bench, Sink};
use fpga_sim::matches::Found;
use fpga_sim::model::Size;
use fpga_sim::spi::{Ready, Spi};
use rigs::data::Dataset;
use sim::wire::Sender;
use stereo_selfcal::Extrinsics;
use stereo_selfcal::link::{FpgaMatcher, FrameHeader, MatchRecord};
use test_support::wire::Wire;

const HELP: &str = "\
Calibrates from the pins of the framer in firmware-sim/fpga/rtl, simulated by Verilator. Matches of a recorded
rig enter as an AXI4-Stream; the driver of the core reads SPI and data-ready. The same frames from a queue of
bytes must give the same bits.

usage: fpga-sim [SET]

  SET     folder of host-tests/data; default: opencv_chess_sift
  --help  this text

output: one line for each pair. exit: 0; 1 if a bit differs; 2 for wrong arguments.
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let set = match arguments.as_slice() {
        [] => "opencv_chess_sift",
        [set] if !set.starts_with('-') => set,
        [option] if option == "--help" || option == "-h" => {
            print!("{HELP}");
            return ExitCode::SUCCESS;
        }
        _ => {
            eprint!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match run(set) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// Calibrates the rig of a set from the pins and from the bytes of the same frames, and compares the results.
///
/// # Errors
/// If the set cannot be read, a frame does not fit or is not received, an estimate is not applied, or a bit differs.
fn run(set: &str) -> Result<()> {
    let set = Dataset::load(&Dataset::shipped().join(set))?;
    let sender = Sender::of(&set)?;
    let [mut by_bytes, mut by_pins] = [(), ()].map(|()| set.cameras().map(|c| Box::new(start(c))));
    let (by_bytes, by_pins) = (by_bytes.as_mut(), by_pins.as_mut());
    let (Ok(by_bytes), Ok(by_pins)) = (by_bytes, by_pins) else {
        bail!("the cameras are not valid")
    };

    let wire = Wire::default();
    let mut replayed = App::new(FpgaMatcher::new(wire.clone(), wire.clone()), by_bytes);
    let bench = Rc::new(RefCell::new(Bench::new(Size::Large, Sink::Spi)));
    let driver = FpgaMatcher::new(Spi(Rc::clone(&bench)), Ready(Rc::clone(&bench)));
    let mut simulated = App::new(driver, by_pins);

    for (sequence, pair) in (0..).zip(&set.pairs) {
        let frame = sender.frame(sequence, pair).0;
        let found = found(&frame)?;
        wire.send(frame);
        ensure!(found.records.len() <= Size::Large.matches(), "pair {sequence} does not fit");
        bench.borrow_mut().beats.extend(found.beats());
        let a = outcome(|| Ok(replayed.poll()?))?;
        let b = outcome(|| Ok(simulated.poll()?))?;
        ensure!(a == b, "pair {sequence}: {a:?} by replay, {b:?} by the pins");
        let estimates = [replayed.calibrator().proposal(), simulated.calibrator().proposal()];
        let [a, b] = estimates.map(|p| p.map(|p| bits(&p.extrinsics)));
        ensure!(a == b, "pair {sequence}: the estimates differ");
        println!(
            "pair {:2} of {}: {} matches, same bits",
            sequence + 1,
            set.pairs.len(),
            pair.len()
        );
    }
    let [a, b] = [replayed.apply(), simulated.apply()];
    let (a, b) = (a.context("not applied by replay")?, b.context("not applied by the pins")?);
    ensure!(bits(&a.extrinsics) == bits(&b.extrinsics), "the calibrations differ");
    println!("applied: same bits as the replay; {}", b.extrinsics);
    Ok(())
}

/// Splits the bytes of a frame into its header and its records.
fn found(bytes: &[u8]) -> Result<Found> {
    let (header, rest) = bytes.split_first_chunk().context("a header")?;
    let header = FrameHeader::decode(header)?;
    let (records, _) = rest.as_chunks::<{ MatchRecord::BYTES }>();
    Ok(Found { header, records: records[..header.count.into()].to_vec() })
}

/// Polls until the end of the pair.
fn outcome(mut poll: impl FnMut() -> Result<Event>) -> Result<Event> {
    for _ in 0..10_000 {
        let event = poll()?;
        if matches!(event, Event::Pair(_)) {
            return Ok(event);
        }
    }
    bail!("no frame arrives")
}

fn bits(extrinsics: &Extrinsics<f32>) -> Vec<u32> {
    let t = extrinsics.translation().into_inner();
    extrinsics.rotation_row_major().iter().chain(t.iter()).map(|x| x.to_bits()).collect()
}
