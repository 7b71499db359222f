//! Macros that give the values of an enumeration their numbers and their texts.

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
