//! Builds and runs all programs: the rows of the table.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::thread::{self, ScopedJoinHandle};
use std::time::Duration;

use anyhow::{Context, Result, anyhow, ensure};
use clap::builder::PossibleValuesParser;
use emulator::Board;

use crate::flash::Functions;
use crate::table::{Row, Table};

/// Cargo profiles of the workspace, and their `opt-level`.
const PROFILES: [(&str, &str); 2] = [("controller", "3"), ("controller-size", "s")];

/// Parses the `opt-level` of a profile.
pub(crate) fn opts() -> PossibleValuesParser {
    PROFILES.map(|(_, opt)| opt).into()
}

/// Programs that give the size of the core, on the first board only.
const SIZES: [&str; 3] = ["bare", "facade", "facade-store"];

/// The figures and the functions of all builds.
pub(crate) struct Measured {
    pub(crate) table: Table,
    /// The functions of each build of the first board.
    pub(crate) functions: Vec<Functions>,
}

/// Cycles to fill the pipeline after a branch. The manual gives 1 to 3.
const REFILL: u32 = 3;

/// Longest run. A program that faults loops forever.
const TIMEOUT: Duration = Duration::from_secs(600);

/// One build.
#[derive(Clone, Copy)]
struct Variant {
    board: &'static Board,
    profile: &'static str,
    opt: &'static str,
}

/// Measures every variant of some boards.
///
/// * `opt`: the only `opt-level` to measure; `None` for all.
/// * `wait`: wait states of the flash, for each line of 128 bits.
/// * `repeat`: runs of each program, which must all print the same.
pub(crate) fn measure(
    boards: &[&'static Board],
    opt: Option<&str>,
    wait: u32,
    repeat: u16,
) -> Result<Measured> {
    let plugin = emulator::cycle_counter()?;
    let plugin = &format!("{},refill={REFILL},wait={wait}", plugin.display());
    let variants = boards
        .iter()
        .flat_map(|&board| PROFILES.map(|(profile, opt)| Variant { board, profile, opt }))
        .filter(|variant| opt.is_none_or(|opt| variant.opt == opt));
    // A thread per variant: a link and an emulator take one core each.
    let all = thread::scope(|scope| {
        let threads: Vec<_> =
            variants.map(|variant| scope.spawn(move || variant.measure(plugin, repeat))).collect();
        let join = |thread: ScopedJoinHandle<'_, _>| {
            thread.join().map_err(|_| anyhow!("a measurement panicked"))?
        };
        threads.into_iter().map(join).collect::<Result<Vec<Measured>>>()
    })?;
    let compiler = all.first().context("no board")?.table.compiler.clone();
    let same = all.iter().all(|measured| measured.table.compiler == compiler);
    ensure!(same, "different compilers built the programs");
    let (mut rows, mut functions) = (Vec::new(), Vec::new());
    for measured in all {
        rows.extend(measured.table.rows);
        functions.extend(measured.functions);
    }
    Ok(Measured { table: Table { compiler, rows }, functions })
}

impl Variant {
    fn measure(self, plugin: &str, repeat: u16) -> Result<Measured> {
        let Self { board, profile, opt } = self;
        let has_sizes = board == &emulator::BOARDS[0];
        let sizes = SIZES.iter().filter(|_| has_sizes).map(|&name| name.to_owned());
        let costs = board.scalars.iter().map(|scalar| format!("cost-{scalar}"));
        eprintln!("builds for {}, opt-level {opt}", board.name);
        let built = emulator::build(board, |cargo| {
            cargo.args(["-p", "cost", "--no-default-features", "--features", "controller"]);
            cargo.args(["--profile", profile]);
            cargo.args(sizes.chain(costs).flat_map(|name| ["--bin".into(), name]))
        })?;
        let path = |name: &str| built.get(name).with_context(|| format!("cargo built no {name}"));
        let (mut rows, mut functions, mut compiler) = (Vec::new(), Vec::new(), None);
        for scalar in board.scalars {
            let program = path(&format!("cost-{scalar}"))?;
            eprintln!("runs {scalar} on {}, opt-level {opt}", board.name);
            let text = repeated(board, program, &["-icount", "shift=10"], repeat)?;
            rows.extend(printed(&text, [board.name, scalar, opt])?);
            if board.cycles.is_none() {
                let text = repeated(board, program, &["-plugin", plugin], repeat)?;
                rows.extend(
                    printed(&text, [board.name, scalar, opt])?.iter().filter_map(Row::in_cycles),
                );
            }
            compiler = Some(compiler_of(program)?);
            if has_sizes {
                functions.push(Functions::of(program, opt)?);
            }
        }
        if has_sizes {
            let [bare, facade, store] = SIZES.map(|name| path(name).and_then(|path| size(path)));
            let all = sizes_of_core(bare?, facade?, store?);
            let row = |(what, value)| Row::new([board.name, "f32", opt, what], "bytes", value);
            rows.extend(all.map(row));
            let estimator = Functions::of(path("facade")?, opt)?;
            rows.extend(modules(&estimator, "", [board.name, "f32", opt]));
            for every in &functions {
                rows.extend(modules(every, " with every call", [board.name, "f32", opt]));
            }
        }
        let compiler = compiler.context("the board has no scalar")?;
        Ok(Measured { table: Table { compiler, rows }, functions })
    }
}

