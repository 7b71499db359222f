//! Enumerations of C. Number, name and English text of each value are written only once, in the declaration.

use core::ffi::{CStr, c_char};

use crate::error::selfcal_error_t;
use crate::estimate::{selfcal_direction_t, selfcal_state_t};
use crate::pair::{selfcal_fused_t, selfcal_stop_t};
use crate::push::selfcal_pushed_t;
use crate::verdict::{selfcal_cause_t, selfcal_reason_t};
use crate::witness::selfcal_witnessed_t;

/// Declares an enumeration. The first line of a value's documentation is its text.
///
/// `header/src/main.rs` unwraps the declaration: cbindgen expands no macros.
macro_rules! c_enum {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $(#[doc = $text:literal] $(#[doc = $more:literal])* $value:ident = $number:literal,)+
    }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $(#[doc = $text] $(#[doc = $more])* $value = $number,)+
        }

        impl $crate::enumeration::Values for $name {
            const VALUES: &[Self] = &[$(Self::$value),+];
        }

        impl $name {
            pub(crate) const TEXTS: &[$crate::enumeration::Text] =
                &[$(($number, $crate::enumeration::text(concat!($text, "\0"))),)+];
        }
    };
}

/// Converts enumerations of the core to an enumeration of C: the number of a value is its code in the core plus
/// `first`. A code that the enumeration of C does not have becomes `unknown`. The `first` of each enumeration differs,
/// so that no two enumerations share a number.
macro_rules! from_core {
    ($($core:ty),+ => $name:ident from $first:literal, else $unknown:ident) => {
        impl $name {
            /// Returns the value with a number; `None` for other numbers.
            #[inline(never)]
            fn of(number: u32) -> Option<Self> {
                let mut values = <Self as $crate::enumeration::Values>::VALUES.iter().copied();
                values.find(|value| *value as u32 == number)
            }
        }
        $(
        impl From<$core> for $name {
            fn from(value: $core) -> Self {
                let number = u32::from(value.code()) + $first;
                Self::of(number).unwrap_or(Self::$unknown)
            }
        }
        )+
    };
}

/// An enumeration with the list of its values.
pub(crate) trait Values: Copy + 'static {
    const VALUES: &'static [Self];
}

/// A number and its text.
pub(crate) type Text = (u32, &'static CStr);

/// Returns a line of documentation, which ends in its only zero byte, as a text without its leading space.
pub(crate) const fn text(line: &'static str) -> &'static CStr {
    let ([b' ', bytes @ ..] | bytes) = line.as_bytes();
    match CStr::from_bytes_with_nul(bytes) {
        Ok(text) => text,
        Err(_) => UNKNOWN,
    }
}

const UNKNOWN: &CStr = c"unknown";

/// The texts of all enumerations that the API returns. No two of these enumerations share a number.
const ALL: &[&[Text]] = &[
    selfcal_error_t::TEXTS,
    selfcal_pushed_t::TEXTS,
    selfcal_stop_t::TEXTS,
    selfcal_fused_t::TEXTS,
    selfcal_state_t::TEXTS,
    selfcal_direction_t::TEXTS,
    selfcal_reason_t::TEXTS,
    selfcal_cause_t::TEXTS,
    selfcal_witnessed_t::TEXTS,
];

/// Returns the English text of an error code, or of a value of any other enumeration that is the type of a result;
/// never null. No two of these enumerations share a number. For other numbers the text is `"unknown"`. Enumerations
/// that arguments have as plain numbers, such as `selfcal_lens_t`, have no texts, and share numbers with error codes.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_string(value: u32) -> *const c_char {
    let found = ALL.iter().copied().flatten().find(|(number, _)| *number == value);
    found.map_or(UNKNOWN, |(_, text)| text).as_ptr()
}
