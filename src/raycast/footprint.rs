//! What a pixel covers of the slices that its ray crosses.

use glam::DVec3;

use crate::raycast::tighten::REACH;
use crate::raycast::{Anchor, Even, Lines, Ray, Span, ray::TRANSVERSE};

/// A pixel, mapped along its rays onto the slices of its ray's driving axis, to first order about that ray: a parallelogram
/// around the ray's crossing (u, v). In a parallel beam, and where the detector is parallel to the slices, that is the map
/// itself; elsewhere what it leaves out is (c/2d)² of a side, with d the ray's and c a pixel's step along the driving axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Footprint {
    /// By how much (u, v) moves along half a pixel's column step, then along half its row step, in the plane through the
    /// volume's centre.
    pub base: [[f64; 2]; 2],
    /// Changes of those per unit of s.
    pub slope: [[f64; 2]; 2],
}

impl Footprint {
    /// Nothing but the ray.
    pub(crate) const POINT: Self = Self { base: [[0.0; 2]; 2], slope: [[0.0; 2]; 2] };

    /// Half the sides along u and v of the rectangle that stands for the parallelogram of half-sides a and b, in the plane
    /// s = centre + `from_centre`: √(aᵤ² + bᵤ²), √(aᵥ² + bᵥ²). It is the parallelogram itself where its sides lie along
    /// the voxel axes; elsewhere it has the same second moments along each axis, (aᵤ² + bᵤ²)/3.
    pub(crate) fn half_widths(&self, from_centre: f64) -> [f64; 2] {
        [0, 1].map(|t| {
            let [a, b] = [0, 1].map(|side| self.base[side][t] + self.slope[side][t] * from_centre);
            a.hypot(b)
        })
    }

    /// How far beyond the faces of a voxel the pixel of `ray` can cover it within `span`, voxels; see [`REACH`].
    pub(crate) fn reach(&self, ray: &Ray, span: Span) -> f64 {
        // Half-widths are convex along the ray, and a slice at the end of the span may have its middle beyond it.
        let ends = [span.enter - 0.5, span.leave + 0.5].map(|s| self.half_widths(s - ray.centre));
        ends.as_flattened().iter().fold(0.5, |widest, half| half.max(widest)) + REACH - 0.5
    }
}

/// The footprints of all pixels of one view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Footprints {
    pub(super) lines: Lines,
    /// Side of a pixel over the distance from one to the next.
    pub(super) pixel_part: f64,
}

impl Footprints {
    /// That of the pixel (column, row), whose ray is `ray`.
    pub(crate) fn of(&self, ray: &Ray, column: f64, row: f64) -> Footprint {
        let Self { lines, pixel_part } = self;
        let direction = lines.direction.at(column, row);
        let sides = [|even: &Even| even.column, |even: &Even| even.row];
        let mut footprint = Footprint::POINT;
        let along = ray.axis;
        for (side, step) in sides.into_iter().enumerate() {
            let turn = step(&lines.direction);
            for (t, &across) in TRANSVERSE[along].iter().enumerate() {
                // Derivatives of the slope and of the crossing with the plane through the centre, both quotients.
                let slope = (turn[across] - ray.slope[t] * turn[along]) / direction[along];
                let base = match &lines.anchor {
                    Anchor::Point(point) => {
                        let (at, moved) = (point.at(column, row), step(point));
                        moved[across] - ray.slope[t] * moved[along]
                            + slope * (lines.centre[along] - at[along])
                    }
                    Anchor::Moment(moment) => {
                        let moved = DVec3::AXES[along].cross(step(moment));
                        (moved[across] - (ray.base[t] - lines.centre[across]) * turn[along])
                            / direction[along]
                    }
                };
                footprint.base[side][t] = 0.5 * pixel_part * base;
                footprint.slope[side][t] = 0.5 * pixel_part * slope;
            }
        }
        footprint
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat4, DVec4};

    use super::*;
    use crate::geometry::{DetectorPose, Grid, Projection, View};
    use crate::raycast::Beam;
    use crate::raycast::beam::tests::oblique_grid;

    const SIZE: [usize; 2] = [37, 22];

    /// Where the ray between pixels crosses the plane `from_centre` slices from the centre.
    fn crossing(beam: &Beam, column: f64, row: f64, from_centre: f64) -> [f64; 2] {
        let ray = beam.ray(column, row);
        [0, 1].map(|t| ray.base[t] + ray.slope[t] * from_centre)
    }

