//! Processor in the loop: each pair on this computer and on an emulated controller, compared bit for bit.

mod compare;
mod image;
mod line;
mod session;
mod table;

use std::io::{Read, Write};
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, ensure};
use firmware_sim::pil::{EndReply, PairReply, SessionRequest};
use firmware_sim::{App, CAPACITY};
use rigs::data::Dataset;
use sim::run::progress;
use sim::wire::Sender;

use super::args::PilArgs;
use super::polling::{driver, poll_pair};
use compare::{Difference, differences};
use emulator::Emulator;
use line::Listener;
use session::Session;
use table::Table;
use test_support::wire::Wire;

/// Time for the firmware to end after an error of the session.
const EXIT_TIMEOUT: Duration = Duration::from_secs(1);

/// Appended to errors of the firmware.
const HINT: &str = if cfg!(feature = "logs") { "" } else { " (--features logs shows its log)" };

/// Replays a data set on this computer and on the emulated controller.
///
/// # Errors
/// If a pair differs, the controller does not reply, or QEMU, the image or the data set is missing.
pub(super) fn run(args: &PilArgs, out: &mut impl Write) -> Result<()> {
    let set = args.dataset()?;
    let request = SessionRequest { pairs: set.pairs.len().try_into()?, cameras: set.cameras()? };
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
    let comparison = compare_pairs(&set, line, &request, out)
        .map_err(|error| explained(error, &mut emulator))?;
    let status = emulator.wait(args.timeout)?;
    ensure!(status.success(), "the firmware ended with {status}");
    writeln!(out, "\n{} of {} pairs are bit-identical", comparison.identical, set.pairs.len())?;
    let others = set.pairs.len() - comparison.identical;
    ensure!(others == 0, "the controller computes other results for {others} pairs");
    ensure!(
        comparison.end.is_empty(),
        "the extrinsics in use at the end differ: {}",
        comparison.end[0]
    );
    writeln!(out, "so are the extrinsics in use at the end: {}", comparison.applied)?;
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

/// Adds the exit status of the firmware to an error, if it has ended.
fn explained(error: anyhow::Error, emulator: &mut Emulator) -> anyhow::Error {
    match emulator.wait(EXIT_TIMEOUT) {
        Ok(status) => error.context(format!("the firmware ended with {status}{HINT}")),
        Err(_) => error,
    }
}

/// Result of a session.
struct Comparison {
    /// Number of bit-identical pairs.
    identical: usize,
    /// Differences at the end.
    end: Vec<Difference>,
    /// Result of applying the estimate.
    applied: String,
}

/// Runs a session: solves each pair on both sides and compares the results.
///
/// # Errors
/// If the line, a reply or the output fails, or the controller has another capacity.
fn compare_pairs<L: Read + Write>(
    set: &Dataset,
    line: L,
    request: &SessionRequest,
    out: &mut impl Write,
) -> Result<Comparison> {
    let mut session = Session::open(line, request)?;
    ensure!(
        usize::from(session.capacity) == CAPACITY,
        "the batch of the controller holds {} matches, that of this program {CAPACITY}",
        session.capacity
    );
    let mut calibrator = Box::new(firmware_sim::start(request.cameras));
    let sender = Sender::of(set)?;
    let wire = Wire::default();
    let mut app = App::new(driver(&wire), &mut calibrator);
    let mut table = Table::new(set, app.calibrator())?;
    let mut identical = 0;
    let bar = progress::over(set.pairs.len(), "pairs");
    Table::heading(out)?;
    for (sequence, pair) in (0_u32..).zip(&set.pairs) {
        let frame = sender.frame(sequence, pair).0;
        wire.send(frame.iter().copied());
        let processed = poll_pair(&mut app)?;
        let here = PairReply::new(sequence, processed.taken, &processed.pair, app.calibrator());
        let there = session.pair(sequence, &frame);
        let there = there.with_context(|| format!("pair {sequence}"))?;
        let found = differences(&here.fields(), &there.fields());
        identical += usize::from(found.is_empty());
        bar.suspend(|| table.row(out, pair.len(), &processed, app.calibrator(), &found))?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    let applied = app.apply();
    let here = EndReply::new(applied.err(), app.calibrator());
    let there = session.end()?;
    let end = differences(&here.fields(), &there.fields());
    let applied = match applied {
        Ok(_) => format!("applied, generation {}", app.calibrator().in_use().generation),
        Err(why) => format!("not applied, {why}"),
    };
    Ok(Comparison { identical, end, applied })
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal::digital::{self, InputPin};
    use embedded_hal::spi::{self, Operation, SpiDevice};
    use firmware_sim::pil::run_session;
    use std::convert::Infallible;
    use std::net::{TcpListener, TcpStream};
    use std::thread;

    /// The controller's end of a line on a host. Data-ready is always high, because a read waits for its bytes.
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

    /// Runs a session with the firmware in a thread.
    ///
    /// * `tamper`: changes the bytes of a reply, which it gets with its number.
    fn run_set(name: &str, tamper: fn(usize, &mut [u8])) -> (Result<Comparison>, String, bool) {
        let set = Dataset::load(&Dataset::shipped().join(name)).unwrap();
        let request = SessionRequest {
            pairs: set.pairs.len().try_into().unwrap(),
            cameras: set.cameras().unwrap(),
        };
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let line = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        line.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let controller = thread::spawn(move || {
            let (line, _) = listener.accept().unwrap();
            let mut replies = 0;
            let send = |bytes: &[u8]| {
                let mut bytes = bytes.to_vec();
                tamper(replies, &mut bytes);
                replies += 1;
                let _ = (&line).write_all(&bytes);
            };
            let start = |cameras| Box::leak(Box::new(firmware_sim::start(cameras)));
            run_session(start, HostLink(&line), HostLink(&line), send).is_ok()
        });
        let mut out = Vec::new();
        let comparison = compare_pairs(&set, line, &request, &mut out);
        (comparison, String::from_utf8(out).unwrap(), controller.join().unwrap())
    }

    #[test]
    fn the_firmware_in_a_thread_is_bit_identical_for_each_pair_and_at_the_end() {
        let (comparison, table, completed) = run_set("opencv_chess_corners", |_, _| ());
        let comparison = comparison.unwrap();
        assert_eq!(
            (comparison.identical, comparison.end.len(), completed),
            (13, 0, true),
            "{table}"
        );
        assert_eq!(comparison.applied, "applied, generation 1");
        assert_eq!(table.matches(" same ").count(), 13, "{table}");
    }

    #[test]
    fn the_same_matches_of_a_set_beyond_capacity_are_selected() {
        let (comparison, table, _) = run_set("aloe_sift", |_, _| ());
        assert_eq!(comparison.unwrap().identical, 1, "{table}");
        assert!(table.contains("not taken"), "{table}");
    }

    #[test]
    fn one_bit_of_one_reply_is_found_and_its_field_named() {
        let last_bit_of_the_pairs_r = |reply: usize, bytes: &mut [u8]| {
            if reply == 3 {
                bytes[14] ^= 1;
            }
        };
        let (comparison, table, _) = run_set("opencv_chess_corners", last_bit_of_the_pairs_r);
        assert_eq!(comparison.unwrap().identical, 12, "{table}");
        assert!(table.contains("   2 DIFFER"), "{table}");
        assert!(table.contains("R, t of the pair: "), "{table}");
    }

    #[test]
    fn a_difference_at_the_end_is_found() {
        let generation = |reply: usize, bytes: &mut [u8]| {
            if reply == 14 {
                bytes[4] ^= 1;
            }
        };
        let (comparison, _, _) = run_set("opencv_chess_corners", generation);
        assert_eq!(comparison.unwrap().end.len(), 1);
    }

    #[test]
    fn an_invalid_reply_ends_the_session_with_the_number_of_the_pair() {
        let garbage = |reply: usize, bytes: &mut [u8]| {
            if reply == 3 {
                bytes[0] = 0;
            }
        };
        let (comparison, _, completed) = run_set("opencv_chess_corners", garbage);
        let error = format!("{:#}", comparison.err().unwrap());
        assert!(error.starts_with("pair 2: the controller sent something else"), "{error}");
        assert!(!completed, "the firmware sees the closed line");
    }
}
