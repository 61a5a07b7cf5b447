//! The views that a tolerance is measured on.

use crate::geometry::{DetectorPose, View};
use crate::scene::Scene;
use crate::volume::Volume;

/// Views where a scene expects none: half a turn of a C-arm.
const VIEWS: usize = 6;

/// Source to axis, mm, or four times the volume's radius where that is more.
const SAD_MM: f64 = 1000.0;

/// Source to detector over source to axis.
const MAGNIFICATION: f64 = 1.5;

/// The views that a scene expects; where it expects none, C-arm views all around that see the whole volume.
pub(super) fn views(scene: &Scene, volume: &Volume) -> Vec<View> {
    if !scene.expected_views.is_empty() {
        return scene.expected_views.clone();
    }
    let grid = volume.grid();
    let corner = 0.5 * glam::DVec3::from_array(grid.dimensions().map(|n| n as f64));
    let columns = grid.index_to_world().matrix3.to_cols_array_2d().map(glam::DVec3::from_array);
    let radius =
        columns.iter().zip(corner.to_array()).map(|(column, half)| half * column.length()).sum::<f64>();
    let sad = SAD_MM.max(4.0 * radius);
    let narrow = scene.detector[0].min(scene.detector[1]) as f64;
    let pixel = 2.0 * MAGNIFICATION * radius / narrow;
    let pose = |n: usize| {
        let angle = 180.0 * n as f64 / VIEWS as f64;
        DetectorPose::c_arm(grid.centre(), angle, sad, MAGNIFICATION * sad, pixel, scene.detector)
    };
    (0..VIEWS).map(|n| View::Pose(pose(n))).collect()
}
