//! A small body to register (for tests).

use std::sync::Arc;

use glam::DVec3;

use crate::context::Context;
use crate::engine::Backend;
use crate::geometry::{DetectorPose, Grid};
use crate::physics::{Calibration, Thresholds};
use crate::real::Real;
use crate::registration::Registrar;
use crate::scene::Scene;
use crate::volume::{Classification, Volume};

/// Pixels of its detector.
pub(super) const SIZE: [usize; 2] = [48, 48];

/// 200 mm of soft tissue with lungs, a spine and ribs that are not alike on both sides; 40³ voxels.
fn volume() -> Arc<Volume> {
    let grid = Grid::centred([40; 3], DVec3::splat(5.0)).expect("valid");
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("known");
    // How far inside an ellipsoid: 1 in it, 0 outside, a voxel wide edge.
    let inside = |at: DVec3, centre: DVec3, half: DVec3| {
        (0.5 + (1.0 - ((at - centre) / half).length()) * half.min_element() / 5.0).clamp(0.0, 1.0)
    };
    let parts = [
        (DVec3::ZERO, DVec3::new(85.0, 60.0, 90.0), 1040.0),
        (DVec3::new(-38.0, -5.0, 15.0), DVec3::new(26.0, 34.0, 50.0), -780.0),
        (DVec3::new(40.0, -8.0, 8.0), DVec3::new(22.0, 30.0, 44.0), -780.0),
        (DVec3::new(4.0, 38.0, 0.0), DVec3::new(12.0, 12.0, 85.0), 700.0),
        (DVec3::new(-60.0, 20.0, 40.0), DVec3::new(8.0, 30.0, 8.0), 900.0),
        (DVec3::new(55.0, -20.0, -45.0), DVec3::new(25.0, 8.0, 8.0), 900.0),
        (DVec3::new(-20.0, -45.0, -60.0), DVec3::new(20.0, 8.0, 10.0), 900.0),
    ];
    let hu = |n: usize| {
        let index = [n % 40, n / 40 % 40, n / 1600].map(|i| 5.0 * (i as f64 - 19.5));
        let sum = |sum: f64, &(centre, half, hu): &(DVec3, DVec3, f64)| {
            sum + hu * inside(DVec3::from_array(index), centre, half)
        };
        parts.iter().fold(-1000.0, sum) as f32
    };
    let hu: Vec<f32> = (0..64_000).map(hu).collect();
    Arc::new(Volume::from_float32(grid, &hu, None, &how).expect("valid"))
}

/// Its registrar, 120 kVp.
pub(super) fn registrar<T: Real>(threads: usize, levels: usize) -> Registrar<T> {
    let context = Context::new(Backend::Cpu, threads).expect("threads");
    Registrar::new(&context, volume(), &Scene::new(SIZE).expect("valid"), levels).expect("valid")
}

/// The ±6° pair.
pub(super) fn pair(grid: &Grid) -> [DetectorPose; 2] {
    DetectorPose::stereo_pair(grid, 1000.0, 1500.0, 6.5, SIZE)
}
