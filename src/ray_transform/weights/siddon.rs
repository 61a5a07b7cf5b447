//! Siddon's exact lengths (Med Phys 12(2), 252, 1985).

use crate::ray_transform::slab::Slab;
use crate::ray_transform::weights::Visit;
use crate::ray_transform::weights::crossing::Regions;
use crate::raycast::{Ray, Span};
use crate::real::Real;

/// The length in every voxel. In a slice [k−½, k+½] the ray crosses at most one plane along u and one along v, which makes
/// three pieces, some of length 0: no list of crossings has to be sorted. For a ray in a plane between voxels rounding
/// decides to which side its length goes.
#[inline]
pub(super) fn for_each<T: Real>(ray: &Ray, span: Span, slab: &Slab, out: &mut impl Visit<T>) {
    let regions = slab.across().map(|n| Regions { shift: 0.5, last: (n - 1) as f64 });
    let strides = slab.strides();
    let first = ((span.enter + 0.5).max(0.0) as i32).max(slab.first);
    for slice in first..slab.end {
        let s = f64::from(slice);
        let (from, to) = (span.enter.max(s - 0.5), span.leave.min(s + 0.5));
        if to <= from {
            break;
        }
        let [u, v] = [0, 1].map(|t| regions[t].crossing(ray, t, [from, to]));
        let voxel = |i: i32, j: i32| slab.slice(slice) + i as usize * strides[0] + j as usize * strides[1];
        let (one, both) = (u.s.min(v.s), u.s.max(v.s));
        let between = if u.s < v.s { voxel(u.next, v.region) } else { voxel(u.region, v.next) };
        out.visit(
            [voxel(u.region, v.region), between, voxel(u.next, v.next)],
            [one - from, both - one, to - both].map(T::of),
        );
    }
}
