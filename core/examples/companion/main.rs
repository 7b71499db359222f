//! Calibrator for a Linux companion computer. It reads matches as lines from standard input, and writes the outcome and
//! the verdict after each pair, and the extrinsics in use when they change. With `--udp` or `--device` it reads frames of a
//! matcher instead, and writes a JSON line for each frame.
//!
//! ```sh
//! matcher | cargo run -p stereo-selfcal --example companion -- --focal 1400 --principal 959.5,599.5 --size 1920x1200
//! ```

mod frames;
mod options;

use core::error::Error;
use std::io::{self, BufRead, IsTerminal, Write};
use std::process::ExitCode;

use stereo_selfcal::{
    ApplyError, Calibration, Calibrator, Cameras, Config, Correspondence, Extrinsics,
    FactoryCalibration,
};

use frames::Wire;
use options::{Options, number};

const HELP: &str = "\
Calibrates the extrinsics of a stereo rig from matches on standard input.

usage: companion --focal PX --principal U,V --size WxH [options] < matches
       companion ... --udp ADDRESS:PORT | --device PATH

  --focal PX[,PX]        focal length, or fx,fy
  --principal U,V        principal point, px
  --size WxH             image size, px
  --distortion K1,K2,P1,P2,K3
                         radial-tangential lens, in OpenCV's order; default: none
  --rotation R11,...,R33 factory R row by row, p_r = R p_l + t; default: identity
  --translation X,Y,Z    factory t, any unit; default: -1,0,0
  --udp ADDRESS:PORT     receives frames (core/src/link/FORMAT.md) in datagrams; 0.0.0.0:5600: from anywhere
  --device PATH          reads frames from a device or file; `stty -F PATH raw 1500000` sets a serial line
  --help                 this text

An option holds for both cameras; --left-focal, --right-focal and so on for one of them.

input:  one match a line: FRAME U_L V_L U_R V_R [SCORE], px before undistortion, score 0 to 1.
        FRAME is any word; a line with another FRAME ends the pair. Lines with # are comments.
output: one line for each pair, `pair FRAME OUTCOME` and the verdict on the calibration, and
        `in_use GENERATION R11 ... R33 TX TY TZ` whenever the extrinsics in use change.
        Lines that cannot be read are named on standard error and skipped.
        With frames, one JSON object for each whole frame, with the counters of the link.
exit:   0; 1 if no estimate was ever applied; 2 for wrong options.
";

/// Correspondences that a batch holds; from a larger frame the batch selects.
const CAPACITY: usize = 512;

