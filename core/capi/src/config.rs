//! The configuration: a preset, changed by setters.

use stereo_selfcal::{Central, Config, ConfigError};
use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::instance::Known;
use crate::lens::{selfcal_lens_prior_t, tracking};
use crate::pointer::{Out, read};

/// Marks a configuration that a preset has filled, and its layout.
const MAGIC: u32 = 0x5343_4647;

const ROBUST: u32 = 1;
const PAPER: u32 = 2;

/// Central tendency of the pairs' angles in fusion; paper preset.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_angle_t {
    /// Arithmetic mean: efficient without outlier pairs.
    SELFCAL_ANGLE_MEAN = 0,
    /// Median: robust to a minority of outlier pairs.
    SELFCAL_ANGLE_MEDIAN = 1,
}

/// Parameters of a calibrator; fields are private. Fill it with `selfcal_config_default`,
/// `selfcal_config_robust` or `selfcal_config_paper`, then change it with the setters.
#[repr(C)]
#[derive(Debug, Clone, Copy, FromBytes)]
pub struct selfcal_config_t {
    /// Private, as all fields.
    magic: u32,
    /// Number of the preset.
    preset: u32,
    /// NaN, or 0 in an integer, stands for the value of the preset.
    prior_sd_rad: f32,
    huber_threshold_px: f32,
    step_tolerance_rad: f32,
    noise_floor_px: f32,
    max_sd_rad: f32,
    max_correction_rad: f32,
    memory_pairs: u32,
    max_passes: u16,
    min_correspondences: u16,
    angle: u32,
    /// NaN in its first field stands for the value of the preset.
    pub(crate) lens_prior: selfcal_lens_prior_t,
    pub(crate) lens_tracking: u32,
    lens_yaw_sd_rad: f32,
    /// 0 stands for a guess.
    factory_yaw_sd_rad: f32,
    baseline_m: f32,
}

impl selfcal_config_t {
    const fn of(preset: u32) -> Self {
        Self {
            magic: MAGIC,
            preset,
            prior_sd_rad: f32::NAN,
            huber_threshold_px: f32::NAN,
            step_tolerance_rad: f32::NAN,
            noise_floor_px: f32::NAN,
            max_sd_rad: f32::NAN,
            max_correction_rad: f32::NAN,
            memory_pairs: 0,
            max_passes: 0,
            min_correspondences: 0,
            angle: 0,
            lens_prior: selfcal_lens_prior_t {
                focal: f32::NAN,
                principal_px: 0.0,
                k1: 0.0,
                p1: 0.0,
                p2: 0.0,
            },
            lens_tracking: 0,
            lens_yaw_sd_rad: f32::NAN,
            factory_yaw_sd_rad: f32::NAN,
            baseline_m: f32::NAN,
        }
    }

    /// What it tells of the factory calibration; any bits are checked.
    pub(crate) fn known(&self) -> Result<Known, selfcal_error_t> {
        let given = |number: f32| (!number.is_nan()).then_some(number);
        let yaw = given(self.factory_yaw_sd_rad).or(Known::DEFAULT.yaw_sd_rad);
        let known =
            Known { yaw_sd_rad: yaw.filter(|rad| *rad != 0.0), baseline_m: given(self.baseline_m) };
        check(known)?;
        Ok(known)
    }

    /// The configuration of the core; any bits are checked.
    pub(crate) fn core(&self) -> Result<Config, selfcal_error_t> {
        let preset = match (self.magic, self.preset) {
            (MAGIC, ROBUST) => Config::robust(),
            (MAGIC, PAPER) => Config::paper(),
            _ => return Err(SELFCAL_ERROR_CONFIG_NOT_INITIALISED),
        };
        let config = preset
            .with_angle(central(self.angle)?)
            .with_lens_tracking(tracking(self.lens_tracking)?);
        let config = real(config, self.prior_sd_rad, Config::with_prior_sd_rad)?;
        let config = real(config, self.huber_threshold_px, Config::with_huber_threshold_px)?;
        let config = real(config, self.step_tolerance_rad, Config::with_step_tolerance_rad)?;
        let config = real(config, self.noise_floor_px, Config::with_noise_floor_px)?;
        let config = real(config, self.max_sd_rad, Config::with_max_sd_rad)?;
        let config = real(config, self.max_correction_rad, Config::with_max_correction_rad)?;
        let config = real(config, self.lens_yaw_sd_rad, Config::with_lens_yaw_sd_rad)?;
        let config = whole(config, self.memory_pairs, Config::with_memory_pairs)?;
        let config = if self.lens_prior.focal.is_nan() {
            config
        } else {
            config.with_lens_prior(self.lens_prior.into())?
        };
        let config = whole(config, self.max_passes, Config::with_max_passes)?;
        Ok(whole(config, self.min_correspondences, Config::with_min_correspondences)?)
    }
}

