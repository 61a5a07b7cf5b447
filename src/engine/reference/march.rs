//! The trilinear march in float64.

use crate::engine::reference::PerLabel;
use crate::engine::reference::sample::add_trilinear;
use crate::raycast::{Ray, Span};
use crate::volume::Volume;

/// The driving axis is divided into cells of `step` voxels from −½ on; each cell that the span touches gives one
/// trilinear sample at the middle of the part inside, weighted by that part's length. Weights sum to the chord.
/// The sum is continuous in the ray, except where the driving axis changes: there it jumps by about its own error.
pub(super) fn integrate(volume: &Volume, ray: &Ray, span: Span, step: f64) -> PerLabel {
    let first_cell = ((span.enter + 0.5) / step).floor();
    let cells = ((span.leave - span.enter) / step).ceil() as usize + 2;
    let mut sum = PerLabel::default();
    for cell in 0..cells {
        let lower = -0.5 + (first_cell + cell as f64) * step;
        let upper = -0.5 + (first_cell + (cell + 1) as f64) * step;
        let (from, to) = (lower.max(span.enter), upper.min(span.leave));
        if to <= from {
            continue;
        }
        let s = 0.5 * (from + to);
        add_trilinear(volume, ray.point(s), to - from, &mut sum);
    }
    sum
}
