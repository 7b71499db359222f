//! Rows on the semihosting output.

use core::fmt::Display;

use cortex_m_semihosting::hprintln;

/// A row of the table.
pub(crate) fn row(name: impl Display, unit: &str, value: u32) {
    hprintln!("{},{},{}", name, unit, value);
}

/// A line that is no row.
pub(crate) fn remark(text: impl Display) {
    hprintln!("# {}", text);
}
