//! The emulated boards.

use clap::ValueEnum;

/// A board of QEMU for which the images are linked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum Machine {
    /// Cortex-M4F: f64 in software.
    #[default]
    #[value(name = "mps2-an386")]
    An386,
    /// Cortex-M7: f64 in hardware, if the image is built for it.
    #[value(name = "mps2-an500")]
    An500,
}

impl Machine {
    /// QEMU's name of the board.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::An386 => "mps2-an386",
            Self::An500 => "mps2-an500",
        }
    }

    /// QEMU's name of the core.
    #[must_use]
    pub fn cpu(self) -> &'static str {
        match self {
            Self::An386 => "cortex-m4",
            Self::An500 => "cortex-m7",
        }
    }

    /// Compiler flags for the core. `None` for the Cortex-M4F, for which the target is made.
    #[must_use]
    pub fn rustflags(self) -> Option<&'static str> {
        match self {
            Self::An386 => None,
            Self::An500 => Some("-Ctarget-cpu=cortex-m7"),
        }
    }
}
