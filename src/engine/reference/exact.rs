//! The exact integral of the interpolated field.

use crate::engine::reference::PerLabel;
use crate::engine::reference::sample::add_trilinear;
use crate::raycast::{Ray, Span, crossings};
use crate::volume::Volume;

/// Between planes through voxel centres the trilinear field along a ray is a cubic polynomial, which two
/// Gauss–Legendre nodes integrate exactly.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span) -> PerLabel {
    let mut sum = PerLabel::default();
    for pair in crossings(ray, span, 0.0).windows(2) {
        let half = 0.5 * (pair[1] - pair[0]);
        let middle = 0.5 * (pair[0] + pair[1]);
        for node in [-1.0, 1.0] {
            let s = middle + node * half / 3.0_f64.sqrt();
            add_trilinear(volume, ray.point(s), half, &mut sum);
        }
    }
    sum
}
