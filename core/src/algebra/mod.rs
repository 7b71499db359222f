//! Fixed-size linear algebra: packed symmetric matrices, normal equations, epipolar moments.

pub(crate) mod block_variances;
mod change_frame;
pub(crate) mod disparity_noise;
pub(crate) mod framed_moments;
pub(crate) mod information;
pub(crate) mod lens_prior;
pub(crate) mod lens_terms;
pub(crate) mod moments;
pub(crate) mod normal_equations;
pub(crate) mod prior_moments;
pub(crate) mod symmetric5;
