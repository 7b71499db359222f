//! Parsers of arguments.

use std::str::FromStr;

/// Sizes of the images, `W,H` of both or `W,H,W,H` of left and right.
pub(crate) fn sizes(text: &str) -> Result<[[u16; 2]; 2], String> {
    if let Ok([w, h, x, y]) = numbers(text) {
        return Ok([[w, h], [x, y]]);
    }
    numbers(text)
        .map(|both| [both; 2])
        .map_err(|why| format!("{why}: W,H, or W,H,W,H of left and right"))
}

/// `N` numbers with commas between.
pub(crate) fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let numbers: Vec<T> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("`{number}` is not a number here")))
        .collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("{N} numbers separated by commas are needed"))
}
