//! C API of `stereo-selfcal`: `f32`, no heap, in storage that the caller owns.
//!
//! The header is `include/stereo_selfcal.h`, generated from this source; the names here are those of
//! C. Conventions as in the core: `p_r = R p_l + t`, `|t| = 1`, camera frames x right, y down,
//! z forward; matrices row by row; angles in rad; pixels of the image as it is, before undistortion.
//!
//! Every function returns a [`selfcal_error_t`] and gives its results through pointers, but for the
//! `_string` functions. A call that is refused changes no extrinsics, and gives no results but those that
//! its function names. Correspondences that are refused are counted; a pair that is refused is noted in
//! the health and may count against the estimate.
//!
//! # Safety
//! One contract for all functions. Each pointer is null, or points to a live object of its type that
//! no other thread or interrupt touches during the call, and that does not overlap the others of the
//! call. Null and misaligned pointers, and storage that `selfcal_init` or `selfcal_link_init` has not
//! been called on, are refused.

#![no_std]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::unreachable,
    clippy::std_instead_of_core
)]
#![allow(non_camel_case_types, reason = "the names are those of the C header")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all: see above")]

// Brings the panic handler where there is an operating system.
#[cfg(not(target_os = "none"))]
extern crate std;

mod apply;
mod camera;
mod capacity;
mod code;
mod code_of;
mod config;
mod estimate;
mod extrinsics;
mod health;
mod instance;
mod link;
mod marked;
mod pair;
mod pointer;
mod push;
mod record;
mod rectify;
mod storage;
mod text;

pub use apply::*;
pub use camera::*;
pub use capacity::*;
pub use code::*;
pub use config::*;
pub use estimate::*;
pub use extrinsics::*;
pub use health::*;
pub use link::*;
pub use pair::*;
pub use push::*;
pub use record::*;
pub use rectify::*;
pub use storage::*;

/// Never reached: the core has no reachable panic, and the example firmware links without this
/// function. It stands still, so that a watchdog can act.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
