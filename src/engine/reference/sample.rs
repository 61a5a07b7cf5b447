//! The interpolated field: per-material partial densities between voxel centres.

use crate::engine::reference::PerLabel;
use crate::volume::Volume;

/// Lower neighbour and weight of the upper one; in the outer half voxel the edge value holds.
fn cell(x: f64, n: usize) -> (usize, f64) {
    let x = x.clamp(0.0, (n - 1) as f64);
    let lower = (x.floor() as usize).min(n.saturating_sub(2));
    (lower, x - lower as f64)
}

/// Adds `weight` times the trilinear field at an index-space point to `sum`, each corner to its own label.
pub(super) fn add_trilinear(volume: &Volume, point: [f64; 3], weight: f64, sum: &mut PerLabel) {
    let n = volume.grid().dimensions();
    let cells = [0, 1, 2].map(|axis| cell(point[axis], n[axis]));
    let stride = [1, n[0], n[0] * n[1]];
    for corner in 0..8_usize {
        let mut index = 0;
        let mut share = weight;
        for axis in 0..3 {
            let upper = corner >> axis & 1;
            let (lower, fraction) = cells[axis];
            index += stride[axis] * (lower + upper).min(n[axis] - 1);
            share *= if upper == 1 { fraction } else { 1.0 - fraction };
        }
        if share != 0.0 {
            let voxel = volume.voxels().get(index);
            sum[usize::from(voxel.label)] += share * voxel.density;
        }
    }
}
