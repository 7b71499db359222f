//! The C functions, called as C calls them.
#![allow(clippy::borrow_as_ptr, reason = "as C takes an address")]

mod codes;
mod life;
mod misuse;
mod order;
mod rig;
mod source;
mod storage;
