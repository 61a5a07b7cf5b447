//! The exact integral of the interpolated field.

use crate::ray_transform::slab::{Slab, cell, inside};
use crate::ray_transform::weights::Visit;
use crate::ray_transform::weights::crossing::Regions;
use crate::raycast::{Ray, Span};
use crate::real::Real;

/// Between planes through voxel centres the trilinear field along a ray is a cubic polynomial, which two Gauss–Legendre
/// nodes integrate exactly.
#[inline]
pub(super) fn for_each<T: Real>(ray: &Ray, span: Span, slab: &Slab, out: &mut impl Visit<T>) {
    let regions = slab.across().map(|n| Regions { shift: 1.0, last: n as f64 });
    // Interval k reaches from slice k to slice k + 1.
    let first = (slab.first - 1).max(span.enter.floor() as i32);
    for k in first..slab.end {
        let (from, to) = (span.enter.max(f64::from(k)), span.leave.min(f64::from(k) + 1.0));
        if to <= from {
            break;
        }
        let [u, v] = [0, 1].map(|t| regions[t].crossing(ray, t, [from, to]).s);
        let (one, both) = (u.min(v), u.max(v));
        for [from, to] in [[from, one], [one, both], [both, to]] {
            if from < to {
                piece(ray, [from, to], slab, out);
            }
        }
    }
}

/// A piece within one cell of eight voxels.
#[inline(always)]
fn piece<T: Real>(ray: &Ray, [from, to]: [f64; 2], slab: &Slab, out: &mut impl Visit<T>) {
    let (half, middle) = (0.5 * (to - from), 0.5 * (from + to));
    let slice = cell(middle, slab.count);
    let sample = |s: f64| slab.bilinear_in::<T>(ray, middle, s);
    let mut weights = [[T::default(); 4]; 2];
    for node in [-1.0, 1.0] {
        let s = middle + node * half / 3.0_f64.sqrt();
        let fraction = inside(s, slab.count) - f64::from(slice);
        let sample = sample(s);
        for (sum, share) in weights.iter_mut().zip([1.0 - fraction, fraction]) {
            for (sum, weight) in sum.iter_mut().zip(sample.weights(T::of(half * share))) {
                *sum += weight;
            }
        }
    }
    for (slice, weights) in [slice, slice + 1].into_iter().zip(weights) {
        if slab.contains(slice) {
            out.visit(sample(middle).voxels(slab.slice(slice)), weights);
        }
    }
}
