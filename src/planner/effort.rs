//! How much work a projection is, counted along its rays.

use crate::error::Result;
use crate::geometry::{Grid, View};
use crate::method::Algorithm;
use crate::raycast::Beam;
use crate::scene::Scene;

/// Columns and rows of rays that are looked at in each view.
const LOOKED_AT: usize = 90;

/// Most views that are looked at.
const MOST_VIEWS: usize = 64;

/// The rays of some views, and what they cross of a volume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// Rays of all pixels.
    pub rays: f64,
    /// Slices of their driving axes that they cross in all; right to about a percent.
    pub slices: f64,
    /// Voxels that they cross in all.
    pub voxels: f64,
}

impl Effort {
    /// Of a scene's detector in some views of a volume on `grid`.
    ///
    /// # Errors
    /// `InvalidArgument` for a view that is not valid.
    pub fn new(views: &[View], grid: &Grid, scene: &Scene) -> Result<Self> {
        let size = scene.detector;
        let strides = size.map(|n| n.div_ceil(LOOKED_AT));
        let (mut looked_at, mut slices, mut voxels) = (0_usize, 0.0, 0.0);
        for view in views.iter().step_by(views.len().div_ceil(MOST_VIEWS).max(1)) {
            let beam = Beam::new(view, grid, size)?;
            for j in (strides[1] / 2..size[1]).step_by(strides[1]) {
                for i in (strides[0] / 2..size[0]).step_by(strides[0]) {
                    looked_at += 1;
                    let ray = beam.ray(i as f64, j as f64);
                    let own = ray.clip(grid.dimensions()).map_or(0.0, |span| span.leave - span.enter);
                    slices += own;
                    voxels += own * (1.0 + ray.slope[0].abs() + ray.slope[1].abs());
                }
            }
        }
        let rays = (views.len() * size[0] * size[1] * scene.supersampling * scene.supersampling) as f64;
        let of_all = rays / looked_at.max(1) as f64;
        Ok(Self { rays, slices: of_all * slices, voxels: of_all * voxels })
    }

    /// Samples of the volume that an algorithm takes along all rays.
    pub fn samples(&self, algorithm: Algorithm) -> f64 {
        match algorithm {
            Algorithm::Joseph | Algorithm::DistanceDriven => self.slices,
            Algorithm::March { step } => self.slices / step,
            Algorithm::Siddon => self.voxels,
            Algorithm::Exact => 2.0 * self.voxels,
        }
    }
}
