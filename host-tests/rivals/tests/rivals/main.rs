//! The literal method of the paper, beside the core.

mod errata;
mod recorded;