fn check(known: Known) -> Result<Config, ConfigError> {
    let baseline_ok = known.baseline_m.is_none_or(|m| (1e-3..=1e3).contains(&m));
    let yaw_ok = known.yaw_sd_rad.is_none_or(|rad| (1e-6..=1.0).contains(&rad));
    match (baseline_ok, yaw_ok) {
        (true, true) => Ok(Config::robust()),
        (false, _) => Err(ConfigError::BaselineLength),
        (_, false) => Err(ConfigError::FactoryYaw),
    }
}

fn real(
    config: Config,
    value: f32,
    with: impl FnOnce(Config, f32) -> Result<Config, ConfigError>,
) -> Result<Config, ConfigError> {
    if value.is_nan() { Ok(config) } else { with(config, value) }
}

fn whole<N: Default + PartialEq>(
    config: Config,
    value: N,
    with: impl FnOnce(Config, N) -> Result<Config, ConfigError>,
) -> Result<Config, ConfigError> {
    if value == N::default() { Ok(config) } else { with(config, value) }
}

fn central(angle: u32) -> Result<Central, selfcal_error_t> {
    const MEAN: u32 = selfcal_angle_t::SELFCAL_ANGLE_MEAN as u32;
    const MEDIAN: u32 = selfcal_angle_t::SELFCAL_ANGLE_MEDIAN as u32;
    match angle {
        MEAN => Ok(Central::Mean),
        MEDIAN => Ok(Central::Median),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// # Safety
/// The contract of the crate.
unsafe fn fill(config: *mut selfcal_config_t, preset: u32) -> selfcal_error_t {
    status(|| {
        // SAFETY: the contract of the crate.
        unsafe { Out::checked(config) }?.set(selfcal_config_t::of(preset));
        Ok(())
    })
}

/// Changes an initialised configuration, if the core accepts the value.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn change<E: Into<selfcal_error_t>, C>(
    config: *mut selfcal_config_t,
    checked: Result<C, E>,
    edit: impl FnOnce(&mut selfcal_config_t),
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the contract of the crate.
        let (mut changed, place) = unsafe { (read(config)?, Out::checked(config)?) };
        changed.core()?;
        checked.map_err(Into::into)?;
        edit(&mut changed);
        place.set(changed);
        Ok(())
    })
}

/// Fills a configuration with the default, the robust preset.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_default(config: *mut selfcal_config_t) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { fill(config, ROBUST) }
}

/// Fills a configuration with the robust preset: tolerates half of the matches as outliers, and
/// follows a step of the extrinsics within three pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_robust(config: *mut selfcal_config_t) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { fill(config, ROBUST) }
}

/// Fills a configuration with the published method, whose only defence against outliers is the Huber
/// weight.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_paper(config: *mut selfcal_config_t) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { fill(config, PAPER) }
}

/// Sets the standard deviation of the prior at the factory extrinsics, about each axis; robust preset.
///
/// * `rad`: 1e-4 to 1; default 0.1. Larger allows larger corrections; smaller stabilises pairs with
///   little information.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_prior_sd_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_prior_sd_rad(rad);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.prior_sd_rad = rad) }
}

/// Sets the standard deviation of the yaw of the factory extrinsics, which depth rests on until the rig changes; robust
/// preset.
///
/// * `rad`: 1e-6 to 1; default 8.7e-4 (0.05 degrees), of a calibration with boards. 0: the factory extrinsics are a
///   guess, and yaw is that of the rows, uncertain by the lens.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_factory_yaw_sd_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let yaw_sd_rad = Some(rad).filter(|rad| *rad != 0.0);
    let checked = check(Known { yaw_sd_rad, ..Known::DEFAULT });
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.factory_yaw_sd_rad = rad) }
}

/// Sets the standard deviation of the apparent yaw of the lenses: of `a`, where rows are off by `a x y` at unit depth.
///
/// * `rad`: 0 to 0.1; default 4.6e-3.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_lens_yaw_sd_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_lens_yaw_sd_rad(rad);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.lens_yaw_sd_rad = rad) }
}

