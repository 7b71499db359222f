//! The C functions, called through their C interface.
#![allow(clippy::borrow_as_ptr, reason = "C code takes addresses in the same way")]

mod codes;
mod encoder;
mod history;
mod lens;
mod lens_tracking;
mod life;
mod link;
mod link_misuse;
mod misuse;
mod order;
mod paper;
mod record;
mod record_misuse;
mod rig;
mod source;
mod storage;
mod tracks;
