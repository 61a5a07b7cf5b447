//! One ray, and how it moves with six parameters.

use glam::DVec3;

use crate::pose_gradient::path_sums::{ENDS, LANES, MOMENT, SLOPE, VALUE};
use crate::raycast::ray::TRANSVERSE;
use crate::raycast::{Ray, Span};

/// Number of parameters: three angles, three translations.
pub(super) const PARAMETERS: usize = 6;

/// A point or vector in index space, and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moving {
    pub at: DVec3,
    pub by: [DVec3; PARAMETERS],
}

impl Moving {
    /// `self + factor·other`.
    pub(super) fn plus(&self, factor: f64, other: &Self) -> Self {
        let by = std::array::from_fn(|k| self.by[k] + factor * other.by[k]);
        Self { at: self.at + factor * other.at, by }
    }
}

/// A ray and the derivatives of what describes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MovingRay {
    pub ray: Ray,
    /// Of each parameter.
    pub by: [RayMotion; PARAMETERS],
}

/// Derivatives of a ray with respect to one parameter.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RayMotion {
    base: [f64; 2],
    slope: [f64; 2],
    limits: [f64; 2],
    /// Of ln(mm per slice).
    stretch: f64,
}

/// What an end of a span is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bound {
    /// The ray's own end.
    Limit,
    /// A face of the volume's box across the driving axis.
    Face,
    /// One across u or v.
    Side(usize),
}

impl MovingRay {
    /// The segment from `source` to `pixel`, whose world length stays. `ray` is the same segment.
    pub(super) fn new(ray: Ray, source: &Moving, pixel: &Moving) -> Self {
        let from_centre = |point: &Moving| (point.at[ray.axis] - ray.centre).abs();
        let near = if from_centre(pixel) < from_centre(source) { pixel } else { source };
        let along = pixel.at[ray.axis] - source.at[ray.axis];
        let by = std::array::from_fn(|k| {
            let [start, stop, near_by] = [source.by[k], pixel.by[k], near.by[k]];
            let change = stop - start;
            // How far the line moves at a plane that stays, where a point of it moves.
            let across = |by: DVec3, t: usize| by[TRANSVERSE[ray.axis][t]] - ray.slope[t] * by[ray.axis];
            let slope = [0, 1].map(|t| across(change, t) / along);
            let reach = ray.centre - near.at[ray.axis];
            let ends = [start, stop].map(|by| by[ray.axis]);
            RayMotion {
                base: [0, 1].map(|t| across(near_by, t) + slope[t] * reach),
                slope,
                limits: if along > 0.0 { ends } else { [ends[1], ends[0]] },
                stretch: -change[ray.axis] / along,
            }
        });
        Self { ray, by }
    }

    /// Derivatives of mm·Σ w f with these sums over `span`, in a volume of these dimensions.
    pub(super) fn derivatives(
        &self,
        sums: &[f64; LANES],
        span: Span,
        dimensions: [usize; 3],
    ) -> [f64; PARAMETERS] {
        let ends = [span.enter, span.leave];
        let bounds = [0, 1].map(|end| self.bound(end, ends[end], dimensions));
        self.by.map(|by| {
            let across = |t: usize| sums[SLOPE[t]] * by.base[t] + sums[MOMENT[t]] * by.slope[t];
            let end = |end: usize| {
                let moved = match bounds[end] {
                    Bound::Limit => by.limits[end],
                    Bound::Face => 0.0,
                    Bound::Side(t) => {
                        -(by.base[t] + by.slope[t] * (ends[end] - self.ray.centre)) / self.ray.slope[t]
                    }
                };
                sums[ENDS[end]] * moved
            };
            let changed = sums[VALUE] * by.stretch + across(0) + across(1) + end(0) + end(1);
            self.ray.mm_per_slice * changed
        })
    }

    /// What the span's lower (0) or upper (1) end at s is.
    fn bound(&self, end: usize, s: f64, dimensions: [usize; 3]) -> Bound {
        let ray = &self.ray;
        let faces = |axis: usize| [-0.5, dimensions[axis] as f64 - 0.5];
        if s == ray.limits[end] {
            return Bound::Limit;
        }
        if s == faces(ray.axis)[end] {
            return Bound::Face;
        }
        // A ray that leaves or enters through both at once has a kink there: either will do.
        let off = |t: usize| {
            let at = ray.base[t] + ray.slope[t] * (s - ray.centre);
            let [low, high] = faces(TRANSVERSE[ray.axis][t]).map(|face| (at - face).abs());
            if ray.slope[t] == 0.0 { f64::INFINITY } else { low.min(high) / ray.slope[t].abs() }
        };
        Bound::Side(usize::from(off(1) < off(0)))
    }
}