/// Sets the length of the baseline by the factory calibration, which `selfcal_push_range` needs.
///
/// * `metres`: 1e-3 to 1e3; default none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_baseline_m(
    config: *mut selfcal_config_t,
    metres: f32,
) -> selfcal_error_t {
    let checked = check(Known { baseline_m: Some(metres), ..Known::DEFAULT });
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.baseline_m = metres) }
}

/// Sets the Huber threshold of the row offset in the paper preset. In both presets a match fits,
/// for the health, within three thresholds.
///
/// * `px`: finite and above 0; default 1. Larger uses more matches and admits more outliers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_huber_threshold_px(
    config: *mut selfcal_config_t,
    px: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_huber_threshold_px(px);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.huber_threshold_px = px) }
}

/// Sets the largest number of passes over the batch, the bound on the time of a pair.
///
/// * `passes`: 2 or more; default 24 in the robust preset, 100 in the paper preset. The robust preset
///   takes up to 9 if it is lower.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_max_passes(
    config: *mut selfcal_config_t,
    passes: u16,
) -> selfcal_error_t {
    let checked = Config::robust().with_max_passes(passes);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.max_passes = passes) }
}

/// Sets the step below which the solver has converged.
///
/// * `rad`: 0 to 0.1; default 1e-9. Values below 1e-6 act as 1e-6.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_step_tolerance_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_step_tolerance_rad(rad);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.step_tolerance_rad = rad) }
}

/// Sets the fewest usable correspondences of a pair.
///
/// * `count`: 6 or more; default 12.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_min_correspondences(
    config: *mut selfcal_config_t,
    count: u16,
) -> selfcal_error_t {
    let checked = Config::robust().with_min_correspondences(count);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.min_correspondences = count) }
}

/// Sets the lower bound on the estimated noise, which keeps the information finite on data without
/// noise.
///
/// * `px`: finite and above 0; default 0.15 of a coordinate in the robust preset, 0.02 of a row
///   offset in the paper preset.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_noise_floor_px(
    config: *mut selfcal_config_t,
    px: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_noise_floor_px(px);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.noise_floor_px = px) }
}

/// Sets the central tendency of the pairs' angles in fusion; paper preset.
///
/// * `angle`: a `selfcal_angle_t`; default the mean.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_angle(
    config: *mut selfcal_config_t,
    angle: u32,
) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, central(angle), |c| c.angle = angle) }
}

/// Sets the largest standard deviation of the weakest direction of a fused pair; paper preset.
///
/// * `rad`: finite and above 0; default 0.12.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_max_sd_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_max_sd_rad(rad);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.max_sd_rad = rad) }
}

/// Sets the largest distance of a fused pair from the factory extrinsics.
///
/// * `rad`: above 0 and below 1.5; default 0.5.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_max_correction_rad(
    config: *mut selfcal_config_t,
    rad: f32,
) -> selfcal_error_t {
    let checked = Config::robust().with_max_correction_rad(rad);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.max_correction_rad = rad) }
}

/// Sets the number of pairs after which the oldest fade; robust preset.
///
/// * `pairs`: 20 or more; default 1000. Larger averages longer; smaller follows a slow drift.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_memory_pairs(
    config: *mut selfcal_config_t,
    pairs: u32,
) -> selfcal_error_t {
    let checked = Config::robust().with_memory_pairs(pairs);
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.memory_pairs = pairs) }
}

/// Sets how far the given lens models are trusted; robust preset. The deviations with the lens uncertain
/// cover such errors; all 0 takes the lens models as exact, and image halves that disagree then block.
///
/// * `prior`: each from 0 to 0.1, of the principal point 0 to 100 px; default 0.003, 1 px, 0.005, 0.001,
///   0.00025.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_lens_prior(
    config: *mut selfcal_config_t,
    prior: selfcal_lens_prior_t,
) -> selfcal_error_t {
    let checked = Config::robust().with_lens_prior(prior.into());
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, checked, |c| c.lens_prior = prior) }
}

/// Sets what is done about errors of the given lens models; robust preset with a lens prior.
///
/// * `lens_tracking`: a `selfcal_lens_tracking_t`; default to report them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_config_set_lens_tracking(
    config: *mut selfcal_config_t,
    lens_tracking: u32,
) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate.
    unsafe { change(config, tracking(lens_tracking), |c| c.lens_tracking = lens_tracking) }
}
