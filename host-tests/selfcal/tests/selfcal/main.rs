//! The program `selfcal` as a user calls it.

mod call;
mod documents;
mod evaluate;
mod images;
mod measuring;
