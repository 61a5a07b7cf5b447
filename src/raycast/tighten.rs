//! The part of a ray that meets anything, found from both ends of it on the levels of [`Occupied`].

use std::ops::Range;

use crate::raycast::{Ray, Span, ray::TRANSVERSE};
use crate::volume::{Level, Occupied};

/// How far beyond the faces of a voxel it can be read from, voxels: half of one by interpolation between centres, and as
/// much for a slice that is passed askew while only its middle is looked at, and for rounding to float32.
pub(crate) const REACH: f64 = 1.0;

/// Which end of a span.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Lower,
    Upper,
}

/// A ray on its way through the bricks.
struct Walk<'a> {
    levels: &'a [Level],
    ray: &'a Ray,
    span: Span,
    reach: f64,
}

impl Occupied {
    /// The part of `span` outside of which the ray is further than `reach` voxels from the faces of every brick that counts;
    /// `None` where all of it is. It may begin up to 2 `reach` early and end as late, and is never too short. `span` is what
    /// [`Ray::clip`] made of the ray.
    pub(crate) fn tighten(&self, ray: &Ray, span: Span, reach: f64) -> Option<Span> {
        let walk = Walk { levels: self.levels(), ray, span, reach };
        let coarsest = self.levels().len() - 1;
        let all = 0..self.levels()[coarsest].count[ray.axis];
        let enter = walk.end(End::Lower, coarsest, all.clone())?;
        let leave = walk.end(End::Upper, coarsest, all)?;
        (leave > enter).then_some(Span { enter, leave })
    }
}

impl Walk<'_> {
    /// The first s, from one end on, where the ray is within reach of a brick that counts in these slabs: slices of bricks
    /// across the driving axis.
    fn end(&self, end: End, level: usize, slabs: Range<usize>) -> Option<f64> {
        let count = slabs.len();
        (0..count).find_map(|n| {
            let slab = if end == End::Lower { slabs.start + n } else { slabs.end - 1 - n };
            if level == 0 {
                return self.within_slab(end, slab);
            }
            let finer = self.levels[level - 1].count[self.ray.axis];
            let touched = self.any(level, slab, |_| true);
            touched.then(|| self.end(end, level - 1, 2 * slab..(2 * slab + 2).min(finer))).flatten()
        })
    }

    /// As `end`, of one slab of the finest bricks.
    fn within_slab(&self, end: End, slab: usize) -> Option<f64> {
        let mut found: Option<f64> = None;
        self.any(0, slab, |brick| {
            if let Some(Span { enter, leave }) = self.near(brick) {
                found = Some(match end {
                    End::Lower => found.map_or(enter, |found| found.min(enter)),
                    End::Upper => found.map_or(leave, |found| found.max(leave)),
                });
            }
            false
        });
        // The slab beyond begins a little before this one ends, and may hold something there.
        found.map(|found| match end {
            End::Lower => found.min(self.slab(0, slab + 1).enter.max(self.span.enter)),
            End::Upper => found.max((self.slab(0, slab).enter + 2.0 * self.reach).min(self.span.leave)),
        })
    }

    /// Slices within reach of a slab.
    fn slab(&self, level: usize, slab: usize) -> Span {
        let size = self.levels[level].size as f64;
        let face = slab as f64 * size - 0.5;
        Span { enter: face - self.reach, leave: face + size + self.reach }
    }

    /// Whether `which` is true of any brick of a slab that counts and that the ray may come near.
    fn any(&self, level: usize, slab: usize, mut which: impl FnMut([usize; 3]) -> bool) -> bool {
        let here = self.slab(level, slab);
        let [from, to] = [here.enter.max(self.span.enter), here.leave.min(self.span.leave)];
        if from > to {
            return false;
        }
        let Level { count, size, .. } = self.levels[level];
        let bricks = |t: usize| {
            let [a, b] = [from, to].map(|s| self.ray.base[t] + self.ray.slope[t] * (s - self.ray.centre));
            // `as` saturates: what is before the box counts as its first brick.
            let brick = |x: f64| ((x + 0.5) / size as f64) as usize;
            brick(a.min(b) - self.reach)
                ..=brick(a.max(b) + self.reach).min(count[TRANSVERSE[self.ray.axis][t]] - 1)
        };
        let [u, v] = TRANSVERSE[self.ray.axis];
        let mut brick = [slab; 3];
        for j in bricks(1) {
            brick[v] = j;
            for i in bricks(0) {
                brick[u] = i;
                if self.levels[level].holds(brick) && which(brick) {
                    return true;
                }
            }
        }
        false
    }

    /// The part of the span within reach of one of the finest bricks.
    fn near(&self, brick: [usize; 3]) -> Option<Span> {
        let size = self.levels[0].size as f64;
        let faces = |axis: usize| {
            let face = brick[axis] as f64 * size - 0.5;
            [face - self.reach, face + size + self.reach]
        };
        let [low, high] = faces(self.ray.axis);
        let [mut enter, mut leave] = [low.max(self.span.enter), high.min(self.span.leave)];
        for (t, &axis) in TRANSVERSE[self.ray.axis].iter().enumerate() {
            let (base, slope) = (self.ray.base[t], self.ray.slope[t]);
            let [low, high] = faces(axis);
            if slope == 0.0 {
                if base < low || base > high {
                    return None;
                }
            } else {
                let [a, b] = [low, high].map(|face| self.ray.centre + (face - base) / slope);
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        (enter <= leave).then_some(Span { enter, leave })
    }
}

#[cfg(test)]
mod tests;
