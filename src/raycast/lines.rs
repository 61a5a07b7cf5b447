//! A view's rays in closed form: every quantity changes evenly from pixel to pixel.

use glam::DVec3;

/// A vector that changes evenly: `constant + column·i + row·j` at pixel (i, j).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Even {
    pub constant: DVec3,
    pub column: DVec3,
    pub row: DVec3,
}

impl Even {
    /// The vector at a pixel, or between pixels.
    pub(crate) fn at(&self, column: f64, row: f64) -> DVec3 {
        self.constant + column * self.column + row * self.row
    }

    /// The same vector everywhere.
    pub(super) fn constant(constant: DVec3) -> Self {
        Self { constant, column: DVec3::ZERO, row: DVec3::ZERO }
    }

    /// Multiplied by a number.
    pub(super) fn times(self, factor: f64) -> Self {
        Self { constant: factor * self.constant, column: factor * self.column, row: factor * self.row }
    }
}

/// What places a line in space, beside its direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Anchor {
    /// One of its points, near the volume.
    Point(Even),
    /// Its moment about the grid's centre, (point − centre) × direction, the same for all its points (Plücker).
    Moment(Even),
}

/// All rays of a view in index space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lines {
    /// The grid's centre.
    pub centre: DVec3,
    /// From the source on; of any length.
    pub direction: Even,
    pub anchor: Anchor,
    /// Where rays start; `None`: nowhere.
    pub source: Option<DVec3>,
    /// Where rays end; `None`: nowhere.
    pub pixel: Option<Even>,
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec4};

    use super::*;
    use crate::geometry::{DetectorPose, Grid, Projection, View};
    use crate::raycast::Beam;
    use crate::raycast::beam::tests::oblique_grid;
    use crate::raycast::ray::TRANSVERSE;

    const SIZE: [usize; 2] = [37, 22];

    /// Holds the rays in closed form to those that are made one by one.
    fn same(name: &str, view: View, grid: &Grid) {
        let beam = Beam::new(&view, grid, SIZE).expect("valid");
        let lines = beam.lines();
        for (i, j) in [(0.0, 0.0), (36.0, 0.0), (18.3, 10.2), (-0.5, 21.5), (36.0, 21.0)] {
            let ray = beam.ray(i, j);
            let (axis, direction) = (ray.axis, lines.direction.at(i, j));
            // Where the line crosses the plane through the centre, across the driving axis.
            let crossing = match &lines.anchor {
                Anchor::Point(point) => {
                    let from = point.at(i, j) - lines.centre;
                    from - from[axis] / direction[axis] * direction
                }
                Anchor::Moment(moment) => DVec3::AXES[axis].cross(moment.at(i, j)) / direction[axis],
            };
            for (t, &b) in TRANSVERSE[axis].iter().enumerate() {
                let slope = direction[b] / direction[axis] - ray.slope[t];
                assert!(slope.abs() < 1e-12, "{name}: slope off by {slope:e}");
                let base = crossing[b] + lines.centre[b] - ray.base[t];
                assert!(base.abs() < 1e-12 * ray.base[t].abs().max(1.0), "{name}: base off by {base:e}");
            }
            let ends = [lines.source, lines.pixel.map(|pixel| pixel.at(i, j))];
            let ends = ends.map(|end| end.map(|point| point[axis]));
            for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
                let end = end.unwrap_or(sign * direction[axis].signum() * f64::INFINITY);
                let near = |s: &f64| *s == end || (s - end).abs() < 1e-12 * end.abs().max(1.0);
                assert!(ray.limits.iter().any(near), "{name}: {end} of {ray:?}");
            }
        }
    }

    #[test]
    fn all_rays_at_once_are_the_rays_one_by_one() {
        let grid = oblique_grid();
        for (n, distance) in [300.0, 1000.0, 1e5].into_iter().enumerate() {
            for angle in [0.0, 17.0, 100.0, 226.0] {
                let pose = DetectorPose {
                    row_step: DVec3::new(0.1, 0.3, 2.0),
                    ..DetectorPose::c_arm(grid.centre(), angle, distance, distance + 500.0, 1.5, SIZE)
                };
                same(&format!("pose {n} at {angle}"), View::Pose(pose), &grid);
                let projection = Projection::from_pose(&pose, SIZE).expect("valid");
                same(&format!("matrix {n} at {angle}"), View::Projection(projection), &grid);
            }
        }
        let matrix = DMat4::from_diagonal(DVec4::new(0.02, 0.03, 0.005, 1.0)) * DMat4::from_rotation_y(0.3);
        same("parallel", View::Projection(Projection { matrix, source: DVec3::NAN }), &grid);
    }

    #[test]
    fn a_detector_close_by_is_the_anchor() {
        let grid = oblique_grid();
        let pose = DetectorPose::c_arm(grid.centre(), 30.0, 1e4, 1e4 + 50.0, 1.0, SIZE);
        let lines = Beam::new(&View::Pose(pose), &grid, SIZE).expect("valid").lines();
        assert!(matches!(lines.anchor, Anchor::Point(point) if point.column != DVec3::ZERO));
        same("far source", View::Pose(pose), &grid);
    }
}
