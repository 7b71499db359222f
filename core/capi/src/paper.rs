//! The published method, separate from the calibrator: a reference and a baseline for comparison.

use core::mem::MaybeUninit;

use stereo_selfcal::ConfigError;
use stereo_selfcal::paper::{Central, FusedEstimate, PaperCalibrator, Settings};
use zerocopy::FromBytes;

use crate::capacity::{SELFCAL_CAPACITY, SELFCAL_STORAGE_ALIGN};
use crate::config::given;
use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::estimate::selfcal_sd_t;
use crate::extrinsics::selfcal_extrinsics_t;
use crate::factory::{factory, selfcal_factory_t};
use crate::marked::{self, Marked};
use crate::pair::{end, selfcal_outcome_t};
use crate::pointer::{Out, read, read_array};
use crate::push::selfcal_correspondence_t;

/// Size of `selfcal_paper_t` in words of 8 bytes, sufficient on every target.
pub const SELFCAL_PAPER_WORDS: usize = 260 + 23 * SELFCAL_CAPACITY / 8;

/// The published method for one stereo rig, owned by the caller: no pointers, no release. One call at a time. Changed
/// storage is detected as in `selfcal_t`.
#[repr(C)]
pub struct selfcal_paper_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_PAPER_WORDS],
}

/// Content of an initialised `selfcal_paper_t`.
#[repr(C)]
struct Held {
    magic: [u32; 3],
    calibrator: PaperCalibrator<f32, SELFCAL_CAPACITY>,
}

const _: () = marked::assert_fits::<Held, selfcal_paper_t>(8 * SELFCAL_PAPER_WORDS);
const _: () = assert!(align_of::<Held>() <= SELFCAL_STORAGE_ALIGN);

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Held {
    /// "SELFPAP1".
    const NAME: [u32; 2] = [0x5345_4C46, 0x5041_5031];
}

/// Central value of the rotation angles of the pairs.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_angle_t {
    /// Arithmetic mean: efficient without outlier pairs.
    SELFCAL_ANGLE_MEAN = 0,
    /// Median: robust to a minority of outlier pairs.
    SELFCAL_ANGLE_MEDIAN = 1,
}

/// Parameters of the published method. 0 in a field stands for its default.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_paper_config_t {
    /// Largest number of passes of the solver over the batch: 2 or more; default 100. One more pass evaluates the
    /// result.
    pub max_passes: u16,
    /// Least number of usable correspondences that a pair needs: 6 or more; default 12.
    pub min_correspondences: u16,
    /// Correction limit, rad: above 0 and below 1.5; default 0.5. A pair is not fused if `R` or `t` of the pair alone, or
    /// of the estimate with the pair, differs from the factory value by a larger angle.
    pub max_correction_rad: f32,
    /// Lower bound of the estimated noise of a row offset, px: 0.001 to 100; default 0.02.
    pub noise_floor_px: f32,
    /// Huber threshold of the row offset, px: finite and above 0; default 1. A larger value lets outliers bias the
    /// result; a smaller one discards the information of good matches.
    pub huber_threshold_px: f32,
    /// Step below which the solver has converged, rad: up to 0.1; default 1e-9. A value below the resolution of `f32`,
    /// about 1e-6, acts as 1e-6.
    pub step_tolerance_rad: f32,
    /// Largest standard deviation of the least certain direction of a fused pair, rad: finite and above 0; default
    /// 0.12.
    pub max_sd_rad: f32,
    /// A `selfcal_angle_t`.
    pub angle: u32,
}

impl selfcal_paper_config_t {
    /// Returns the settings of the core. It checks all fields, because the caller may have written any bits.
    fn core(&self) -> Result<Settings, selfcal_error_t> {
        const MEDIAN: u32 = selfcal_angle_t::SELFCAL_ANGLE_MEDIAN as u32;
        let angle = match self.angle {
            0 => Central::Mean,
            MEDIAN => Central::Median,
            _ => return Err(SELFCAL_ERROR_CONFIG),
        };
        self.numbers(Settings::DEFAULT.with_angle(angle)).map_err(|_| SELFCAL_ERROR_CONFIG)
    }

