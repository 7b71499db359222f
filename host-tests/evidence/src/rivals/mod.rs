//! Rivals: methods of the literature and of common practice that the two presets of the core are compared with, in
//! `f64`.
//!
//! Each method of the literature is written from its publication, independently of the core. Its file and
//! [`Method::source`] name the details that are filled in or left out.

mod bundle;
mod cauchy;
mod dang;
mod epipolar;
mod filter;
mod five_point;
mod front;
mod fusion;
mod gate;
mod hansen;
mod ling_shen;
pub mod literal_paper;
mod method;
mod minimise;
mod mueller_block;
mod mueller_ukf;
mod ours;
mod pose;
mod ransac;
mod teso;
#[cfg(test)]
mod tests;
mod tuning;
mod variant;

use anyhow::{Context, Result};

pub use bundle::Bundle;
pub use cauchy::Cauchy;
pub use dang::Dang;
pub use front::Front;
pub use hansen::Hansen;
pub use ling_shen::LingShen;
pub use method::{Method, Setting};
pub use mueller_block::MuellerBlock;
pub use mueller_ukf::MuellerUkf;
pub(crate) use ours::CAPACITY;
pub use ours::{Paper, Robust};
pub use ransac::Ransac;
pub use teso::Teso;
pub use tuning::Tuning;
pub use variant::{Range, Variant, all_variants, variants};

/// All methods, in the order of a table's columns: both presets of the core, then the literature by year of
/// publication, then common practice.
#[must_use]
pub fn all() -> Vec<Box<dyn Method>> {
    vec![
        Box::new(Robust),
        Box::new(Paper),
        Box::new(Dang),
        Box::new(Hansen),
        Box::new(LingShen),
        Box::new(MuellerUkf),
        Box::new(MuellerBlock),
        Box::new(Teso),
        Box::new(Cauchy),
        Box::new(Ransac),
        Box::new(Bundle),
    ]
}

/// The method of that name.
///
/// # Errors
/// Lists the existing names.
pub fn by_name(name: &str) -> Result<Box<dyn Method>> {
    let all = all();
    let names: Vec<&str> = all.iter().map(|method| method.name()).collect();
    let names = names.join(", ");
    let found = all.into_iter().find(|method| method.name() == name);
    found.with_context(|| format!("no method is called {name}; there are: {names}"))
}
