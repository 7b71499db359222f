//! A calibrator in storage of the caller.

use core::mem::{self, MaybeUninit};

use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, ConfigError, Extrinsics, FactoryCalibration, Fused,
    Intrinsics, Lens, Outcome, PairReport, Rejection,
};

use crate::capacity::{
    SELFCAL_CAPACITY, SELFCAL_STORAGE_ALIGN, SELFCAL_STORAGE_SIZE, SELFCAL_STORAGE_WORDS,
};
use crate::error::selfcal_error_t;
use crate::marked::{self, Marked};

/// A calibrator of one stereo rig, owned by the caller, in static memory or elsewhere. It holds no
/// pointers and needs no release. One call at a time; calibrators are independent.
///
/// Of storage that is overwritten, each call notices two things: other first 12 bytes (name and size), and a length
/// beyond its array. Then it does nothing, and returns `SELFCAL_ERROR_NOT_INITIALISED`. Other wrong bits are not
/// noticed, and what a call does with them is undefined: protect the memory, or call `selfcal_init` again.
#[repr(C)]
pub struct selfcal_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_STORAGE_WORDS],
}

const _: () = assert!(size_of::<Instance>() <= size_of::<selfcal_t>());
const _: () = assert!(size_of::<selfcal_t>() == SELFCAL_STORAGE_SIZE);
const _: () = assert!(align_of::<Instance>() <= SELFCAL_STORAGE_ALIGN);

/// Content of an initialised `selfcal_t`.
#[repr(C)]
pub(crate) struct Instance {
    magic: [u32; 3],
    pub(crate) calibrator: Calibrator<f32, SELFCAL_CAPACITY>,
    /// Report of the last solved pair, and how it was fused, until that is read.
    pub(crate) solved: Option<PairReport<f32>>,
    pub(crate) fused: Option<Result<Fused, Rejection>>,
    config: Config,
    known: Known,
    factory: FactoryCalibration<f32>,
    /// Whether its cameras have been set, and its extrinsics been measured.
    has_cameras: bool,
    is_measured: bool,
}

/// What a configuration tells of the factory calibration: deviation of its yaw, rad, and length of the baseline, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known {
    pub(crate) yaw_sd_rad: Option<f32>,
    pub(crate) baseline_m: Option<f32>,
}

impl Known {
    pub(crate) const DEFAULT: Self = Self { yaw_sd_rad: Some(8.7e-4), baseline_m: None };

    /// A factory calibration with what is known of it. Numbers have been checked.
    pub(crate) fn of(
        self,
        factory: FactoryCalibration<f32>,
        is_measured: bool,
    ) -> Result<FactoryCalibration<f32>, ConfigError> {
        let factory = match self.yaw_sd_rad.filter(|_| is_measured) {
            Some(rad) => factory.with_yaw_sd_rad(rad)?,
            None => factory.without_yaw(),
        };
        self.baseline_m.map_or(Ok(factory), |metres| factory.with_baseline_m(metres))
    }
}

/// In place of cameras until they are set: nothing is pushed before.
fn no_cameras() -> Result<Cameras<f32>, selfcal_error_t> {
    let intrinsics = Intrinsics { focal: [1.0; 2], principal: [0.5; 2], size: [2; 2] };
    let camera = Camera::try_new(intrinsics, Lens::Pinhole);
    let camera = camera.map_err(|_| selfcal_error_t::SELFCAL_ERROR_UNKNOWN)?;
    Ok(Cameras { left: camera, right: camera })
}

impl Instance {
    /// The factory calibration, once cameras are set.
    pub(crate) fn given(&self) -> Result<&FactoryCalibration<f32>, selfcal_error_t> {
        let found = self.has_cameras.then_some(&self.factory);
        found.ok_or(selfcal_error_t::SELFCAL_ERROR_NO_CAMERAS)
    }

    pub(crate) fn set_cameras(&mut self, cameras: Cameras<f32>) {
        let is_first = !mem::replace(&mut self.has_cameras, true);
        self.factory.cameras = cameras;
        self.begin(is_first);
    }

    pub(crate) fn set_factory(&mut self, extrinsics: Extrinsics<f32>) {
        self.is_measured = true;
        self.factory.extrinsics = extrinsics;
        self.begin(false);
    }

