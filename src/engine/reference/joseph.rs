//! Joseph's rule in float64.

use crate::engine::reference::PerLabel;
use crate::engine::reference::sample::add_trilinear;
use crate::raycast::{Ray, Span};
use crate::volume::Volume;

/// One bilinear sample in every slice k that the ray's span touches, weighted by the part of [k−½, k+½] inside the
/// span. A constant volume therefore gives its chord exactly, and ten voxels along an axis give ten.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span) -> PerLabel {
    let last = volume.grid().dimensions()[ray.axis] - 1;
    let first_slice = (span.enter + 0.5).floor().max(0.0) as usize;
    let mut sum = PerLabel::default();
    for slice in first_slice..=last {
        let s = slice as f64;
        let weight = span.leave.min(s + 0.5) - span.enter.max(s - 0.5);
        if weight <= 0.0 {
            break;
        }
        add_trilinear(volume, ray.point(s), weight, &mut sum);
    }
    sum
}
