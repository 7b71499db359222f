//! Processor in the loop: every pair here and on an emulated controller, compared bit for bit.

mod compare;
mod exchange;
mod image;
mod line;
mod table;

use std::io::{Read, Write};
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use firmware_sim::pil::{EndAnswer, Opening, PairAnswer};
use firmware_sim::{App, CAPACITY};
use host_tests::data::Dataset;
use host_tests::run::progress;
use host_tests::wire::{Sender, SimMatcher};

use super::args::PilArgs;
use super::drive::drive;
use super::emulator::Emulator;
use compare::{Difference, differences};
use exchange::Exchange;
use line::Listener;
use table::Table;

/// How long a firmware that hung up may take to end.
const LAST_WORDS: Duration = Duration::from_secs(1);

/// What is said where there is more to know.
const HINT: &str = if cfg!(feature = "logs") { "" } else { " (--features logs shows its log)" };

/// Plays a data set here and on the emulated controller.
///
/// # Errors
/// If a pair differs, the controller does not answer, or QEMU, the image or the data set is not there.
pub(super) fn run(args: &PilArgs, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let opening = Opening { pairs: set.pairs.len().try_into()?, cameras: set.cameras()? };
    let built;
    let image: &Path = if let Some(image) = &args.image {
        image
    } else {
        built = image::build(args.machine)?;
        &built
    };
    heading(out, &set, args)?;
    let listener = Listener::open()?;
    let mut emulator = Emulator::start(args.machine, image, &listener.serial()?)?;
    let line = listener.accept(&mut emulator, args.timeout)?;
    let tally = hold(&set, line, &opening, out).map_err(|error| explained(error, &mut emulator))?;
    let status = emulator.wait(args.timeout)?;
    ensure!(status.success(), "the firmware ended with {status}");
    writeln!(out, "\n{} of {} pairs are the same in all bits", tally.same, set.pairs.len())?;
    let others = set.pairs.len() - tally.same;
    ensure!(others == 0, "the controller computes something else of {others} pairs");
    ensure!(tally.end.is_empty(), "what is in use at the end differs: {}", tally.end[0]);
    writeln!(out, "so is what is in use at the end: {}", tally.applied)?;
    Ok(())
}

fn heading(out: &mut impl Write, set: &Dataset, args: &PilArgs) -> Result<()> {
    let matches: usize = set.pairs.iter().map(Vec::len).sum();
    writeln!(
        out,
        "Processor in the loop: recorded matches over a UART into the emulated controller"
    )?;
    writeln!(out, "data set   {}: {} pairs, {matches} matches", set.name, set.pairs.len())?;
    writeln!(out, "machine    {} ({})", args.machine.name(), args.machine.cpu())?;
    writeln!(out, "errors     in degrees, against R, t of the data set\n")?;
    Ok(())
}

/// The error, and how the firmware ended if it did.
fn explained(error: anyhow::Error, emulator: &mut Emulator) -> anyhow::Error {
    match emulator.wait(LAST_WORDS) {
        Ok(status) => error.context(format!("the firmware ended with {status}{HINT}")),
        Err(_) => error,
    }
}

/// What an exchange came to.
struct Tally {
    /// Pairs that are the same.
    same: usize,
    /// What differs at the end.
    end: Vec<Difference>,
    /// What applying the estimate came to.
    applied: String,
}

