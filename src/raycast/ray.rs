//! One ray, described by where it crosses the slices of its driving axis.

use glam::DVec3;

use crate::geometry::Grid;

/// The two axes across each driving axis, the faster one in memory first.
pub(crate) const TRANSVERSE: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// A ray in index space. Its *driving axis* is the one along which it moves fastest in index space (the lowest of
/// equals), so that both slopes are in [−1, 1]. `s` is the coordinate along the driving axis, (u, v) those along the
/// other two, the faster one in memory first. The ray is at `base + slope * (s − centre)`: no point far from the
/// volume takes part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// The driving axis, 0 … 2.
    pub axis: usize,
    /// The volume's centre along the driving axis, (n−1)/2.
    pub centre: f64,
    /// (u, v) where the ray crosses the plane s = centre.
    pub base: [f64; 2],
    /// Change of (u, v) per unit of s.
    pub slope: [f64; 2],
    /// The part of the line that counts, as an interval of s: from the source to the pixel, or to infinity.
    pub limits: [f64; 2],
    /// World length of one unit of s, mm.
    pub mm_per_slice: f64,
}

/// The part of a ray inside the volume's box, as an interval of s: `enter < leave`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Lower end.
    pub enter: f64,
    /// Upper end.
    pub leave: f64,
}

impl Ray {
    /// The line through `point` along `direction`, in the index space of a volume with this centre. `ends` are the points,
    /// if any, where the ray starts and stops.
    pub(crate) fn through(
        centre: DVec3,
        point: DVec3,
        direction: DVec3,
        ends: [Option<DVec3>; 2],
        mm_per_index_unit: f64,
    ) -> Self {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let along = direction[axis];
        let slope = TRANSVERSE[axis].map(|t| direction[t] / along);
        let base = [0, 1].map(|t| {
            let transverse = TRANSVERSE[axis][t];
            // A slope of 0 leaves the coordinate as it is, to the last bit.
            point[transverse] + slope[t] * (centre[axis] - point[axis])
        });
        let unbounded = [f64::NEG_INFINITY * along.signum(), f64::INFINITY * along.signum()];
        let [start, stop] = [0, 1].map(|end| ends[end].map_or(unbounded[end], |p| p[axis]));
        let limits = [start.min(stop), start.max(stop)];
        Self {
            axis,
            centre: centre[axis],
            base,
            slope,
            limits,
            mm_per_slice: mm_per_index_unit / along.abs(),
        }
    }

    /// The index-space point at s.
    pub fn point(&self, s: f64) -> [f64; 3] {
        let mut point = [s; 3];
        for (t, transverse) in TRANSVERSE[self.axis].into_iter().enumerate() {
            point[transverse] = self.base[t] + self.slope[t] * (s - self.centre);
        }
        point
    }

    /// By how much the index-space point moves per unit of s.
    pub(crate) fn step(&self) -> DVec3 {
        let mut step = DVec3::ONE;
        for (t, transverse) in TRANSVERSE[self.axis].into_iter().enumerate() {
            step[transverse] = self.slope[t];
        }
        step
    }

    /// World distance, mm, from another ray near the centre of a volume on `grid`; infinite where the driving axes differ.
    pub(crate) fn distance(&self, other: &Self, grid: &Grid) -> f64 {
        if self.axis != other.axis {
            return f64::INFINITY;
        }
        let [here, there, on] =
            [self.point(self.centre), other.point(self.centre), self.point(self.centre + 1.0)]
                .map(|point| grid.index_to_world().transform_point3(DVec3::from_array(point)));
        (there - here).reject_from(on - here).length()
    }

    /// The part of the ray inside the box [−½, n−½) of a volume of these dimensions; `None` when it misses. A ray
    /// parallel to an axis is inside or outside by comparison: nothing is divided by zero and no direction is altered.
    pub fn clip(&self, dimensions: [usize; 3]) -> Option<Span> {
        self.clip_by(dimensions, |_| true)
    }

    /// As [`Ray::clip`], of a box without faces across this axis, which is not the driving one.
    pub(crate) fn clip_but(&self, dimensions: [usize; 3], open: usize) -> Option<Span> {
        self.clip_by(dimensions, |axis| axis != open)
    }

    fn clip_by(&self, dimensions: [usize; 3], faced: impl Fn(usize) -> bool) -> Option<Span> {
        let last = |axis: usize| dimensions[axis] as f64 - 0.5;
        let mut enter = self.limits[0].max(-0.5);
        let mut leave = self.limits[1].min(last(self.axis));
        for (t, &transverse) in TRANSVERSE[self.axis].iter().enumerate().filter(|(_, axis)| faced(**axis)) {
            let (base, slope) = (self.base[t], self.slope[t]);
            if slope == 0.0 {
                if !(-0.5 <= base && base < last(transverse)) {
                    return None;
                }
            } else {
                let a = self.centre + (-0.5 - base) / slope;
                let b = self.centre + (last(transverse) - base) / slope;
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            }
        }
        (leave > enter).then_some(Span { enter, leave })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIMENSIONS: [usize; 3] = [4, 6, 5];
    const CENTRE: DVec3 = DVec3::new(1.5, 2.5, 2.0);

    fn line(point: DVec3, direction: DVec3) -> Ray {
        Ray::through(CENTRE, point, direction, [None, None], direction.length())
    }

    #[test]
    fn a_parallel_ray_crosses_the_whole_box_and_half_open_faces_decide() {
        for (x, hits) in [(-0.5, true), (-0.5 - 1e-15, false), (3.5 - 1e-15, true), (3.5, false)] {
            let span = line(DVec3::new(x, 9.0, 2.0), DVec3::NEG_Y).clip(DIMENSIONS);
            assert_eq!(span, hits.then_some(Span { enter: -0.5, leave: 5.5 }), "x = {x}");
        }
    }

    #[test]
    fn signed_zeros_make_no_difference() {
        let plus = line(DVec3::new(1.0, 9.0, 2.0), DVec3::new(0.0, 1.0, 0.0));
        let minus = line(DVec3::new(1.0, 9.0, 2.0), DVec3::new(-0.0, 1.0, -0.0));
        assert_eq!(plus.clip(DIMENSIONS), minus.clip(DIMENSIONS));
    }

    #[test]
    fn the_chord_of_a_diagonal_is_its_length() {
        let direction = DVec3::new(4.0, 6.0, 5.0);
        let ray = line(CENTRE, direction);
        let span = ray.clip(DIMENSIONS).expect("the diagonal hits");
        let chord = (span.leave - span.enter) * ray.mm_per_slice;
        assert!((chord - direction.length()).abs() < 1e-14, "{chord}");
    }

    #[test]
    fn a_denormal_tilt_is_the_limit_of_no_tilt() {
        let straight = line(DVec3::new(1.0, 0.0, 2.0), DVec3::Y).clip(DIMENSIONS);
        for tilt in [5e-324, 1e-300, 1e-18] {
            let tilted = line(DVec3::new(1.0, 0.0, 2.0), DVec3::new(tilt, 1.0, -tilt)).clip(DIMENSIONS);
            assert_eq!(tilted, straight, "tilt {tilt}");
        }
    }
}
