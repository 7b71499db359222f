//! Charts, pages of sections, and the page of a run.

pub mod chart;
pub mod report;
pub mod run;
