//! Thresholds of the estimator, one file for each step of the data flow: geometry, pair, fusion, lens, depth, outcome,
//! and the published method. `ESTIMATOR.md` derives the quantities that they limit.
//!
//! Each one states its unit, its reason, and the effect of a larger and of a smaller value. A suffix names the unit
//! (`_PX`, `_RAD`); a number without one is a count or dimensionless. Sizes of memory layouts and of wire formats are
//! not here. Values that a user sets are in [`crate::Config`].

mod depth;
mod fusion;
mod geometry;
mod lens;
mod outcome;
mod pair;
pub(crate) mod paper;

pub(crate) use depth::*;
pub(crate) use fusion::*;
pub(crate) use geometry::*;
pub(crate) use lens::*;
pub(crate) use outcome::*;
pub(crate) use pair::*;

#[cfg(test)]
mod tests;
