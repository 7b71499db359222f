//! Prints rows over semihosting.

use core::fmt::Display;

use cortex_m_semihosting::hprintln;

/// Prints a row of the table.
pub(crate) fn row(name: impl Display, unit: &str, value: u32) {
    hprintln!("{},{},{}", name, unit, value);
}

/// Mean, rounded.
pub(crate) fn mean(sum: u32, count: usize) -> u32 {
    let count = u32::try_from(count).unwrap_or(u32::MAX);
    (sum + count / 2) / count
}
