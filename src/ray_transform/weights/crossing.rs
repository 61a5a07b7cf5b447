//! Where a ray passes from one region to the next across its driving axis.

use crate::ray_transform::slab::across;
use crate::raycast::Ray;

/// Regions along u or v, numbered from 0, between the planes `r + 1 − shift`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Regions {
    pub shift: f64,
    /// Number of the last region, which has no end.
    pub last: f64,
}

/// What happens to a ray along u or v within one unit of s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crossing {
    /// The region in which it begins.
    pub region: i32,
    /// The region in which it ends: slopes are at most 1, so at most the next.
    pub next: i32,
    /// Where it passes; the end when it does not.
    pub s: f64,
}

impl Regions {
    /// The crossings along u (t = 0) or v (t = 1) between two s that are at most 1 apart.
    #[inline(always)]
    pub(super) fn crossing(self, ray: &Ray, t: usize, [from, to]: [f64; 2]) -> Crossing {
        let [region, end] = [from, to].map(|s| self.region(across(ray, s)[t]));
        if region == end {
            return Crossing { region, next: region, s: to };
        }
        // Rounding may make the end two regions away; the second plane is then beyond `to`.
        let (next, plane) = if end > region { (region + 1, region + 1) } else { (region - 1, region) };
        let s = ray.centre + (f64::from(plane) - self.shift - ray.base[t]) / ray.slope[t];
        Crossing { region, next, s: s.max(from).min(to) }
    }

    #[inline(always)]
    fn region(self, x: f64) -> i32 {
        // Not negative, so that cutting is rounding down.
        (x + self.shift).max(0.0).min(self.last) as i32
    }
}
