//! Sums over energies by several rows of weights, on engines that take them where they cast the rays.

#[cfg(any(feature = "cuda", feature = "host", target_vendor = "apple"))]
use crate::allocation::filled;
use crate::engine::{Layers, Progress, ViewJob};
#[cfg(any(feature = "cuda", feature = "host", target_vendor = "apple"))]
use crate::error::Result;

/// Most rows of weights of one job: four moments of each of two detector layers.
pub const MAX_SIGNALS: usize = 8;
/// Most materials that lie before the volume in one job.
pub const MAX_BEFORE: usize = 8;

/// What an engine is asked to sum: for each ray and each row r of weights, `Σ_k W_rk exp(−τ_k)` with the depths τ of all that
/// the ray meets, as a part of `Σ_k W_rk`.
pub struct SignalsJob<'a> {
    /// Of rays of one detector: one view for each point of the focal spot. None stops early or has tables of its own.
    pub views: &'a [ViewJob],
    /// Weights by row and energy; each energy has a weight in some row, and each row's sum is above 0.
    pub rows: &'a [Vec<f64>],
    /// Mass attenuation, cm²/g, by material and energy: the scene's materials, then those before the volume.
    pub coefficients: &'a [Vec<f64>],
    /// What lies before the volume, g/cm²: ray (i, j) through material b is at `(b*height + j)*width + i`, the same for every
    /// view.
    pub before: &'a [f32],
    /// Whether the sums without the volume are wanted too.
    pub open: bool,
    /// Which areal densities and paths are wanted too; intensity and line integral are not among them.
    pub layers: Layers,
    /// Where finished rays are reported.
    pub progress: Progress<'a>,
}

impl SignalsJob<'_> {
    /// How many materials lie before the volume of a scene with so many.
    pub(super) fn materials_before(&self, materials: usize) -> usize {
        self.coefficients.len() - materials
    }

    /// Whether kernels are made for so many sums.
    pub(super) fn fits(&self, materials: usize) -> bool {
        self.rows.len() <= MAX_SIGNALS && self.materials_before(materials) <= MAX_BEFORE
    }
}

/// What passed along each ray.
pub struct Passed {
    /// The part of each row's sum that passes, or, where that is below 1e-30, its natural logarithm, which is negative: ray
    /// (i, j) of row r in view v is at `((v*rows + r)*height + j)*width + i`. Exactly 1 where a ray meets nothing.
    pub passing: Vec<f32>,
    /// The same without the volume, of one view: they are all alike.
    pub open: Vec<f32>,
}

impl Passed {
    /// Zeros for a job's results.
    #[cfg(any(feature = "cuda", feature = "host", target_vendor = "apple"))]
    pub(super) fn zeroed(job: &SignalsJob<'_>, size: [usize; 2]) -> Result<Self> {
        let planes = |count: usize| filled(count * size[0] * size[1], 0.0, "the signals of a view");
        Ok(Self {
            passing: planes(job.views.len() * job.rows.len())?,
            open: planes(if job.open { job.rows.len() } else { 0 })?,
        })
    }

    /// A number of `passing` or `open` as the part that it means.
    pub(crate) fn part(number: f32) -> f64 {
        let number = f64::from(number);
        if number < 0.0 { number.exp() } else { number }
    }
}
