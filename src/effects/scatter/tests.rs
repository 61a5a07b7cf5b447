mod pencil;
mod superposed;
mod truth;
mod whole;

use super::ScatterKernels;
use crate::effects::Plane;
use crate::error::Result;

/// Of an upright detector: the perpendicular from the source meets its middle.
fn scattered(
    kernels: &ScatterKernels,
    row: usize,
    primary: &Plane,
    areal_density: &Plane,
    pitch_mm: [f64; 2],
) -> Result<Plane> {
    let middle = primary.size().map(|side| 0.5 * (side as f64 - 1.0));
    kernels.scattered(row, primary, areal_density, pitch_mm, middle)
}
