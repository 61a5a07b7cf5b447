//! Joseph's rule in float64.

use crate::engine::reference::PerLabel;
use crate::engine::reference::sample::add_trilinear;
use crate::raycast::{Ray, Span, slices};
use crate::volume::Volume;

/// One bilinear sample in every slice k that the ray's span touches, weighted by the part of [k−½, k+½] inside the
/// span. A constant volume therefore gives its chord exactly, and ten voxels along an axis give ten.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span) -> PerLabel {
    let count = volume.grid().dimensions()[ray.axis] as i32;
    let mut sum = PerLabel::default();
    for (slice, weight) in slices(span, 0..count) {
        add_trilinear(volume, ray.point(f64::from(slice)), weight, &mut sum);
    }
    sum
}
