//! Parsers of values.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use strum::{EnumMessage, ParseError, VariantArray};

/// The names of the variants of an enumeration; their documentation is the help text.
pub(crate) fn choice<T>() -> impl TypedValueParser<Value = T>
where
    T: VariantArray + EnumMessage + ToString + FromStr<Err = ParseError> + Clone + Send + Sync,
{
    let value = |one: &T| {
        let help = one.get_documentation().unwrap_or_default().trim_end_matches('.');
        PossibleValue::new(one.to_string()).help(help)
    };
    PossibleValuesParser::new(T::VARIANTS.iter().map(value)).try_map(|name| name.parse())
}

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

/// A share from 0 to 1.
pub(crate) fn share(text: &str) -> Result<f64, String> {
    let share = text.parse().ok().filter(|x| (0.0..=1.0).contains(x));
    share.ok_or_else(|| "a share from 0 to 1 is needed".into())
}
