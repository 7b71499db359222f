//! The core against a literal transcription of the paper's method.

mod errata;
mod recorded;
