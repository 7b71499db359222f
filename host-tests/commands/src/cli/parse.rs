//! Parsers of arguments.

use std::str::FromStr;

/// `N` numbers with commas between.
pub(super) fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let numbers: Vec<T> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("`{number}` is not a number here")))
        .collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("{N} numbers with commas between are needed"))
}
