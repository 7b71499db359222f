//! Links only if no panic is reachable from any public function of the core in `f32`.
//!
//! The program calls every public function with
//! inputs from `black_box`, except `Debug` and `Display`: `core::fmt` itself can panic. It defines no
//! allocator, so nothing in it can allocate. Not meant to be run.

#![no_std]
#![no_main]

mod cameras;
mod detector;
mod facade;
mod geometry;
mod link;
mod memory;
mod solver;
mod store;
mod witness;

use core::hint::black_box;

use stereo_selfcal::{Config, ConfigError, LensPrior, LensTracking, Scalar};

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        if let Some(cameras) = cameras::all() {
            let configured = black_box(config().unwrap_or_default());
            facade::all(configured, cameras);
            link::all(configured, cameras);
            solver::all(&cameras);
            geometry::all(&cameras);
        }
        scalar();
    }
}

/// A number unknown to the compiler.
fn number() -> f32 {
    black_box(0.0)
}

fn numbers<const N: usize>() -> [f32; N] {
    black_box([0.0; N])
}

/// Keeps a result from being optimised away.
fn show<V>(value: V) {
    black_box(value);
}

fn config() -> Result<Config, ConfigError> {
    let start = Config::robust();
    let start = if black_box(false) { start.without_lens_prior() } else { start };
    let tracking = if black_box(false) { LensTracking::Compensate } else { LensTracking::Report };
    show(tracking.code());
    start
        .with_prior_sd_rad(number())?
        .with_fit_limit_px(number())?
        .with_max_passes(black_box(0))?
        .with_min_correspondences(black_box(0))?
        .with_noise_floor_px(number())?
        .with_lens_prior(black_box(LensPrior::WIDE))?
        .with_lens_tracking(tracking)
        .with_lens_yaw_sd_rad(number())?
        .with_rows_limit_px(number())?
        .with_depth_limit_px(number())?
        .with_coverage_limit(number())?
        .with_memory_pairs(black_box(0))?
        .with_max_correction_rad(number())
}

fn scalar() {
    show(f32::lit(black_box(0.0)));
    show(f32::count(black_box(0)));
    show(Scalar::to_f64(number()));
    show(Scalar::to_u16(number()));
    show(Scalar::bits(number()));
}
