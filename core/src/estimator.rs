//! The two methods behind one door: a pair in, a pass at a time, and what all pairs come to.

use crate::batch::Matches;
use crate::codec::{Reader, Writer};
use crate::config::{Config, Method};
use crate::correspondence::RayPair;
use crate::error::{PairError, Refusal, RestoreError};
use crate::extrinsics::Extrinsics;
use crate::fusion::MeanDirection;
use crate::gate;
use crate::huber::HuberSolver;
use crate::information::StandardDeviations;
use crate::proposal::{Doubt, Proposal};
use crate::report::PairReport;
use crate::scalar::Scalar;
use crate::supervision::{Fused, Inquiry, Lineage, State, Stillness, Subject, Supervisor};

/// Disagreement of image halves above which the baseline is not believed, and above which nothing is.
const MAX_HALVES: [f64; 2] = [3.0, 5.0];

/// What pairs are solved with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setting<'a, T: Scalar> {
    pub(crate) config: &'a Config,
    pub(crate) factory: &'a Extrinsics<T>,
    /// Mean focal length of the cameras, px.
    pub(crate) focal: T,
}

/// State of the method that the configuration names.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
pub(crate) enum Estimator<T: Scalar> {
    Paper {
        fusion: MeanDirection<T>,
        solver: Option<HuberSolver<T>>,
        /// Since it was restored no pair has been fused.
        unconfirmed: bool,
    },
    Robust {
        supervisor: Supervisor<T>,
        stillness: Stillness,
        inquiry: Inquiry<T>,
    },
}

impl<T: Scalar> Estimator<T> {
    pub(crate) const fn new(config: &Config) -> Self {
        match config.method {
            Method::Paper => Self::Paper {
                fusion: MeanDirection::new(config.angle),
                solver: None,
                unconfirmed: false,
            },
            Method::Robust => Self::Robust {
                supervisor: Supervisor::new(),
                stillness: Stillness::new(),
                inquiry: Inquiry::NONE,
            },
        }
    }

    /// Back to no pairs at all; reports of before stay stale.
    pub(crate) fn forget(&mut self, config: &Config) {
        match self {
            Self::Paper { .. } => *self = Self::new(config),
            Self::Robust { supervisor, stillness, inquiry } => {
                supervisor.forget();
                stillness.forget();
                inquiry.close();
            }
        }
    }

    /// Number of the method in a record.
    pub(crate) fn number(&self) -> u8 {
        match self {
            Self::Paper { .. } => 1,
            Self::Robust { .. } => 2,
        }
    }

    /// Whether a pair is being solved.
    pub(crate) fn is_busy(&self) -> bool {
        match self {
            Self::Paper { solver, .. } => solver.is_some(),
            Self::Robust { inquiry, .. } => inquiry.is_open(),
        }
    }

    /// Abandons the pair being solved; one that is solved may still be fused.
    pub(crate) fn abandon(&mut self) {
        match self {
            Self::Paper { solver, .. } => *solver = None,
            Self::Robust { inquiry, .. } if inquiry.is_open() => inquiry.close(),
            Self::Robust { .. } => (),
        }
    }

    /// Begins with a batch: its first pass.
    #[inline(never)]
    pub(crate) fn begin(
        &mut self,
        setting: &Setting<'_, T>,
        matches: Matches<'_, T>,
    ) -> Result<(), PairError> {
        self.abandon();
        let Setting { config, factory, focal } = *setting;
        match self {
            Self::Paper { solver, .. } => {
                begin_paper(solver, setting, matches.pairs)?;
            }
            Self::Robust { supervisor, stillness, inquiry } => {
                let needed = config.min_correspondences.into();
                let usable = u32::try_from(matches.pairs.len()).unwrap_or(u32::MAX);
                if usable < needed {
                    return Err(PairError::TooFew { usable, needed });
                }
                supervisor.begin_round();
                let lineage = Lineage::new(config, factory);
                let pairs = matches.pairs.len();
                let subject = Subject { config, focal, pairs, supervisor, lineage: &lineage };
                let repeated = stillness.note(matches.pairs, focal);
                inquiry.open(&subject, repeated);
                if let Err(error) = inquiry.advance(&subject, matches) {
                    inquiry.close();
                    return Err(error);
                }
            }
        }
        Ok(())
    }

