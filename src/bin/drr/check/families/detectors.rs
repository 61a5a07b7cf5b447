//! Detectors: pixels that are not square, not rectangular, few, many, odd, even, turned, off-centre.

use drr::geometry::{DetectorPose, View};
use glam::DVec3;

use crate::check::case::{Case, Demand, Set};
use crate::check::volumes::{SMALL, classification, grey, mixed, spaced_grid, unit_grid};

pub(super) fn cases() -> Vec<Case> {
    let grid = spaced_grid(SMALL, DVec3::new(1.1, 0.9, 1.3));
    let arm = |size| DetectorPose::c_arm(grid.centre(), 20.0, 300.0, 500.0, 2.5, size);
    let mut cases = Vec::new();
    // The grid's sides are even: its central planes are faces.
    let mut add = |name: &str, size: [usize; 2], pose: DetectorPose| {
        let set = Set::posed(mixed(grid), size, pose);
        cases.push(Case { family: 16, name: name.into(), demand: Demand::NearFace(set) });
    };
    // An odd detector has a pixel on the central ray, an even one a corner: both along the grid at angle 0.
    for (name, size) in
        [("1x1", [1, 1]), ("2x2", [2, 2]), ("3x3", [3, 3]), ("1x5", [1, 5]), ("4x1", [4, 1]), ("4x3", [4, 3])]
    {
        let pose = DetectorPose::c_arm(grid.centre(), 0.0, 300.0, 500.0, 2.5, size);
        add(&format!("{name} along the grid"), size, pose);
    }
    let base = arm([3, 4]);
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
    cases.extend(deterministic());
    cases
}

/// One view at a time or all together, alone or in a crowd: the same bytes.
fn deterministic() -> Vec<Case> {
    let grid = unit_grid([20, 18, 22]);
    let size = [21, 19];
    let arm = |angle| DetectorPose::c_arm(grid.centre(), angle, 100.0, 150.0, 2.0, size);
    let set = |angles: &[f64]| {
        let mut set = Set::new(grey(grid), size, View::Pose(arm(angles[0])));
        set.views = angles.iter().map(|&angle| View::Pose(arm(angle)).into()).collect();
        set
    };
    let views = set(&[-6.0, 6.0, 90.0]);
    let shared = views.clone();
    let mut cases = vec![Case {
        family: 27,
        name: "the same projection twice".into(),
        demand: Demand::Same(Box::new([views, shared])),
    }];
    // Integer CT numbers are the same in both kinds of storage.
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| -1000 + 125 * ((i * 7) % 9) as i16).collect();
    let labels = vec![2; hu.len()];
    let wide: Vec<f32> = hu.iter().map(|&hu| f32::from(hu)).collect();
    let stored = |volume: drr::Result<drr::volume::Volume>| {
        let volume = std::sync::Arc::new(volume.expect("valid"));
        Set::new(volume, size, View::Pose(arm(17.0)))
    };
    cases.push(Case {
        family: 27,
        name: "int16 and float32 voxels".into(),
        demand: Demand::Same(Box::new([
            stored(drr::volume::Volume::from_int16(grid, &hu, Some(&labels), &classification())),
            stored(drr::volume::Volume::from_float32(grid, &wide, Some(&labels), &classification())),
        ])),
    });
    cases
}