    fn numbers(&self, settings: Settings) -> Result<Settings, ConfigError> {
        let settings = given(settings, self.max_passes, Settings::with_max_passes)?;
        let settings =
            given(settings, self.min_correspondences, Settings::with_min_correspondences)?;
        let settings = given(settings, self.max_correction_rad, Settings::with_max_correction_rad)?;
        let settings = given(settings, self.noise_floor_px, Settings::with_noise_floor_px)?;
        let settings = given(settings, self.huber_threshold_px, Settings::with_huber_threshold_px)?;
        let settings = given(settings, self.step_tolerance_rad, Settings::with_step_tolerance_rad)?;
        given(settings, self.max_sd_rad, Settings::with_max_sd_rad)
    }
}

/// Estimate of the published method over all fused pairs.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_paper_estimate_t {
    /// `R*`, `t*`.
    pub extrinsics: selfcal_extrinsics_t,
    /// Number of fused pairs.
    pub pairs: u32,
    /// Standard errors of the means; with one pair the standard deviations of that pair.
    pub sd: selfcal_sd_t,
    /// Length of the mean of the unit rotation axes: 1 where all pairs agree, 0 for pure noise.
    pub axis_concentration: f32,
    /// Whether the rotation has a meaningful axis: its angle is far enough from 0 and from a half turn, and the pairs
    /// agree on it.
    pub axis_is_meaningful: bool,
}

impl From<FusedEstimate<f32>> for selfcal_paper_estimate_t {
    fn from(estimate: FusedEstimate<f32>) -> Self {
        Self {
            extrinsics: (&estimate.extrinsics).into(),
            pairs: estimate.pairs,
            sd: estimate.sd.into(),
            axis_concentration: estimate.axis_concentration,
            axis_is_meaningful: estimate.axis_is_meaningful,
        }
    }
}

/// Initialises the published method. Every pair is solved from the factory extrinsics. It has no verdict, no
/// calibration in use and no records.
///
/// * `size`: size of the storage, bytes: `sizeof(selfcal_paper_t)`.
/// * `config`: copied; null for the default. `SELFCAL_ERROR_CONFIG` if a field is out of its range.
/// * `factory`: copied; only cameras and extrinsics are used.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_paper_init(
    paper: *mut selfcal_paper_t,
    size: usize,
    config: *const selfcal_paper_config_t,
    factory: *const selfcal_factory_t,
) -> selfcal_error_t {
    status(|| {
        let settings = if config.is_null() {
            Settings::DEFAULT
        } else {
            // SAFETY: the caller keeps the contract of the crate.
            unsafe { read(config) }?.core()?
        };
        // SAFETY: as above.
        let factory = unsafe { self::factory(factory) }?;
        let place = paper.cast::<Held>();
        marked::check_place(place, size)?;
        let made = PaperCalibrator::new(settings, factory.cameras, factory.extrinsics);
        // SAFETY: not null, aligned and large enough. Written field by field, so that the whole is not on the stack.
        unsafe {
            (&raw mut (*place).calibrator).write(made);
            (&raw mut (*place).magic).write(Held::MAGIC);
        }
        Ok(())
    })
}

/// Takes one stereo pair: solves an array of correspondences and fuses the result. Refused correspondences are left
/// out. An error from 500 on says why the pair is not part of the estimate, which is normal: go on with the next pair.
///
/// * `correspondences`: array of `count`; may be null if `count` is 0.
/// * `outcome`: written with these errors, too; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_paper_take_pair(
    paper: *mut selfcal_paper_t,
    correspondences: *const selfcal_correspondence_t,
    count: usize,
    outcome: *mut selfcal_outcome_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (held, all, place) = unsafe {
            let held: &mut Held = marked::exclusive(paper.cast())?;
            (held, read_array(correspondences, count)?, Out::optional(outcome)?)
        };
        check_lengths(held)?;
        end(&held.calibrator.take_pair(all.iter().map(Into::into)), place)
    })
}

/// Reads the estimate over all fused pairs. Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_paper_estimate(
    paper: *const selfcal_paper_t,
    estimate: *mut selfcal_paper_estimate_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (held, out): (&Held, _) =
            unsafe { (marked::shared(paper.cast())?, Out::checked(estimate)?) };
        check_lengths(held)?;
        out.set(held.calibrator.estimate().ok_or(SELFCAL_ERROR_NO_ESTIMATE)?.into());
        Ok(())
    })
}

/// Refuses lengths beyond their arrays, because an access would leave the storage.
fn check_lengths(held: &Held) -> Result<(), selfcal_error_t> {
    let valid = held.calibrator.has_valid_lengths();
    if valid { Ok(()) } else { Err(SELFCAL_ERROR_NOT_INITIALISED) }
}
