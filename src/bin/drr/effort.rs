//! How much work a projection is, counted along its rays.

use anyhow::Result;
use drr::raycast::{Beam, Ray};
use drr::{Algorithm, Projector, ViewRequest};

/// Every this many columns and rows one ray is looked at.
const STRIDE: usize = 8;

/// Rays of some views, and the samples of the volume they take.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) rays: f64,
    /// From every 64th pixel; right to about a percent.
    pub(crate) samples: f64,
}

impl Effort {
    pub(crate) fn of(projector: &Projector, views: &[ViewRequest]) -> Result<Self> {
        let rays = (views.len() * projector.plan().rays_per_view()) as f64;
        let [width, height] = projector.scene().detector;
        let grid = projector.volume().grid();
        let (mut looked_at, mut samples) = (0_usize, 0.0);
        for request in views {
            let beam = Beam::new(&request.view, grid, [width, height])?;
            for j in (STRIDE.min(height) / 2..height).step_by(STRIDE) {
                for i in (STRIDE.min(width) / 2..width).step_by(STRIDE) {
                    looked_at += 1;
                    let ray = beam.ray(i as f64, j as f64);
                    let slices = ray.clip(grid.dimensions()).map_or(0.0, |span| span.leave - span.enter);
                    samples += slices * samples_per_slice(&ray, projector.plan().method.algorithm);
                }
            }
        }
        Ok(Self { rays, samples: rays * samples / looked_at.max(1) as f64 })
    }
}

fn samples_per_slice(ray: &Ray, algorithm: Algorithm) -> f64 {
    let cells = 1.0 + ray.slope[0].abs() + ray.slope[1].abs();
    match algorithm {
        Algorithm::Joseph => 1.0,
        Algorithm::March { step } => 1.0 / step,
        Algorithm::Siddon => cells,
        Algorithm::Exact => 2.0 * cells,
    }
}
