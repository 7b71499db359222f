//! The paper's fusion of many pairs into one estimate, in constant memory.

mod compensated;
mod mean_direction;
mod median;

pub use mean_direction::{FusedEstimate, MeanDirection};
