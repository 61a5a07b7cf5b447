//! The views that a tolerance is measured on.

use glam::DVec3;

use crate::geometry::{DetectorPose, Grid, View};
use crate::scene::Scene;
use crate::volume::Volume;

/// Degrees between the views of a scene that expects none: over half a turn, because the other half sees the same from
/// behind.
const ANGLES: [f64; 6] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0];

/// The source's distance from the volume's centre, mm, unless the volume is larger.
const SOURCE_MM: f64 = 1000.0;

/// The views that a scene expects; where it expects none, C-arm views all around that see the whole volume.
pub(super) fn views(scene: &Scene, volume: &Volume) -> Vec<View> {
    if !scene.expected_views.is_empty() {
        return scene.expected_views.clone();
    }
    ANGLES.iter().map(|&angle| View::Pose(pose(volume.grid(), angle, scene.detector))).collect()
}

/// A view of the whole volume: its detector covers the shadow of the sphere around it.
fn pose(grid: &Grid, angle: f64, size: [usize; 2]) -> DetectorPose {
    let voxels = DVec3::from_array(grid.dimensions().map(|n| n as f64));
    let corners =
        (0..4).map(|n| [1.0, if n & 1 == 0 { 1.0 } else { -1.0 }, if n & 2 == 0 { 1.0 } else { -1.0 }]);
    let diagonals = corners.map(|signs| grid.length_mm(DVec3::from_array(signs) * voxels));
    let radius = 0.5 * diagonals.fold(0.0, f64::max);
    let source = SOURCE_MM.max(2.0 * radius);
    let detector = source + radius;
    let half = detector * radius / (source * source - radius * radius).sqrt();
    let pixel = 2.0 * half / size[0].min(size[1]) as f64;
    DetectorPose::c_arm(grid.centre(), angle, source, detector, pixel, size)
}
