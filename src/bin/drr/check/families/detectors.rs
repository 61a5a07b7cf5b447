//! Detectors: pixels that are not square, not rectangular, few, many, odd, even, turned, off-centre.

use drr::geometry::DetectorPose;
use glam::DVec3;

use crate::check::case::{Case, Set};
use crate::check::volumes::{SMALL, mixed, spaced_grid};

pub(super) fn cases() -> Vec<Case> {
    let grid = spaced_grid(SMALL, DVec3::new(1.1, 0.9, 1.3));
    let arm = |angle, size| DetectorPose::c_arm(grid.centre(), angle, 300.0, 500.0, 2.5, size);
    let mut cases = Vec::new();
    // The grid's sides are even: its central planes are faces.
    let mut add = |name: &str, size: [usize; 2], pose: DetectorPose| {
        cases.push(Case::near_face(16, name, Set::posed(mixed(grid), size, pose)));
    };
    // An odd detector has a pixel on the central ray, an even one a corner: both along the grid at angle 0.
    for [width, height] in [[1, 1], [2, 2], [3, 3], [1, 5], [4, 1], [4, 3]] {
        let size = [width, height];
        add(&format!("{width}x{height} along the grid"), size, arm(0.0, size));
    }
    let base = arm(20.0, [3, 4]);
    add("pixels of 2.5 x 0.5 mm", [3, 4], DetectorPose { row_step: 0.2 * base.row_step, ..base });
    add("sheared pixels", [3, 4], DetectorPose { row_step: base.row_step + 0.4 * base.column_step, ..base });
    add("rows downwards, columns backwards", [3, 4], {
        let last = base.pixel(2.0, 3.0);
        DetectorPose { first_pixel: last, column_step: -base.column_step, row_step: -base.row_step, ..base }
    });
    add(
        "turned by a right angle",
        [4, 3],
        DetectorPose { column_step: base.row_step, row_step: base.column_step, ..base },
    );
    add(
        "far off the central ray",
        [3, 4],
        DetectorPose {
            first_pixel: base.first_pixel + 150.0 * DVec3::Z,
            source: base.source - 225.0 * DVec3::Z,
            ..base
        },
    );
    add("inclined by 80 degrees", [3, 4], {
        let tilted = 0.17 * base.row_step + 2.4 * (base.pixel(1.0, 1.5) - base.source).normalize();
        DetectorPose { row_step: tilted, first_pixel: base.pixel(0.0, 1.5) - 1.5 * tilted, ..base }
    });
    add(
        "pixels of a nanometre",
        [2, 2],
        DetectorPose {
            column_step: 4e-7 * base.column_step,
            row_step: 4e-7 * base.row_step,
            first_pixel: base.pixel(1.0, 1.5),
            ..base
        },
    );
    cases
}
