//! The boards.

use clap::ValueEnum;

/// A board of QEMU's that the images are linked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Machine {
    /// Cortex-M4F: f64 in software.
    #[default]
    #[value(name = "mps2-an386")]
    An386,
    /// Cortex-M7: f64 in hardware, where the image is built for it.
    #[value(name = "mps2-an500")]
    An500,
}

impl Machine {
    /// As QEMU names it.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::An386 => "mps2-an386",
            Self::An500 => "mps2-an500",
        }
    }

    /// Its core, as QEMU names it.
    pub(crate) fn cpu(self) -> &'static str {
        match self {
            Self::An386 => "cortex-m4",
            Self::An500 => "cortex-m7",
        }
    }

    /// What the compiler is told beyond the target, which is made for the smaller core.
    pub(crate) fn rustflags(self) -> Option<&'static str> {
        match self {
            Self::An386 => None,
            Self::An500 => Some("-Ctarget-cpu=cortex-m7"),
        }
    }
}
