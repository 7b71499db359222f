//! The commands that read no images, as a user calls them.

mod call;
mod compensated;
mod conventions;
mod output;
mod page;
mod piped;
mod reference;
mod stream;
