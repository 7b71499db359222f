//! Values of an option that are the variants of an enumeration.

use std::str::FromStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use strum::{EnumMessage, ParseError, VariantArray};

/// The names of the variants; their documentation is the help text.
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
