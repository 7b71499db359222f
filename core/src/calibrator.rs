//! The facade: correspondences in, extrinsics out, in three acts that stay apart.
//!
//! *Estimate* ([`Calibrator::solve_pair`], [`Calibrator::fuse`]) never touches what is in use;
//! *judge* ([`Calibrator::health`]) compares; *apply* ([`Calibrator::apply`]) is the caller's act.

use crate::batch::{Batch, Pushed};
use crate::config::Config;
use crate::correspondence::{Cameras, Correspondence};
use crate::error::{ApplyError, PairError, PushError, Refusal};
use crate::extrinsics::Extrinsics;
use crate::fusion::{FusedEstimate, Fusion};
use crate::gate;
use crate::health::Health;
use crate::pair::Solver;
use crate::report::{PairReport, SCREEN};
use crate::scalar::Scalar;

/// Online calibrator of one stereo rig, for up to `N` correspondences a pair.
///
/// Same correspondences in the same order give the same bits. No heap, no clock, no I/O. Every call
/// takes at most one pass over the batch, but for the last [`Calibrator::advance_pair`], which takes up
/// to two to judge, and [`Calibrator::solve_pair`], which takes all of them.
///
/// ```
/// use stereo_selfcal::{Calibrator, Camera, Cameras, Config, Correspondence, Intrinsics, Lens};
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// // `new` is const: a firmware puts this into a static cell, off the stack.
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust());
/// let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
/// let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// calibrator.set_cameras(Cameras { left: camera, right: camera });
/// # let matches = (0..200_u16).map(|i| {
/// #     let (u, v, d) = (700.0 + f32::from(i * 37 % 900), f32::from(i * 71 % 1100), 20.0 + f32::from(i * 13 % 97));
/// #     Correspondence { left: [u, v], right: [u - d, v + 1.5], score: 1.0, grid_step: 0.0 }
/// # });
/// for m in matches {
///     calibrator.push(&m)?; // refused: the batch is as it was
/// }
/// let pair = calibrator.solve_pair()?;
/// calibrator.fuse(&pair)?; // refused: the estimate is as it was, bit for bit
/// calibrator.clear_pair();
/// let extrinsics = calibrator.apply()?; // p_r = R p_l + t
/// assert!(pair.rms_px_after < pair.rms_px_before);
/// # let _ = extrinsics;
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Calibrator<T: Scalar, const N: usize> {
    config: Config,
    cameras: Option<Cameras<T>>,
    factory: Extrinsics<T>,
    in_use: Extrinsics<T>,
    generation: u32,
    batch: Batch<T, N>,
    solver: Option<Solver<T>>,
    fusion: Fusion<T>,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// A calibrator without cameras, at `R = I`, `t = (-1, 0, 0)`.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self {
            config,
            cameras: None,
            factory: Extrinsics::SIDE_BY_SIDE,
            in_use: Extrinsics::SIDE_BY_SIDE,
            generation: 0,
            batch: Batch::new(),
            solver: None,
            fusion: Fusion::new(&config),
        }
    }

    /// Sets both cameras and forgets all that was learnt with others.
    pub fn set_cameras(&mut self, cameras: Cameras<T>) {
        self.cameras = Some(cameras);
        self.reset();
    }

    /// Sets the extrinsics that every pair starts from, that corrections are measured from and that
    /// [`Calibrator::reset`] returns to; forgets all that was learnt.
    pub fn set_factory(&mut self, factory: Extrinsics<T>) {
        self.factory = factory;
        self.reset();
    }

    /// Back to the factory extrinsics; batch, pair and fused pairs are forgotten.
    pub fn reset(&mut self) {
        self.replace_in_use(self.factory);
        self.clear_pair();
        self.fusion = Fusion::restart(&self.config, &self.factory);
    }

    /// Offers one correspondence to the batch, which selects once it is full: two undistortions, and
    /// one scan of a full batch.
    ///
    /// # Errors
    /// [`PushError`]; the batch is as it was. [`PushError::Busy`] while a pair is being solved.
    pub fn push(&mut self, correspondence: &Correspondence<T>) -> Result<Pushed, PushError> {
        if self.solver.is_some() {
            return Err(PushError::Busy);
        }
        let cameras = self.cameras.as_ref().ok_or(PushError::NoCameras)?;
        self.batch.push(cameras, correspondence)
    }

    /// Empties the batch and abandons a pair being solved.
    pub fn clear_pair(&mut self) {
        self.batch.clear();
        self.solver = None;
    }

    /// Starts to solve the batch: the first pass. Then call [`Calibrator::advance_pair`].
    ///
    /// # Errors
    /// [`PairError`]; the batch is kept and may be added to.
    pub fn begin_pair(&mut self) -> Result<(), PairError> {
        let cameras = self.cameras.as_ref().ok_or(PairError::NoCameras)?;
        self.solver = None;
        let focal = cameras.mean_focal();
        let solver = Solver::begin(&self.config, focal, &self.factory, self.batch.pairs())?;
        self.solver = Some(solver);
        Ok(())
    }

    /// Takes one more pass; the report once the pair is solved. The batch is then free again.
    ///
    /// # Errors
    /// [`PairError`]; the batch is kept, the pair is abandoned.
    pub fn advance_pair(&mut self) -> Result<Option<PairReport<T>>, PairError> {
        let solver = self.solver.as_mut().ok_or(PairError::NotBegun)?;
        if solver.is_done() {
            let report = solver.report(self.batch.pairs());
            self.solver = None;
            return report.map(Some);
        }
        solver.advance(self.batch.pairs());
        Ok(None)
    }

    /// Solves the batch in one call. The batch is kept, for [`Calibrator::health`].
    ///
    /// # Errors
    /// [`PairError`]; the batch is kept.
    pub fn solve_pair(&mut self) -> Result<PairReport<T>, PairError> {
        self.begin_pair()?;
        // At most `max_passes - 1` trials and the judging pass.
        for _ in 0..=self.config.max_passes {
            if let Some(report) = self.advance_pair()? {
                return Ok(report);
            }
        }
        Err(PairError::NotBegun)
    }

    /// Adds a solved pair to the estimate. What is in use does not change.
    ///
    /// # Errors
    /// [`Refusal`]; the estimate is as it was, bit for bit.
    pub fn fuse(&mut self, report: &PairReport<T>) -> Result<(), Refusal> {
        gate::admit(&self.config, &self.factory, report)?;
        // Tried on a copy: weak pairs, each within the limit, may agree on what is beyond it.
        let mut fusion = self.fusion.clone();
        if !fusion.add(report) {
            return Err(Refusal::NoRig);
        }
        if let Some(estimate) = fusion.estimate() {
            gate::within_correction_limit(&self.config, &self.factory, &estimate.extrinsics)?;
        }
        self.fusion = fusion;
        Ok(())
    }

    /// Estimate over all fused pairs; `None` before the first.
    pub fn estimate(&self) -> Option<FusedEstimate<T>> {
        self.fusion.estimate()
    }

    /// RMS row offset of what is in use and of the estimate over the batch at hand. One pass.
    ///
    /// `None` without cameras, fused pairs, or matches that fit the estimate.
    pub fn health(&self) -> Option<Health<T>> {
        let focal = self.cameras.as_ref()?.mean_focal();
        let proposed = self.estimate()?.extrinsics;
        let screen = T::lit(f64::from(self.config.huber_threshold_px) * SCREEN);
        Health::over(self.batch.pairs(), &self.in_use, &proposed, focal, screen)
    }

    /// Puts the estimate into use and returns it. The generation changes if the extrinsics do.
    ///
    /// # Errors
    /// [`ApplyError`]; what is in use stays.
    pub fn apply(&mut self) -> Result<Extrinsics<T>, ApplyError> {
        if self.fusion.pairs() == 0 {
            return Err(ApplyError::NoProposal);
        }
        let proposed = self.estimate().ok_or(ApplyError::Inconsistent)?.extrinsics;
        self.replace_in_use(proposed);
        Ok(proposed)
    }

    /// The extrinsics in use: `p_r = R p_l + t`.
    pub fn in_use(&self) -> &Extrinsics<T> {
        &self.in_use
    }

    /// Changes exactly when the extrinsics in use do; wraps around.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// The batch at hand.
    pub fn batch(&self) -> &Batch<T, N> {
        &self.batch
    }

    /// The cameras, once set.
    pub fn cameras(&self) -> Option<&Cameras<T>> {
        self.cameras.as_ref()
    }

    fn replace_in_use(&mut self, extrinsics: Extrinsics<T>) {
        if self.in_use != extrinsics {
            self.in_use = extrinsics;
            self.generation = self.generation.wrapping_add(1);
        }
    }
}
