//! The measured variants: boards, scalars and optimisations.

use std::fmt;

/// An emulated board, with the controller's core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Board {
    /// Cortex-M4F, single precision.
    #[value(name = "m4f")]
    CortexM4F,
    /// Cortex-M7, double precision.
    #[value(name = "m7")]
    CortexM7,
}

impl Board {
    pub(crate) const ALL: [Self; 2] = [Self::CortexM4F, Self::CortexM7];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::CortexM4F => "m4f",
            Self::CortexM7 => "m7",
        }
    }

    /// QEMU's machine and cpu.
    pub(crate) fn emulated(self) -> [&'static str; 2] {
        match self {
            Self::CortexM4F => ["mps2-an386", "cortex-m4"],
            Self::CortexM7 => ["mps2-an500", "cortex-m7"],
        }
    }

    /// Compiler flags for the core. `None` for the Cortex-M4F, for which the target is made.
    pub(crate) fn rustflags(self) -> Option<&'static str> {
        match self {
            Self::CortexM4F => None,
            Self::CortexM7 => Some("-C target-cpu=cortex-m7"),
        }
    }

    /// Scalars of its floating-point unit.
    pub(crate) fn scalars(self) -> &'static [&'static str] {
        match self {
            Self::CortexM4F => &["f32"],
            Self::CortexM7 => &["f32", "f64"],
        }
    }

    /// Programs for it: one per scalar, and on the Cortex-M4F the programs that give the size of the core.
    pub(crate) fn programs(self) -> Vec<String> {
        let mut programs: Vec<_> = self.scalars().iter().map(|s| format!("cost-{s}")).collect();
        if self == Self::CortexM4F {
            programs.extend(["facade-store", "facade", "bare"].map(String::from));
        }
        programs
    }
}

/// A cargo profile of the workspace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Optimisation {
    Speed,
    Size,
}

impl Optimisation {
    pub(crate) const ALL: [Self; 2] = [Self::Speed, Self::Size];

    pub(crate) fn profile(self) -> &'static str {
        match self {
            Self::Speed => "controller",
            Self::Size => "controller-size",
        }
    }

    /// Value of `opt-level`.
    pub(crate) fn level(self) -> &'static str {
        match self {
            Self::Speed => "3",
            Self::Size => "s",
        }
    }
}

/// One build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Variant {
    pub(crate) board: Board,
    pub(crate) optimisation: Optimisation,
}

impl Variant {
    pub(crate) fn of(board: Board) -> impl Iterator<Item = Self> {
        Optimisation::ALL.into_iter().map(move |optimisation| Self { board, optimisation })
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, opt-level {}", self.board.name(), self.optimisation.level())
    }
}