    /// Takes one more pass, if there is one left to take; whether the pair is solved.
    #[inline(never)]
    pub(crate) fn advance(
        &mut self,
        setting: &Setting<'_, T>,
        matches: Matches<'_, T>,
    ) -> Result<bool, PairError> {
        let Setting { config, factory, focal } = *setting;
        match self {
            Self::Paper { solver, .. } => {
                let solver = solver.as_mut().ok_or(PairError::NotBegun)?;
                let solved = solver.is_done();
                if !solved {
                    solver.advance(matches.pairs);
                }
                Ok(solved)
            }
            Self::Robust { supervisor, inquiry, .. } => {
                if !inquiry.is_open() {
                    return Err(PairError::NotBegun);
                }
                let lineage = Lineage::new(config, factory);
                let pairs = matches.pairs.len();
                let subject = Subject { config, focal, pairs, supervisor, lineage: &lineage };
                if let Err(error) = inquiry.advance(&subject, matches) {
                    supervisor.note_failure(inquiry.refused());
                    inquiry.close();
                    return Err(error);
                }
                Ok(!inquiry.is_open())
            }
        }
    }

    /// What a solved pair says. Paper: takes the judging pass.
    #[inline(never)]
    pub(crate) fn report(
        &mut self,
        setting: &Setting<'_, T>,
        matches: Matches<'_, T>,
    ) -> Result<PairReport<T>, PairError> {
        match self {
            Self::Paper { solver, .. } => {
                let report = solver.as_ref().ok_or(PairError::NotBegun)?.report(matches.pairs);
                *solver = None;
                report
            }
            Self::Robust { inquiry, .. } => {
                let lineage = Lineage::new(setting.config, setting.factory);
                let finding = inquiry.finding().ok_or(PairError::NotBegun)?;
                let report = PairReport::of_finding(&finding, &lineage, setting.focal);
                if report.is_none() {
                    inquiry.close();
                }
                report.ok_or(PairError::Unobservable)
            }
        }
    }