    fn begin(&mut self, is_first: bool) {
        let factory = self.known.of(self.factory, self.is_measured).unwrap_or(self.factory);
        self.replace(factory, is_first);
    }

    pub(crate) fn install(&mut self, factory: FactoryCalibration<f32>) {
        let is_first = !mem::replace(&mut self.has_cameras, true);
        self.is_measured = factory.yaw_sd_rad().is_some();
        let (yaw_sd_rad, baseline_m) = (factory.yaw_sd_rad(), factory.baseline_m());
        self.known = Known { yaw_sd_rad, baseline_m };
        self.replace(factory, is_first);
    }

    /// Begins anew. The first cameras leave the generation at 0: nothing was in use before.
    #[inline(never)]
    fn replace(&mut self, factory: FactoryCalibration<f32>, is_first: bool) {
        self.factory = factory;
        self.forget_pair();
        if is_first {
            self.calibrator.install_first(&self.factory);
        } else {
            self.calibrator.install(&self.factory);
        }
    }

    pub(crate) fn forget_pair(&mut self) {
        (self.solved, self.fused) = (None, None);
    }

    /// Takes a step of the pair; whether it is solved.
    pub(crate) fn advance(&mut self) -> Result<bool, selfcal_error_t> {
        self.forget_pair();
        match self.calibrator.advance_pair() {
            None => Ok(false),
            Some(outcome) => self.end(outcome).map(|()| true),
        }
    }

    /// Keeps what became of a pair.
    pub(crate) fn end(
        &mut self,
        Outcome { pair, fused }: Outcome<f32>,
    ) -> Result<(), selfcal_error_t> {
        self.forget_pair();
        if pair.is_none() {
            return fused.map(|_| ()).map_err(Into::into);
        }
        (self.solved, self.fused) = (pair, Some(fused));
        Ok(())
    }
}

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Instance {
    /// "SELFCAL1".
    const NAME: [u32; 2] = [0x5345_4C46, 0x4341_4C31];
}

/// Checks the storage and writes a new calibrator into it.
///
/// # Safety
/// `storage` is null or points to `size` bytes that the caller owns.
pub(crate) unsafe fn place(
    storage: *mut selfcal_t,
    size: usize,
    (config, known): (Config, Known),
) -> Result<(), selfcal_error_t> {
    let place = storage.cast::<Instance>();
    marked::check_place(place, size)?;
    let factory = FactoryCalibration::guess(no_cameras()?);
    // SAFETY: not null, aligned and large enough. Field by field: keeps the whole off the stack.
    unsafe {
        (&raw mut (*place).calibrator).write(Calibrator::new(config, &factory));
        (&raw mut (*place).solved).write(None);
        (&raw mut (*place).fused).write(None);
        (&raw mut (*place).config).write(config);
        (&raw mut (*place).known).write(known);
        (&raw mut (*place).factory).write(factory);
        (&raw mut (*place).has_cameras).write(false);
        (&raw mut (*place).is_measured).write(false);
        (&raw mut (*place).magic).write(Instance::MAGIC);
    }
    Ok(())
}

/// The calibrator in a storage, exclusively.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn exclusive<'a>(
    storage: *mut selfcal_t,
) -> Result<&'a mut Instance, selfcal_error_t> {
    // SAFETY: the contract of the crate; storage is as large as `Instance`.
    let instance: &mut Instance = unsafe { marked::exclusive(storage.cast()) }?;
    check_lengths(instance)?;
    Ok(instance)
}

/// The calibrator in a storage, read only.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn shared<'a>(
    storage: *const selfcal_t,
) -> Result<&'a Instance, selfcal_error_t> {
    // SAFETY: as above.
    let instance: &Instance = unsafe { marked::shared(storage.cast()) }?;
    check_lengths(instance)?;
    Ok(instance)
}

/// Refuses lengths beyond their arrays: an access would leave the storage.
fn check_lengths(instance: &Instance) -> Result<(), selfcal_error_t> {
    let valid = instance.calibrator.has_valid_lengths();
    if valid { Ok(()) } else { Err(selfcal_error_t::SELFCAL_ERROR_NOT_INITIALISED) }
}
