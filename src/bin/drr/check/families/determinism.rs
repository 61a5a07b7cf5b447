//! The same call twice; the same voxels stored in two ways.

use std::sync::Arc;

use drr::geometry::{DetectorPose, View};
use drr::volume::Volume;

use crate::check::case::{Case, Set};
use crate::check::volumes::{classification, grey, unit_grid};

pub(super) fn cases() -> Vec<Case> {
    let grid = unit_grid([20, 18, 22]);
    let size = [21, 19];
    let arm = |angle| View::Pose(DetectorPose::c_arm(grid.centre(), angle, 100.0, 150.0, 2.0, size));
    let mut views = Set::new(grey(grid), size, arm(-6.0));
    views.views.extend([6.0, 90.0].map(|angle| arm(angle).into()));
    // Integer CT numbers are the same in both kinds of storage.
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| -1000 + 125 * ((i * 7) % 9) as i16).collect();
    let labels = vec![2; hu.len()];
    let wide: Vec<f32> = hu.iter().map(|&hu| f32::from(hu)).collect();
    let stored = [
        Volume::from_int16(grid, &hu, Some(&labels), &classification()),
        Volume::from_float32(grid, &wide, Some(&labels), &classification()),
    ]
    .map(|volume| Set::new(Arc::new(volume.expect("valid")), size, arm(17.0)));
    let [int16, float32] = stored;
    vec![
        Case::same(27, "the same projection twice", [views.clone(), views]),
        Case::exact(27, "int16 voxels", int16),
        Case::exact(27, "the same as float32 voxels", float32),
    ]
}
