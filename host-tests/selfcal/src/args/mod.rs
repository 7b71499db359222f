//! Arguments that several commands have, and their parsers.

pub(crate) mod parse;
pub(crate) mod recording;
pub(crate) mod rig;
pub(crate) mod setup;
