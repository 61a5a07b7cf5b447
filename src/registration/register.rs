//! One object is registered.

use std::ops::ControlFlow;

use crate::error::Result;
use crate::geometry::RigidMotion;
use crate::levenberg_marquardt::{CoarseToFine, Level, Levels, Step, Stop};
use crate::normal_equations::NormalEquations;
use crate::pose_gradient::Signal;
use crate::real::Real;
use crate::registration::levels::{LevelView, LevelViews, Registrar, RegistrationView};

/// How an object is registered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegistrationOptions {
    /// What measured images hold.
    pub signal: Signal,
    /// What is done on each level.
    pub levels: CoarseToFine,
}

impl Default for RegistrationOptions {
    /// Line integrals.
    fn default() -> Self {
        Self { signal: Signal::LineIntegral, levels: CoarseToFine::default() }
    }
}

/// Where an object was found to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    /// The motion at which its projections fit best.
    pub motion: RigidMotion,
    /// Of α, β, φ, t: radians and mm; see
    /// [`Solution::covariance`](crate::levenberg_marquardt::Solution::covariance). `None` where the views do not tell all six.
    pub covariance: Option<[[f64; 6]; 6]>,
    /// What each level found, the coarsest first: its steps with their losses, and why it ended.
    pub levels: Levels<6>,
}

impl Registration {
    /// The roots of the covariance's diagonal, radians and mm.
    pub fn standard_deviations(&self) -> Option<[f64; 6]> {
        self.covariance.map(|covariance| std::array::from_fn(|k| covariance[k][k].sqrt()))
    }

    /// Why the last level ended.
    pub fn stop(&self) -> Stop {
        self.levels.finest().stop
    }

    /// Evaluations on all levels.
    pub fn evaluations(&self) -> usize {
        self.levels.evaluations()
    }
}

impl<T: Real> Registrar<T> {
    /// The motion, from `start`, at which the volume's projections fit all views best in the least-squares sense, level by
    /// level. `report` gets the level, 0 the coarsest that is used, and each step; where it breaks, the result is the best so
    /// far.
    ///
    /// # Errors
    /// As [`loss_value_and_grad`](crate::pose_gradient::PoseProjector::loss_value_and_grad) and
    /// [`minimise`](crate::levenberg_marquardt::LevenbergMarquardt::minimise); `InvalidArgument` without a view.
    pub fn register(
        &self,
        views: &[RegistrationView<'_, T>],
        start: &RigidMotion,
        options: &RegistrationOptions,
        report: &mut dyn FnMut(usize, &Step<6>) -> ControlFlow<()>,
    ) -> Result<Registration> {
        start.validate().map_err(|error| error.of("start"))?;
        let mut on_levels = self.views(views, options.signal)?;
        let levels = options.levels.minimise(&mut on_levels, start.to_array(), report)?;
        let finest = levels.finest();
        let (motion, covariance) = (RigidMotion::from_array(finest.parameters), finest.covariance());
        Ok(Registration { motion, covariance, levels })
    }
}

impl<T: Real> Level<6> for LevelViews<'_, T> {
    fn begin(&mut self, _start: &[f64; 6]) -> Result<()> {
        Ok(())
    }

    /// Of all views, in their order.
    fn evaluate(&self, parameters: &[f64; 6]) -> Result<NormalEquations<6>> {
        let motion = RigidMotion::from_array(*parameters);
        let mut sum = NormalEquations::default();
        for LevelView { pose, measured, mask } in &self.views {
            let mask = mask.as_deref();
            sum.merge(&self.projector.loss_value_and_grad(pose, &motion, self.signal, measured, mask)?);
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests;
