//! The distance-driven mean in float64.

use crate::engine::reference::PerLabel;
use crate::raycast::distance_driven::for_each_weight;
use crate::raycast::{Footprint, Ray, Span};
use crate::volume::Volume;

/// Weights of the voxels that the pixel covers times their densities, each voxel to its own label.
pub(super) fn integrate(volume: &Volume, ray: &Ray, footprint: &Footprint, span: Span) -> PerLabel {
    let n = volume.grid().dimensions();
    let mut sum = PerLabel::default();
    for_each_weight(ray, footprint, span, n, 0..n[ray.axis] as i32, |[i, j, k], weight| {
        let voxel = volume.voxels().get((k * n[1] + j) * n[0] + i);
        sum[usize::from(voxel.label)] += weight * voxel.density;
    });
    sum
}
