//! One view of a parallel beam is aligned.

use std::ops::ControlFlow;

use crate::alignment::pyramid::Pyramid;
use crate::alignment::weighted::Weighted;
use crate::allocation::collected;
use crate::error::Result;
use crate::levenberg_marquardt::{CoarseToFine, Levels, LevenbergMarquardt, Step, Stop};
use crate::parallel::ViewParameters;
use crate::real::Real;

/// How a view is aligned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlignmentOptions {
    /// What is done on each level.
    pub levels: CoarseToFine,
    /// Whether images are line integrals p = −ln(N/N0) of N photons, whose variance is 1/N, so that residuals count by N
    /// (Sauer & Bouman, IEEE Trans. Signal Process. 41(2), 534, 1993): by exp(−p) of the projection that a level starts
    /// from, relative to the mean. Thick paths are noisy.
    pub photons: bool,
}

impl Default for AlignmentOptions {
    /// A parameter whose derivatives are a millionth of the others' is without influence.
    fn default() -> Self {
        let CoarseToFine { coarse, fine } = CoarseToFine::default();
        let [coarse, fine] = [coarse, fine].map(|method| LevenbergMarquardt { negligible: 1e-6, ..method });
        Self { levels: CoarseToFine { coarse, fine }, photons: false }
    }
}

/// Where a view was found to be.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// The parameters at which its projection fits best.
    pub parameters: ViewParameters,
    /// α, β, φ, Δx, Δz, radians and mm, from the residuals, whose variances may differ from pixel to pixel (White,
    /// Econometrica 48(4), 817, 1980, eq. 5): thick paths are noisier. `None` where the image does not tell all five.
    pub standard_deviations: Option<[f64; ViewParameters::COUNT]>,
    /// What each level found, the coarsest first.
    pub levels: Levels<{ ViewParameters::COUNT }>,
}

impl Alignment {
    /// Why the last level ended.
    pub fn stop(&self) -> Stop {
        self.levels.finest().stop
    }

    /// Evaluations on all levels.
    pub fn evaluations(&self) -> usize {
        self.levels.evaluations()
    }
}

impl<T: Real> Pyramid<T> {
    /// The parameters, from `start`, at which the volume's projection fits `measured` best in the least-squares sense, level
    /// by level. Of a `mask`, pixels that are `false` take no part; they may be NaN. `report` gets the level, 0 the coarsest,
    /// and each step; where it breaks, the result is the best so far.
    ///
    /// # Errors
    /// As [`crate::parallel::ParallelProjector::view_loss_value_and_grad`] and [`LevenbergMarquardt::minimise`].
    pub fn align_view(
        &self,
        measured: &[T],
        mask: Option<&[bool]>,
        start: &ViewParameters,
        options: &AlignmentOptions,
        report: &mut dyn FnMut(usize, &Step<{ ViewParameters::COUNT }>) -> ControlFlow<()>,
    ) -> Result<Alignment> {
        start.validate()?;
        let measured = self.measured(measured, mask)?;
        let on_level = measured.iter().map(|measured| Weighted::new(measured, options.photons));
        let mut weighted = collected(on_level, "the levels")?;
        let levels = options.levels.minimise(&mut weighted, start.to_array(), report)?;
        let finest = levels.finest();
        let standard_deviations = weighted[levels.len() - 1].standard_deviations(finest)?;
        let parameters = ViewParameters::from_array(finest.parameters);
        Ok(Alignment { parameters, standard_deviations, levels })
    }
}

#[cfg(test)]
mod tests;
