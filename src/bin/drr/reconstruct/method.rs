//! How a volume is reconstructed.

use std::ops::ControlFlow;
use std::time::Instant;

use anyhow::{Context as _, Result, bail};
use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use drr::parallel::{ParallelOperator, Quadrature};
use drr::reconstruction::{Cgls, Iteration, Problem, Sirt, cgls, sirt};
use drr::{Algorithm, Context, LinearOperator, RayTransform};

use super::acquisition::Geometry;
use super::{Scan, within};
use crate::algorithm::{AlgorithmName, STEP_OF_A_MARCH};
use crate::console::Console;
use crate::rms::rmse;
use crate::value;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(super) struct MethodArguments {
    /// How residuals correct the volume
    #[arg(long, value_enum, default_value = "cgls")]
    pub(super) method: MethodName,
    /// Iterations [default: 10 of cgls, 60 of sirt]
    #[arg(long, value_name = "N", value_parser = iterations)]
    iterations: Option<usize>,
    /// How line integrals are taken
    #[arg(long, value_enum, default_value = "joseph")]
    pub(super) algorithm: OperatorName,
    /// Step of the march in voxels along the driving axis, 1/64 to 8 [default: 0.5]
    #[arg(long, value_name = "VOXELS", value_parser = value::step, allow_negative_numbers = true)]
    step: Option<f64>,
    /// Keep values from turning negative; with --method sirt
    #[arg(long)]
    pub(super) non_negative: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum MethodName {
    /// Back-projected residuals, weighted by rows and columns
    Sirt,
    /// Conjugate gradients; in each iteration the residual falls as far as it can
    Cgls,
}

/// What projects: an algorithm on any rays, or the sums of samples of a parallel beam.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OperatorName {
    Rays(AlgorithmName),
    Steps,
}

impl ValueEnum for OperatorName {
    fn value_variants<'a>() -> &'a [Self] {
        &[
            Self::Rays(AlgorithmName::Joseph),
            Self::Rays(AlgorithmName::March),
            Self::Rays(AlgorithmName::Siddon),
            Self::Rays(AlgorithmName::DistanceDriven),
            Self::Rays(AlgorithmName::Exact),
            Self::Steps,
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Rays(name) => name.to_possible_value(),
            Self::Steps => Some(
                PossibleValue::new("steps")
                    .help("Trilinear samples at equal steps of a voxel along the beam, which is parallel"),
            ),
        }
    }
}

const STEPS_IN_A_CONE: &str =
    "--algorithm is steps; valid with a cone beam: joseph, march, siddon, distance_driven, exact";

fn iterations(text: &str) -> Result<usize, String> {
    within(text, 1, 100_000)
}

/// A volume, and how it came about.
pub(super) struct Found {
    /// 1/mm.
    pub(super) volume: Vec<f32>,
    /// After the first iteration, which is a multiple of the back-projection.
    pub(super) first: Vec<f32>,
    /// ‖b − A x‖/‖b‖ after each iteration.
    pub(super) residuals: Vec<f64>,
    /// Root mean square difference to the truth after each, HU; none where it is not known.
    pub(super) rmse_hu: Vec<f64>,
    pub(super) seconds: f64,
}

impl MethodArguments {
    /// What can be seen without the volume.
    pub(super) fn validate(&self, parallel: bool) -> Result<()> {
        if self.algorithm == OperatorName::Steps && !parallel {
            bail!("{STEPS_IN_A_CONE}");
        }
        if self.non_negative && self.method != MethodName::Sirt {
            bail!("--non-negative is given; valid: only with --method sirt");
        }
        self.algorithm().map(drop)
    }

    pub(super) fn iterations(&self) -> usize {
        self.iterations.unwrap_or(match self.method {
            MethodName::Cgls => 10,
            MethodName::Sirt => 60,
        })
    }

    /// In words.
    pub(super) fn describe(&self) -> String {
        let method = match self.method {
            MethodName::Cgls => "CGLS",
            MethodName::Sirt if self.non_negative => "SIRT, values kept at 0 and above",
            MethodName::Sirt => "SIRT",
        };
        match self.algorithm() {
            Ok(Some(algorithm)) => format!("{method}, {algorithm}"),
            _ => format!("{method}, steps"),
        }
    }

    /// That of a ray transform; none for steps.
    fn algorithm(&self) -> Result<Option<Algorithm>> {
        match self.algorithm {
            OperatorName::Rays(name) => Ok(Some(name.algorithm(self.step)?)),
            OperatorName::Steps if self.step.is_some() => bail!("{STEP_OF_A_MARCH}"),
            OperatorName::Steps => Ok(None),
        }
    }

    fn operator(&self, context: &Context, scan: &Scan) -> Result<Box<dyn LinearOperator<f32>>> {
        let (views, size) = (scan.geometry.views(&scan.grid)?, scan.geometry.size());
        match (self.algorithm()?, &scan.geometry) {
            (Some(algorithm), _) => {
                Ok(Box::new(RayTransform::new(context, scan.grid, &views, size, algorithm)?))
            }
            (None, Geometry::Parallel(geometry, views)) => {
                Ok(Box::new(ParallelOperator::new(context, *geometry, Quadrature::Steps, views)?))
            }
            (None, Geometry::Cone { .. }) => bail!("{STEPS_IN_A_CONE}"),
        }
    }

    /// Reconstructs.
    pub(super) fn reconstruct(&self, context: &Context, scan: &Scan, console: Console) -> Result<Found> {
        let start = Instant::now();
        let operator = self.operator(context, scan)?;
        let iterations = self.iterations();
        let bar = console.bar("reconstructing", iterations);
        let (mut first, mut rmse_hu) = (Vec::new(), Vec::new());
        let mut report = |iteration: &Iteration<'_, f32>| {
            if iteration.number == 1 {
                first = iteration.volume.to_vec();
            }
            rmse_hu.extend(
                scan.truth.as_ref().map(|truth| rmse(iteration.volume, &truth.values) * 1000.0 / scan.water),
            );
            bar.inc(1);
            ControlFlow::Continue(())
        };
        let problem = Problem { operator: &*operator, images: &scan.data, weights: None, start: None };
        let found = match self.method {
            MethodName::Cgls => cgls(&problem, &Cgls { iterations }, &mut report),
            MethodName::Sirt => {
                let options = Sirt { iterations, non_negative: self.non_negative, ..Sirt::default() };
                sirt(&problem, &options, &mut report)
            }
        };
        bar.finish_and_clear();
        let found = found.with_context(|| format!("the views of {}", scan.name))?;
        if !scan.hu(&found.volume).iter().all(|hu| hu.is_finite()) {
            bail!("the views of {} are too large: the volume's HU are beyond float32", scan.name);
        }
        let seconds = start.elapsed().as_secs_f64();
        let residuals = found.residuals[1..].to_vec();
        Ok(Found { volume: found.volume, first, residuals, rmse_hu, seconds })
    }
}