    /// Largest deviation from the differences between rays `apart` pixels apart, relative to the largest shift.
    fn deviation(beam: &Beam, [column, row]: [f64; 2], apart: f64) -> f64 {
        let footprint = beam.footprint(column, row);
        let (mut off, mut largest) = (0.0_f64, 0.0_f64);
        for from_centre in [-20.0, 0.0, 31.0] {
            for (side, [i, j]) in [[0.5 * apart, 0.0], [0.0, 0.5 * apart]].into_iter().enumerate() {
                let there = crossing(beam, column + i, row + j, from_centre);
                let here = crossing(beam, column - i, row - j, from_centre);
                for t in 0..2 {
                    let shift = footprint.base[side][t] + footprint.slope[side][t] * from_centre;
                    off = off.max((shift - 0.5 * (there[t] - here[t]) / apart).abs());
                    largest = largest.max(shift.abs());
                }
            }
        }
        off / largest
    }

    fn cone(angle: f64, grid: &Grid) -> DetectorPose {
        DetectorPose {
            row_step: DVec3::new(0.1, 0.3, 2.0),
            ..DetectorPose::c_arm(grid.centre(), angle, 700.0, 1100.0, 1.5, SIZE)
        }
    }

    /// What a pixel's own edges enclose differs from the first order by (c/2d)², here below 1e-6.
    #[test]
    fn sides_are_where_the_rays_of_the_pixel_s_edges_cross() {
        let grid = oblique_grid();
        for angle in [0.0, 17.0, 100.0, 226.0] {
            let pose = cone(angle, &grid);
            let projection = Projection::from_pose(&pose, SIZE).expect("valid");
            for view in [View::Pose(pose), View::Projection(projection)] {
                let beam = Beam::new(&view, &grid, SIZE).expect("valid");
                for pixel in [[0.0, 0.0], [36.0, 0.0], [18.3, 10.2], [36.0, 21.0]] {
                    let (edges, near) = (deviation(&beam, pixel, 1.0), deviation(&beam, pixel, 0.01));
                    assert!(edges < 1e-6 && near < 1e-9, "{angle}: {edges:.1e} {near:.1e}");
                }
            }
        }
    }

    #[test]
    fn a_parallel_beam_s_pixels_are_the_same_in_every_slice() {
        let grid = Grid::centred([10, 12, 9], DVec3::ONE).expect("valid");
        let matrix = DMat4::from_diagonal(DVec4::new(0.02, 0.03, 0.005, 1.0)) * DMat4::from_rotation_y(0.3);
        let beam = Beam::new(&View::Projection(Projection { matrix, source: DVec3::NAN }), &grid, SIZE);
        let beam = beam.expect("valid");
        let [first, other] = [beam.footprint(0.0, 0.0), beam.footprint(20.0, 21.0)];
        assert!(deviation(&beam, [3.0, 4.0], 1.0) < 1e-13);
        for side in 0..2 {
            for t in 0..2 {
                assert!(first.slope[side][t].abs() < 1e-16);
                assert!((first.base[side][t] - other.base[side][t]).abs() < 1e-14);
            }
        }
        // 100/37 wide on a plane that the beam meets at 0.3 rad; 66.7/22 high.
        let [u, v] = first.half_widths(7.0);
        let expected = [50.0 / 37.0 / 0.3_f64.cos(), 1.0 / 0.03 / 22.0];
        assert!((u - expected[0]).abs() < 1e-13 && (v - expected[1]).abs() < 1e-13, "{u} {v}");
    }

    #[test]
    fn a_detector_near_the_volume_has_its_pixels_size() {
        let grid = Grid::centred([10, 12, 9], DVec3::splat(0.5)).expect("valid");
        let pose = DetectorPose {
            source: DVec3::new(0.0, 0.0, -1e9),
            first_pixel: DVec3::new(-3.0, -2.0, 10.0),
            column_step: DVec3::new(0.3, 0.0, 0.0),
            row_step: DVec3::new(0.0, 0.4, 0.0),
        };
        let beam = Beam::new(&View::Pose(pose), &grid, SIZE).expect("valid");
        let [u, v] = beam.footprint(4.0, 5.0).half_widths(2.0);
        assert!((u - 0.3).abs() < 1e-8 && (v - 0.4).abs() < 1e-8, "{u} {v}");
        let [u, v] = beam.of_parts(4).footprint(4.0, 5.0).half_widths(2.0);
        assert!((u - 0.075).abs() < 1e-8 && (v - 0.1).abs() < 1e-8, "{u} {v}");
    }
}
