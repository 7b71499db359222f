//! Prints rows over semihosting.

use core::fmt::Display;

use cortex_m_semihosting::hprintln;

/// Prints a row of the table.
pub(crate) fn row(name: impl Display, unit: &str, value: u32) {
    hprintln!("{},{},{}", name, unit, value);
}