fn repeated(board: &Board, program: &Path, options: &[&str], repeat: u16) -> Result<String> {
    let run = || emulator::output(board, program, options, TIMEOUT);
    let first = run()?;
    for _ in 1..repeat {
        ensure!(run()? == first, "{} counts differently in another run", program.display());
    }
    Ok(first)
}

/// The rows that a program printed.
fn printed(text: &str, [board, scalar, opt]: [&str; 3]) -> Result<Vec<Row>> {
    text.lines()
        .map(|line| {
            let fields: Vec<_> = line.split(',').collect();
            let [what, unit, value] = *fields.as_slice() else {
                anyhow::bail!("not a row: {line}");
            };
            let value = value.parse().with_context(|| format!("not a number: {line}"))?;
            Ok(Row::new([board, scalar, opt, what], unit, value))
        })
        .collect()
}

/// Size of a program, bytes: code with constants, initial values, zeroed RAM.
type Size = [u64; 3];

/// Flash and RAM of the core: a program that calls the estimator less an empty one, and a program that also calls
/// the store less the first.
fn sizes_of_core(bare: Size, facade: Size, store: Size) -> [(&'static str, u64); 4] {
    let less = |a: Size, b: Size, i: usize| a[i].saturating_sub(b[i]);
    let [code, data, zeroed] = [0, 1, 2].map(|i| less(facade, bare, i));
    [
        ("flash: code and constants", code),
        ("flash: initial values of a static calibrator", data),
        ("RAM: statics", data + zeroed),
        ("flash: records and store", less(store, facade, 0)),
    ]
}

/// Flash of each module of the core in a program.
fn modules(functions: &Functions, which: &str, [board, scalar, opt]: [&str; 3]) -> Vec<Row> {
    let modules = functions.modules().into_iter();
    let what = |module| format!("flash of {module}{which}");
    modules.map(|(m, bytes)| Row::new([board, scalar, opt, &what(m)], "bytes", bytes)).collect()
}

/// Size of a program, as `arm-none-eabi-size` prints it.
fn size(program: &Path) -> Result<Size> {
    let output = Command::new("arm-none-eabi-size").arg(program).output();
    let output = output.context("arm-none-eabi-size; .ci/install-toolchain installs it")?;
    let text = String::from_utf8(output.stdout)?;
    sizes(&text).with_context(|| format!("arm-none-eabi-size printed {text}"))
}

fn sizes(text: &str) -> Option<Size> {
    let numbers = text.lines().nth(1)?.split_whitespace().map_while(|field| field.parse().ok());
    numbers.take(3).collect::<Vec<u64>>().try_into().ok()
}

/// The version of the compiler of a program.
fn compiler_of(program: &Path) -> Result<String> {
    let bytes = fs::read(program).with_context(|| program.display().to_string())?;
    version(&bytes).with_context(|| format!("{} names no rustc", program.display()))
}

fn version(program: &[u8]) -> Option<String> {
    const BEFORE: &[u8] = b"rustc version ";
    let at = program.windows(BEFORE.len()).position(|bytes| bytes == BEFORE)? + BEFORE.len();
    let version = program[at..].iter().take_while(|byte| byte.is_ascii_graphic());
    Some(version.copied().map(char::from).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_parsed() {
        let rows = printed("push,instructions,365\n", ["m7", "f64", "s"]).unwrap();
        assert_eq!(rows, [Row::new(["m7", "f64", "s", "push"], "instructions", 365)]);
    }

    #[test]
    fn output_other_than_rows_is_refused() {
        for text in ["panicked at pair.rs", "push,instructions,many"] {
            assert!(printed(text, ["m7", "f64", "s"]).is_err(), "{text}");
        }
    }

    #[test]
    fn the_core_is_a_difference_of_programs() {
        let text = "   text\t   data\t    bss\n 1290\t 4\t 10888\t 9 9 bare\n";
        assert_eq!(sizes(text), Some([1290, 4, 10_888]));
        assert_eq!(sizes("no such file"), None);
        let of_core = sizes_of_core([100, 0, 4], [1290, 4, 10_888], [1500, 4, 10_888]);
        assert_eq!(of_core.map(|(_, bytes)| bytes), [1190, 4, 10_888, 210]);
    }

    #[test]
    fn a_program_names_its_compiler() {
        let text = b"\0\x7frustc version 1.96.0 (ac68faa20)\0";
        assert_eq!(version(text).as_deref(), Some("1.96.0"));
        assert_eq!(version(b"clang version 19"), None);
    }
}
