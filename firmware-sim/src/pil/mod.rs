//! Processor in the loop: a host sends the frames of the matcher over a serial line and gets the result of
//! each pair, bit for bit.
//!
//! | sender | message | content |
//! |---|---|---|
//! | host | [`SessionRequest`] | both cameras, and the number of pairs |
//! | controller | [`SessionReply`] | whether it accepts them |
//! | host | a frame, see [`stereo_selfcal::link`] | one pair; decoded as the matcher's frames are |
//! | controller | [`PairReply`] | the result of the pair |
//! | controller | [`EndReply`] | after the last pair: the extrinsics in use |
//!
//! Messages are little endian and without padding. The line is taken to be free of errors.

mod reply;
mod request;
mod session;

pub use reply::{EndReply, Field, PairReply, SessionReply};
pub use request::{RequestError, SessionRequest};
pub use session::{SessionError, run_session};