type Rig = Calibrator<f32, CAPACITY>;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.iter().any(|a| a == "--help" || a == "-h") {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let mut rig = match set_up(&arguments) {
        Ok(rig) => rig,
        Err(error) => {
            eprintln!("companion: {error}\nTry --help.");
            return ExitCode::from(2);
        }
    };
    let wire = Options::read(&arguments).map_err(io::Error::other).and_then(|o| Wire::open(&o));
    let result = match wire {
        Ok(Some(mut wire)) => frames::run(&mut rig, &mut wire, &mut io::stdout().lock()),
        Ok(None) => {
            if io::stdin().is_terminal() {
                eprintln!(
                    "companion: reading matches from the terminal; --help names their format"
                );
            }
            run(&mut rig, io::stdin().lock(), &mut io::stdout().lock())
        }
        Err(error) => {
            eprintln!("companion: {error}\nTry --help.");
            return ExitCode::from(2);
        }
    };
    match result {
        Ok(()) if rig.in_use().generation > 0 => ExitCode::SUCCESS,
        Ok(()) => {
            eprintln!("companion: the input ended before an estimate was applied");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("companion: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The calibrator with the rig of the options.
fn set_up(arguments: &[String]) -> Result<Rig, Box<dyn Error>> {
    let options = Options::read(arguments)?;
    let cameras = Cameras { left: options.camera("left")?, right: options.camera("right")? };
    // Without extrinsics the cameras are side by side: a guess, whose yaw is not held.
    let factory = match (options.get("rotation")?, options.get("translation")?) {
        (None, None) => FactoryCalibration::guess(cameras),
        (r, t) => {
            let r = r.unwrap_or([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
            let t = t.unwrap_or([-1.0, 0.0, 0.0]);
            FactoryCalibration::new(cameras, Extrinsics::from_row_major(r, t)?)
        }
    };
    Ok(Rig::new(Config::robust(), &factory))
}

/// Reads matches to the end of the input; a pair ends where the frame changes.
fn run(rig: &mut Rig, input: impl BufRead, out: &mut impl Write) -> io::Result<()> {
    let mut frame = None;
    for (number, line) in (1_u64..).zip(input.lines()) {
        let line = line?;
        let text = line.split('#').next().unwrap_or_default().trim();
        if text.is_empty() {
            continue;
        }
        let (name, m) = match parse(text) {
            Ok(found) => found,
            Err(error) => {
                eprintln!("companion: line {number} skipped: {error}");
                continue;
            }
        };
        if frame.as_deref().is_some_and(|frame| frame != name) {
            end_pair(rig, frame.as_deref().unwrap_or_default(), out)?;
        }
        frame = Some(name.to_owned());
        if let Err(error) = rig.push(&m) {
            eprintln!("companion: line {number} skipped: {error}");
        }
    }
    frame.map_or(Ok(()), |frame| end_pair(rig, &frame, out))
}

/// `FRAME U_L V_L U_R V_R [SCORE]`.
fn parse(text: &str) -> Result<(&str, Correspondence<f32>), String> {
    let mut words = text.split_whitespace();
    let frame = words.next().ok_or("no frame")?;
    let numbers = words.map(number).collect::<Result<Vec<f32>, String>>()?;
    let (u_l, v_l, u_r, v_r, score) = match *numbers.as_slice() {
        [u_l, v_l, u_r, v_r] => (u_l, v_l, u_r, v_r, 1.0),
        [u_l, v_l, u_r, v_r, score] => (u_l, v_l, u_r, v_r, score),
        _ => return Err(format!("{} numbers after the frame, 4 or 5 expected", numbers.len())),
    };
    let m = Correspondence { left: [u_l, v_l], right: [u_r, v_r], score, grid_step: 0.0 };
    Ok((frame, m))
}

/// Takes the pair, reports and applies.
fn end_pair(rig: &mut Rig, frame: &str, out: &mut impl Write) -> io::Result<()> {
    write!(out, "pair {frame} {}", rig.solve_pair())?;
    writeln!(out, ": {}, {}", rig.state(), rig.verdict())?;
    let generation = rig.in_use().generation;
    match rig.apply() {
        Ok(Calibration { extrinsics, generation: now, .. }) if now != generation => {
            write!(out, "in_use {now}")?;
            for x in extrinsics.rotation_row_major().iter().chain(extrinsics.translation().iter()) {
                write!(out, " {x}")?;
            }
            writeln!(out)?;
        }
        Ok(_) | Err(ApplyError::NoProposal | ApplyError::NotLocked(_)) => {}
        Err(error) => eprintln!("companion: not applied: {error}"),
    }
    out.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::fmt::Write as _;

    const RIG: [&str; 6] = ["--focal", "1400", "--principal", "960,600", "--size", "1920x1200"];

    fn refused(options: &[&str]) -> String {
        set_up(&options.iter().map(ToString::to_string).collect::<Vec<_>>())
            .unwrap_err()
            .to_string()
    }

    /// Six frames of a side-by-side rig, with noise.
    fn lines() -> String {
        let mut text = String::from("# comment\n\nf0 1 2 3\nf0 what 2 3 4\nf0 -99 2 3 4\n");
        let mut random = 7_u32;
        let mut below = |n: u16| {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let [a, b, ..] = random.to_be_bytes();
            f32::from(u16::from_be_bytes([a, b])) / 65_536.0 * f32::from(n)
        };
        for i in 0..6 * 200 {
            let (u, v, d) = (300.0 + below(1600), below(1199), 20.0 + below(250));
            let v_r = v + below(1) - 0.5;
            writeln!(text, "f{} {u} {v} {} {v_r} 0.9", i / 200, u - d).unwrap();
        }
        text
    }

    #[test]
    fn lines_in_lines_out() {
        let mut rig = set_up(&RIG.map(ToOwned::to_owned)).unwrap();
        let mut out = Vec::new();
        run(&mut rig, lines().as_bytes(), &mut out).unwrap();
        let out = String::from_utf8(out).unwrap();
        assert_eq!(out.lines().filter(|line| line.starts_with("pair f")).count(), 6, "{out}");
        let in_use = out.lines().rfind(|line| line.starts_with("in_use ")).unwrap();
        assert_eq!(in_use.split(' ').count(), 14);
        let t_x: f32 = in_use.split(' ').nth(11).unwrap().parse().unwrap();
        assert!((t_x + 1.0).abs() < 1e-4, "{in_use}");
    }

    #[test]
    fn wrong_options_are_named() {
        assert_eq!(refused(&[]), "--focal is missing");
        assert_eq!(refused(&["--focal"]), "--focal has no value");
        assert_eq!(refused(&["--zoom", "3"]), "unknown option --zoom");
        let [a, b, c, d, e, _] = RIG;
        assert_eq!(refused(&[a, b, c, d, e, "1920"]), "--size: 1 numbers, 2 expected");
        let left = refused(&[a, "x", c, d, e, "1920x1200"]);
        assert_eq!(left, "`x` is not a number");
        let right = refused(&[a, b, c, d, e, "1920x1200", "--right-focal", "-5"]);
        assert!(right.starts_with("right camera: focal length"), "{right}");
    }
}
