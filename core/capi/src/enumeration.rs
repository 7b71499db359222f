//! Enumerations of C: number, name and English text of each value stand once, in the declaration.

use core::ffi::{CStr, c_char};

/// Declares an enumeration. The first line of a value's documentation is its text.
///
/// `tests/header.rs` unwraps the declaration: cbindgen expands no macros.
macro_rules! c_enum {
    ($(#[$attribute:meta])* pub enum $name:ident {
        $(#[doc = $text:literal] $(#[doc = $more:literal])* $value:ident = $number:literal,)+
    }) => {
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $(#[doc = $text] $(#[doc = $more])* $value = $number,)+
        }

        impl $name {
            const TEXTS: &[$crate::enumeration::Text] =
                &[$(($number, $crate::enumeration::text(concat!($text, "\0"))),)+];

            /// The value of a number. A search out of line: a `match` takes 0.6 kB more flash, and
            /// a search in line 1.5 kB more.
            #[inline(never)]
            pub(crate) fn of(number: u16) -> Option<Self> {
                const VALUES: &[$name] = &[$($name::$value),+];
                VALUES.iter().copied().find(|value| *value as u32 == number.into())
            }
        }
    };
}

/// Converts enumerations of the core by their numbers.
macro_rules! from_core {
    ($($core:ty),+ => $name:ident, else $unknown:ident) => {$(
        impl From<$core> for $name {
            fn from(value: $core) -> Self {
                Self::of(value.code()).unwrap_or(Self::$unknown)
            }
        }
    )+};
}

/// A number and its text.
pub(crate) type Text = (u32, &'static CStr);

/// The text of a line of documentation that ends in a zero.
pub(crate) const fn text(line: &'static str) -> &'static CStr {
    let ([b' ', bytes @ ..] | bytes) = line.as_bytes();
    match CStr::from_bytes_with_nul(bytes) {
        Ok(text) => text,
        Err(_) => UNKNOWN,
    }
}

const UNKNOWN: &CStr = c"unknown";

/// The text of a number; `"unknown"` without one.
pub(crate) fn find(texts: &[Text], number: u32) -> *const c_char {
    let found = texts.iter().find(|(of, _)| *of == number);
    found.map_or(UNKNOWN, |(_, text)| text).as_ptr()
}