    /// Takes a solved pair in.
    ///
    /// # Errors
    /// [`Refusal`]; the estimate is as it was.
    #[inline(never)]
    pub(crate) fn fuse(
        &mut self,
        config: &Config,
        factory: &Extrinsics<T>,
        report: &PairReport<T>,
    ) -> Result<Fused, Refusal> {
        match self {
            Self::Paper { fusion, unconfirmed, .. } => {
                fuse_mean(fusion, config, factory, report)?;
                *unconfirmed = false;
                Ok(Fused::Added)
            }
            Self::Robust { supervisor, inquiry, .. } => {
                let finding =
                    inquiry.finding().filter(|finding| report.round == Some(finding.round));
                let finding = finding.ok_or(Refusal::Stale)?;
                let lineage = Lineage::new(config, factory);
                supervisor.fuse(&finding, &lineage, |pose| {
                    let found = pose.extrinsics().map_err(|_| Refusal::NoRig)?;
                    gate::within_correction_limit(config, factory, &found)
                })
            }
        }
    }

    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        match self {
            Self::Paper { fusion, .. } => fusion.write(to),
            Self::Robust { supervisor, stillness, .. } => {
                supervisor.write(to);
                stillness.write(to);
            }
        }
    }

    /// In the place of one without pairs; after an error there are none again.
    ///
    /// # Errors
    /// [`RestoreError`].
    #[inline(never)]
    pub(crate) fn read(
        &mut self,
        config: &Config,
        factory: &Extrinsics<T>,
        from: &mut Reader<'_>,
    ) -> Result<(), RestoreError> {
        let read = match self {
            Self::Paper { fusion, unconfirmed, .. } => {
                *unconfirmed = true;
                fusion.read(from)
            }
            Self::Robust { supervisor, stillness, .. } => {
                let read = supervisor.read(from, &Lineage::new(config, factory));
                read.and_then(|()| if from.version() < 2 { Ok(()) } else { stillness.read(from) })
            }
        };
        let read = read.and_then(|()| from.end()).and_then(|()| self.check(config, factory));
        if read.is_err() {
            self.forget(config);
        }
        read
    }

    /// Whether what the pairs come to can be, and may be held.
    fn check(&self, config: &Config, factory: &Extrinsics<T>) -> Result<(), RestoreError> {
        if !self.has_pairs() {
            return Ok(());
        }
        let proposal = self.proposal(config, factory, factory).ok_or(RestoreError::Absurd)?;
        let StandardDeviations { rotation, translation } = proposal.sd;
        if !(rotation.is_finite() && translation.is_finite()) {
            return Err(RestoreError::Absurd);
        }
        gate::within_correction_limit(config, factory, &proposal.extrinsics)
            .map_err(|_| RestoreError::CorrectionLimit)
    }

    /// Whether any pair is behind the estimate.
    pub(crate) fn has_pairs(&self) -> bool {
        match self {
            Self::Paper { fusion, .. } => fusion.pairs() > 0,
            Self::Robust { supervisor, .. } => supervisor.reported().is_some(),
        }
    }

    pub(crate) fn state(&self) -> State {
        match self {
            Self::Paper { fusion, .. } if fusion.pairs() == 0 => State::Acquiring,
            Self::Paper { unconfirmed: true, .. } => State::Suspect,
            Self::Paper { .. } => State::Locked,
            Self::Robust { supervisor, .. } => supervisor.state(),
        }
    }

    /// What the pairs come to; `None` before there is anything.
    #[inline(never)]
    pub(crate) fn proposal(
        &self,
        config: &Config,
        factory: &Extrinsics<T>,
        in_use: &Extrinsics<T>,
    ) -> Option<Proposal<T>> {
        match self {
            Self::Paper { fusion, .. } => {
                let estimate = fusion.estimate()?;
                Some(Proposal {
                    extrinsics: estimate.extrinsics,
                    applicable: estimate.extrinsics,
                    pairs: estimate.pairs,
                    sd: estimate.sd,
                    covariance: None,
                    state: self.state(),
                    doubt: (!estimate.axis_is_meaningful).then_some(Doubt::Axis),
                })
            }
            Self::Robust { supervisor, .. } => {
                let filter = supervisor.reported()?;
                let lineage = Lineage::new(config, factory);
                let [baseline, everything] = MAX_HALVES.map(T::lit);
                let halves = filter.halves();
                let doubt = if halves > everything {
                    Some(Doubt::Everything)
                } else {
                    (halves > baseline).then_some(Doubt::Baseline)
                };
                let covariance = filter.reported(&lineage)?;
                let sd = StandardDeviations::of(&covariance);
                if !(sd.rotation.is_finite() && sd.translation.is_finite()) {
                    return None;
                }
                let extrinsics = filter.pose().extrinsics().ok()?;
                let applicable = if doubt == Some(Doubt::Baseline) {
                    filter.with_baseline_of(in_use)?
                } else {
                    extrinsics
                };
                Some(Proposal {
                    extrinsics,
                    applicable,
                    pairs: filter.pairs(),
                    sd,
                    covariance: Some(covariance.matrix()),
                    state: supervisor.state(),
                    doubt,
                })
            }
        }
    }
}

/// Takes a pair of the paper's preset in.
#[inline(never)]
fn fuse_mean<T: Scalar>(
    fusion: &mut MeanDirection<T>,
    config: &Config,
    factory: &Extrinsics<T>,
    report: &PairReport<T>,
) -> Result<(), Refusal> {
    gate::admit(config, factory, report)?;
    // Tried on a copy: pairs within the limit may agree on what is beyond it.
    let mut tried = fusion.clone();
    tried.add(report);
    if let Some(estimate) = tried.estimate() {
        gate::within_correction_limit(config, factory, &estimate.extrinsics)?;
    }
    *fusion = tried;
    Ok(())
}

/// Takes the first pass of the paper's solver.
#[inline(never)]
fn begin_paper<T: Scalar>(
    solver: &mut Option<HuberSolver<T>>,
    setting: &Setting<'_, T>,
    pairs: &[RayPair<T>],
) -> Result<(), PairError> {
    let Setting { config, factory, focal } = *setting;
    *solver = Some(HuberSolver::begin(config, focal, factory, pairs)?);
    Ok(())
}
