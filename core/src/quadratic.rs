//! A quadratic model of a cost about a pose.

use nalgebra::{Cholesky, Vector5};

use crate::information::Information;
use crate::scalar::Scalar;

/// Slope of a cost by the five unknowns at a pose, and the information there: half its curvature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Quadratic<T> {
    /// 1/rad^2.
    pub(crate) information: Information<T>,
    /// 1/rad.
    pub(crate) gradient: Vector5<T>,
}

impl<T: Scalar> Quadratic<T> {
    pub(crate) const ZERO: Self = Self {
        information: Information::ZERO,
        gradient: Vector5::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO),
    };

    /// Adds a residual `r` of weight `w` with its derivatives.
    pub(crate) fn add_row(&mut self, w: T, r: T, jacobian: &[T; 5]) {
        self.information.add_outer(w, jacobian);
        let weighted = w * r;
        self.gradient.iter_mut().zip(jacobian).for_each(|(sum, j)| *sum += weighted * *j);
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.information.add(&other.information);
        self.gradient += other.gradient;
    }

    pub(crate) fn less(&self, other: &Self) -> Self {
        Self {
            information: self.information.less(&other.information),
            gradient: self.gradient - other.gradient,
        }
    }

    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self { information: self.information.scaled(factor), gradient: self.gradient * factor }
    }

    /// The same model about a pose `d` away.
    pub(crate) fn about(&self, d: &Vector5<T>) -> Self {
        Self { information: self.information, gradient: self.gradient + self.information.times(d) }
    }

    /// The step to the optimum, `None` if a direction is free.
    pub(crate) fn step(&self) -> Option<Vector5<T>> {
        self.information.damped_step(T::ZERO, &self.gradient.into())
    }

    /// With a prior about the pose itself.
    pub(crate) fn with(&self, prior: &Information<T>) -> Self {
        let mut joint = *self;
        joint.information.add(prior);
        joint
    }

    /// How far the optima of two models about one pose lie apart: squared, over its expected size
    /// (chi square of five degrees of freedom if both tell the truth).
    ///
    /// `None` if a direction is free in either.
    pub(crate) fn distance(&self, other: &Self) -> Option<T> {
        let apart = self.step()? - other.step()?;
        let covariance = self.information.covariance()? + other.information.covariance()?;
        squared_over(&apart, covariance)
    }
}

/// `y^T C^-1 y`, of unknowns of very different size; `None` if `C` is not a covariance.
pub(crate) fn squared_over<T: Scalar>(
    y: &Vector5<T>,
    covariance: nalgebra::Matrix5<T>,
) -> Option<T> {
    let scale = covariance.diagonal().map(|c| T::ONE / c.sqrt());
    let unit = covariance.component_mul(&(scale * scale.transpose()));
    let y = y.component_mul(&scale);
    let squared = y.dot(&Cholesky::new(unit)?.solve(&y));
    squared.is_finite().then_some(squared)
}
