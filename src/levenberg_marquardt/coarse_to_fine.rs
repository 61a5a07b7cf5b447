//! One problem on several levels, the coarsest first.

use std::ops::{ControlFlow, Deref};

use crate::allocation::reserved;
use crate::error::{Error, Result};
use crate::levenberg_marquardt::{LevenbergMarquardt, Solution, Step, Stop};
use crate::normal_equations::NormalEquations;

/// Most levels: the coarsest voxels and pixels are 64 times as large.
pub const MAX_LEVELS: usize = 7;

/// How a problem is solved level by level: what is far off is found on coarse levels, where the loss has one valley, and each
/// result is the next level's start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseToFine {
    /// On all levels but the finest, whose result is only a start.
    pub coarse: LevenbergMarquardt,
    /// On the finest level.
    pub fine: LevenbergMarquardt,
}

impl Default for CoarseToFine {
    /// On the finest level until a step is some hundredth of a standard deviation: below that, the loss of a sum of samples has
    /// kinks. At most 50 steps on each.
    fn default() -> Self {
        let method = LevenbergMarquardt {
            max_iterations: 50,
            gradient_tolerance: 1e-7,
            ..LevenbergMarquardt::default()
        };
        Self {
            coarse: LevenbergMarquardt { reduction_tolerance: 1e-3, ..method },
            fine: LevenbergMarquardt { reduction_tolerance: 1e-8, ..method },
        }
    }
}

/// What each level found, the coarsest first: its steps with their losses, and why it ended. There is at least one.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels<const N: usize> {
    solutions: Vec<Solution<N>>,
}

/// The problem on one level.
pub(crate) trait Level<const N: usize> {
    /// Gets ready to start from these parameters.
    fn begin(&mut self, start: &[f64; N]) -> Result<()>;

    /// Residuals' sums.
    fn evaluate(&self, parameters: &[f64; N]) -> Result<NormalEquations<N>>;
}

impl CoarseToFine {
    /// The parameters, from `start`, at which the finest level's loss is least. `report` gets the level, 0 the coarsest, and
    /// each step; where it breaks, no level follows.
    ///
    /// # Errors
    /// As [`LevenbergMarquardt::minimise`], and as the levels'; `InvalidArgument` without a level.
    pub(crate) fn minimise<const N: usize>(
        &self,
        levels: &mut [impl Level<N>],
        start: [f64; N],
        report: &mut dyn FnMut(usize, &Step<N>) -> ControlFlow<()>,
    ) -> Result<Levels<N>> {
        let count = levels.len();
        if count == 0 {
            return Err(Error::invalid("levels", 0, "at least one on which pixels count"));
        }
        let mut parameters = start;
        let mut solutions: Vec<Solution<N>> = reserved(count, "the levels")?;
        for (number, level) in levels.iter_mut().enumerate() {
            level.begin(&parameters)?;
            let method = if number + 1 < count { self.coarse } else { self.fine };
            let evaluate = |parameters: &[f64; N]| level.evaluate(parameters);
            let solution = method.minimise(parameters, evaluate, &mut |step| report(number, step))?;
            parameters = solution.parameters;
            let cancelled = solution.stop == Stop::Cancelled;
            solutions.push(solution);
            if cancelled {
                break;
            }
        }
        Ok(Levels { solutions })
    }
}

impl<const N: usize> Levels<N> {
    /// The last one's, which is the finest unless the report broke.
    ///
    /// # Panics
    /// Never: there is always one level.
    pub fn finest(&self) -> &Solution<N> {
        &self.solutions[self.solutions.len() - 1]
    }

    /// Evaluations on all of them.
    pub fn evaluations(&self) -> usize {
        self.solutions.iter().map(|level| level.steps.len()).sum()
    }
}

impl<const N: usize> Deref for Levels<N> {
    type Target = [Solution<N>];

    fn deref(&self) -> &[Solution<N>] {
        &self.solutions
    }
}

/// Refuses no level, and more than `most`, of `what`.
pub(crate) fn check_levels(levels: usize, most: usize, what: &str) -> Result<()> {
    if (1..=most).contains(&levels) {
        Ok(())
    } else {
        Err(Error::invalid("levels", levels, format!("1 … {most}{what}")))
    }
}
