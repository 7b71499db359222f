//! The emulated boards.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A board of QEMU, its controller, and the speed that estimates of time assume.
#[derive(Debug, PartialEq)]
pub struct Board {
    /// Name on command lines and in tables.
    pub name: &'static str,
    /// QEMU's name of the board.
    pub machine: &'static str,
    /// QEMU's name of the core.
    pub cpu: &'static str,
    /// Rust's target.
    pub target: &'static str,
    /// Compiler flags for the core; empty if the target is made for it.
    pub rustflags: &'static str,
    /// Scalars of the floating-point unit.
    pub scalars: &'static [&'static str],
    /// Clock, Hz.
    pub hertz: f64,
    /// Assumed cycles per instruction. `None` if the plugin `cycles` counts them, by the table of the core's manual.
    pub cycles: Option<f64>,
}

/// All boards; the first one is the default.
pub static BOARDS: [Board; 2] = [
    // `f64` is in software.
    Board {
        name: "m4f",
        machine: "mps2-an386",
        cpu: "cortex-m4",
        target: "thumbv7em-none-eabihf",
        rustflags: "",
        scalars: &["f32"],
        hertz: 168e6,
        cycles: None,
    },
    // Its manual has no table of cycles. Dual issue; dependent floating-point instructions issue one per cycle.
    Board {
        name: "m7",
        machine: "mps2-an500",
        cpu: "cortex-m7",
        target: "thumbv7em-none-eabihf",
        rustflags: "-Ctarget-cpu=cortex-m7",
        scalars: &["f32", "f64"],
        hertz: 480e6,
        cycles: Some(1.0),
    },
];

impl Board {
    /// The board with this name, or with this name of QEMU.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        BOARDS.iter().find(|board| [board.name, board.machine].contains(&name))
    }

    /// Parses a board of a command line.
    #[must_use]
    pub fn parser() -> impl TypedValueParser<Value = &'static Self> {
        let names = BOARDS.iter().map(|board| PossibleValue::new(board.name).alias(board.machine));
        PossibleValuesParser::new(names)
            .try_map(|name| Self::named(&name).ok_or("there is no such board"))
    }
}
