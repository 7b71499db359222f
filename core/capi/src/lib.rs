//! C API of `stereo-selfcal`: `f32`, no heap, in storage that the caller owns.
//!
//! The header `include/stereo_selfcal.h` is generated from this source; names follow C.
//! Conventions as in the core: `p_r = R p_l + t`, `|t| = 1`, camera frames x right, y down,
//! z forward; matrices row by row; angles in rad; pixels of the raw image, before undistortion.
//!
//! Every function returns a [`selfcal_error_t`] and writes its results through pointers; the
//! exceptions are `selfcal_string`, `selfcal_argument_string` and `selfcal_version`. A refused call writes no results
//! except the ones that its documentation names. The calibration in use stays as it is, unless a record is refused:
//! [`selfcal_restore`] then leaves the factory calibration in use. Refused correspondences are counted. A
//! refused pair is noted in the verdict and may count against the estimate.
//!
//! # Safety
//! One contract holds for all functions. Each pointer is null, or points to a live object of its type that
//! no other thread or interrupt touches during the call, and that does not overlap the other objects of the
//! call. The functions refuse null and misaligned pointers, and storage without a prior
//! `selfcal_init`, `selfcal_link_init`, `selfcal_tracks_init`, `selfcal_paper_init` or `selfcal_frame_begin`.

#![no_std]
#![deny(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::unreachable,
    clippy::std_instead_of_core
)]
#![allow(non_camel_case_types, reason = "names of the C header")]
#![allow(clippy::missing_safety_doc, reason = "one contract for all, see above")]

// Provides the panic handler on targets with an operating system.
#[cfg(not(target_os = "none"))]
extern crate std;

#[macro_use]
mod enumeration;

mod apply;
mod calibration;
mod camera;
mod capacity;
mod config;
mod details;
mod encoder;
mod error;
mod estimate;
mod extrinsics;
mod factory;
mod history;
mod instance;
mod lens;
mod lifecycle;
mod link;
mod marked;
mod pair;
mod paper;
mod pointer;
mod push;
mod record;
mod rectify;
mod tracks;
mod verdict;
mod witness;

pub use apply::*;
pub use calibration::*;
pub use camera::*;
pub use capacity::*;
pub use config::*;
pub use details::*;
pub use encoder::*;
pub use enumeration::*;
pub use error::*;
pub use estimate::*;
pub use extrinsics::*;
pub use factory::*;
pub use history::*;
pub use instance::*;
pub use lens::*;
pub use lifecycle::*;
pub use link::*;
pub use pair::*;
pub use paper::*;
pub use push::*;
pub use record::*;
pub use rectify::*;
pub use tracks::*;
pub use verdict::*;
pub use witness::*;

/// Unreachable: the core has no reachable panic. `.ci/capi` links all functions of the API, and checks that the linker
/// drops this function. It loops, so that a watchdog can act.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
