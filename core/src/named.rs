//! Macros that give the values of an enumeration their numbers and their texts, and that define sets of the values.

/// Defines the number of each value. An error that several operations return has the same number in all of them.
/// `capi/tests/api/codes.rs` checks all numbers together.
macro_rules! codes {
    ($($name:ident $([$($generic:ident),+])? {
        $($variant:ident $({ $($field:tt: $value:ident),+ })? = $code:expr),+ $(,)?
    })+) => {$(
        impl $(<$($generic),+>)? $name $(<$($generic),+>)? {
            /// Returns the number for a log or a wire. Errors have numbers from 100 on. An error that several
            /// operations return has the same number in all of them.
            #[must_use]
            pub const fn code(&self) -> u16 {
                match self {
                    $(Self::$variant { $($($field: $value,)+)? .. } => $code,)+
                }
            }
        }
    )+};
}

/// Defines the text of each value.
macro_rules! texts {
    ($($name:ident { $($variant:ident = $text:literal),+ $(,)? })+) => {$(
        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.pad(match self { $(Self::$variant => $text,)+ })
            }
        }
    )+};
}

/// Defines a set of the values of an enumeration. The code of each value is one bit.
macro_rules! sets {
    ($($(#[$attribute:meta])* $name:ident of $value:ident;)+) => {$(
        $(#[$attribute])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name(u16);

        impl $name {
            /// The empty set.
            pub const NONE: Self = Self(0);

            /// Returns the set with a value added, if the value holds.
            #[must_use]
            pub(crate) const fn with(self, value: $value, holds: bool) -> Self {
                if holds { Self(self.0 | value.code()) } else { self }
            }

            /// Returns whether the set is empty.
            #[must_use]
            pub const fn is_empty(self) -> bool {
                self.0 == 0
            }

            /// Returns whether a value is in the set.
            #[must_use]
            pub const fn contains(self, value: $value) -> bool {
                self.0 & value.code() != 0
            }

            /// Returns the values, in the order of their list `ALL`.
            pub fn iter(self) -> impl Iterator<Item = $value> {
                $value::ALL.into_iter().filter(move |value| self.contains(*value))
            }

            /// Returns the sum of the codes of the values.
            #[must_use]
            pub const fn bits(self) -> u16 {
                self.0
            }
        }

        impl core::fmt::Display for $name {
            /// Writes the values with commas between them; `none` for an empty set.
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                if self.is_empty() {
                    return f.write_str("none");
                }
                let mut separator = "";
                for value in self.iter() {
                    write!(f, "{separator}{value}")?;
                    separator = ", ";
                }
                Ok(())
            }
        }

        #[cfg(feature = "defmt")]
        impl defmt::Format for $name {
            fn format(&self, f: defmt::Formatter<'_>) {
                for value in self.iter() {
                    defmt::write!(f, "{} ", value);
                }
            }
        }
    )+};
}