/// Holds an exchange: each pair here, there, and compared.
///
/// # Errors
/// If the line or an answer fails, or the output does.
fn hold<L: Read + Write>(
    set: &Dataset,
    line: L,
    opening: &Opening,
    out: &mut impl Write,
) -> Result<Tally> {
    let mut exchange = Exchange::open(line, opening)?;
    ensure!(
        usize::from(exchange.capacity) == CAPACITY,
        "the controller has room for {} matches a pair, this program for {CAPACITY}",
        exchange.capacity
    );
    let mut calibrator = Box::new(firmware_sim::start(opening.cameras));
    let sender = Sender::of(set)?;
    let matcher = SimMatcher::new(sender);
    let mut app = App::new(matcher.driver(), &mut calibrator);
    let mut table = Table::new(set, app.calibrator())?;
    let mut same = 0;
    let bar = progress::over(set.pairs.len(), "pairs");
    Table::heading(out)?;
    for (sequence, pair) in (0_u32..).zip(&set.pairs) {
        matcher.send(sequence, pair);
        let driven = drive(&mut app)?;
        let here = PairAnswer::new(sequence, driven.taken, &driven.pair, app.calibrator());
        let there = exchange.pair(sequence, &sender.frame(sequence, pair).0);
        let there = there.with_context(|| format!("pair {sequence}"))?;
        let found = differences(&here.parts(), &there.parts());
        same += usize::from(found.is_empty());
        bar.suspend(|| table.row(out, pair.len(), &driven, app.calibrator(), &found))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let applied = app.apply();
    let here = EndAnswer::new(applied.err(), app.calibrator());
    let there = exchange.end()?;
    let end = differences(&here.parts(), &there.parts());
    let applied = match applied {
        Ok(_) => format!("applied, generation {}", app.calibrator().generation()),
        Err(why) => format!("not applied, {why}"),
    };
    Ok(Tally { same, end, applied })
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::digital::{self, InputPin};
    use embedded_hal::spi::{self, Operation, SpiDevice};
    use firmware_sim::pil::serve;
    use std::convert::Infallible;
    use std::net::{TcpListener, TcpStream};
    use std::thread;

    /// The controller's end of a line on a host; data-ready is left to the reads, which wait.
    struct HostLink<'a>(&'a TcpStream);

    #[derive(Debug)]
    struct Gone;

    impl spi::Error for Gone {
        fn kind(&self) -> spi::ErrorKind {
            spi::ErrorKind::Other
        }
    }

    impl spi::ErrorType for HostLink<'_> {
        type Error = Gone;
    }

    impl SpiDevice for HostLink<'_> {
        fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Gone> {
            for operation in operations {
                let Operation::Read(buffer) = operation else { panic!("the driver only reads") };
                self.0.read_exact(buffer).map_err(|_| Gone)?;
            }
            Ok(())
        }
    }

    impl digital::ErrorType for HostLink<'_> {
        type Error = Infallible;
    }

    impl InputPin for HostLink<'_> {
        fn is_high(&mut self) -> Result<bool, Infallible> {
            Ok(true)
        }

        fn is_low(&mut self) -> Result<bool, Infallible> {
            Ok(false)
        }
    }

    /// An exchange with the firmware in a thread.
    ///
    /// * `tamper`: what becomes of an answer on its way.
    fn exchange(name: &str, tamper: fn(usize, &mut [u8])) -> (Result<Tally>, String, bool) {
        let set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
        let opening =
            Opening { pairs: set.pairs.len().try_into().unwrap(), cameras: set.cameras().unwrap() };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let line = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        line.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let controller = thread::spawn(move || {
            let (line, _) = listener.accept().unwrap();
            let mut answers = 0;
            let send = |bytes: &[u8]| {
                let mut bytes = bytes.to_vec();
                tamper(answers, &mut bytes);
                answers += 1;
                let _ = (&line).write_all(&bytes);
            };
            serve(HostLink(&line), HostLink(&line), send).is_ok()
        });
        let mut out = Vec::new();
        let tally = hold(&set, line, &opening, &mut out);
        (tally, String::from_utf8(out).unwrap(), controller.join().unwrap())
    }

    #[test]
    fn the_firmware_in_a_thread_is_the_same_pair_by_pair_and_at_the_end() {
        let (tally, table, served) = exchange("opencv_chess_corners", |_, _| ());
        let tally = tally.unwrap();
        assert_eq!((tally.same, tally.end.len(), served), (13, 0, true), "{table}");
        assert_eq!(tally.applied, "applied, generation 1");
        assert_eq!(table.matches(" same ").count(), 13, "{table}");
    }

    #[test]
    fn a_set_beyond_capacity_is_selected_from_alike() {
        let (tally, table, _) = exchange("aloe_sift", |_, _| ());
        assert_eq!(tally.unwrap().same, 1, "{table}");
        assert!(table.contains("not taken"), "{table}");
    }

    #[test]
    fn one_bit_of_one_answer_is_found_and_named() {
        let last_bit_of_the_pairs_r = |answer: usize, bytes: &mut [u8]| {
            if answer == 3 {
                bytes[14] ^= 1;
            }
        };
        let (tally, table, _) = exchange("opencv_chess_corners", last_bit_of_the_pairs_r);
        assert_eq!(tally.unwrap().same, 12, "{table}");
        assert!(table.contains("   2 DIFFER"), "{table}");
        assert!(table.contains("R, t of the pair: "), "{table}");
    }

    #[test]
    fn a_difference_at_the_end_is_found() {
        let generation = |answer: usize, bytes: &mut [u8]| {
            if answer == 14 {
                bytes[4] ^= 1;
            }
        };
        let (tally, _, _) = exchange("opencv_chess_corners", generation);
        assert_eq!(tally.unwrap().end.len(), 1);
    }

    #[test]
    fn an_answer_that_is_none_ends_the_exchange_with_the_number_of_the_pair() {
        let garbage = |answer: usize, bytes: &mut [u8]| {
            if answer == 3 {
                bytes[0] = 0;
            }
        };
        let (tally, _, served) = exchange("opencv_chess_corners", garbage);
        let error = format!("{:#}", tally.err().unwrap());
        assert!(error.starts_with("pair 2: the controller sent something else"), "{error}");
        assert!(!served, "the firmware sees the line closed");
    }
}
