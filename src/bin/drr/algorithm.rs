//! Names of the ways in which line integrals are taken.

use anyhow::{Result, bail};
use clap::ValueEnum;
use drr::Algorithm;

/// Step of the march where the arguments do not say, voxels.
const STEP: f64 = 0.5;

/// What is wrong with a step of anything else.
pub(crate) const STEP_OF_A_MARCH: &str = "--step is given; valid: only with --algorithm march";

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AlgorithmName {
    /// One bilinear sample per slice of the driving axis
    Joseph,
    /// Trilinear samples at equal steps along the driving axis
    March,
    /// Exact lengths through voxels of constant value
    Siddon,
    /// Mean of the voxels that the pixel covers in each slice of the driving axis
    #[value(name = "distance_driven")]
    DistanceDriven,
    /// The interpolated field integrated exactly
    Exact,
}

impl AlgorithmName {
    /// The algorithm, with `--step` for the march.
    ///
    /// # Errors
    /// For a step of any other.
    pub(crate) fn algorithm(self, step: Option<f64>) -> Result<Algorithm> {
        if step.is_some() && self != Self::March {
            bail!("{STEP_OF_A_MARCH}");
        }
        Ok(match self {
            Self::Joseph => Algorithm::Joseph,
            Self::March => Algorithm::March { step: step.unwrap_or(STEP) },
            Self::Siddon => Algorithm::Siddon,
            Self::DistanceDriven => Algorithm::DistanceDriven,
            Self::Exact => Algorithm::Exact,
        })
    }
}
