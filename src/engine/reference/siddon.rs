//! Siddon's exact lengths in float64.

use crate::engine::reference::PerLabel;
use crate::raycast::{Ray, Span, crossings};
use crate::volume::{Volume, Voxel};

/// Calls `visit` with the length, in units of s, and the voxel of every piece of the ray.
fn for_each_voxel(volume: &Volume, ray: &Ray, span: Span, mut visit: impl FnMut(f64, Voxel)) {
    let n = volume.grid().dimensions();
    for pair in crossings(ray, span, 0.5).windows(2) {
        let length = pair[1] - pair[0];
        if length <= 0.0 {
            continue;
        }
        let point = ray.point(0.5 * (pair[0] + pair[1]));
        let [i, j, k] =
            [0, 1, 2].map(|axis| (point[axis] + 0.5).floor().clamp(0.0, (n[axis] - 1) as f64) as usize);
        visit(length, volume.voxels().get((k * n[1] + j) * n[0] + i));
    }
}

/// Sum of length times density, each voxel to its own label.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span) -> PerLabel {
    let mut sum = PerLabel::default();
    for_each_voxel(volume, ray, span, |length, voxel| {
        sum[usize::from(voxel.label)] += length * voxel.density;
    });
    sum
}

/// Length through voxels of one label, in units of s.
pub(super) fn path_through(volume: &Volume, ray: &Ray, span: Span, label: u8) -> f64 {
    let mut sum = 0.0;
    for_each_voxel(volume, ray, span, |length, voxel| sum += if voxel.label == label { length } else { 0.0 });
    sum
}
