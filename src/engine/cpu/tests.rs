use glam::DVec3;

use super::*;
use crate::engine::{Backend, Progress, SILENT};
use crate::geometry::{DetectorPose, Grid, View};
use crate::method::{Method, Storage};
use crate::physics::{Calibration, Thresholds};
use crate::volume::Classification;

const SIZE: [usize; 2] = [50, 37];
const DIMENSIONS: [usize; 3] = [150, 83, 61];

/// Padding around a ball of lung and bone; a speck of bone in a corner, and a column of soft tissue along a face.
fn volume() -> Arc<Volume> {
    let grid = Grid::centred(DIMENSIONS, DVec3::new(1.0, 1.5, 2.0)).expect("valid");
    let [n0, n1, _] = DIMENSIONS;
    let hu = |at: usize| {
        let [i, j, k] = [at % n0, at / n0 % n1, at / (n0 * n1)];
        let from = |x: usize, centre: f64, radius: f64| ((x as f64 - centre) / radius).powi(2);
        let radius = from(i, 90.0, 25.0) + from(j, 30.0, 18.0) + from(k, 33.0, 15.0);
        match (radius, [i, j, k]) {
            (..0.3, _) => 700 + (at * 7 % 90) as i16,
            (..1.0, _) => -750 + (at * 13 % 200) as i16,
            (_, [149, 0, 60]) => 1500,
            (_, [0, 50..60, _]) => 40,
            _ => -2000,
        }
    };
    let hu: Vec<i16> = (0..grid.voxel_count()).map(hu).collect();
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"))
}

/// Cone beams from along every axis, one of them from inside the volume, with pixels of 0.3 and of 30 mm at the detector.
fn views(volume: &Volume) -> Vec<ViewJob> {
    let arm = |angle, pixel| DetectorPose::c_arm(DVec3::ZERO, angle, 400.0, 700.0, pixel, SIZE);
    let above = DetectorPose {
        source: DVec3::new(5.0, -3.0, 300.0),
        first_pixel: DVec3::new(-100.0, -90.0, -200.0),
        column_step: 4.0 * DVec3::X,
        row_step: 5.0 * DVec3::Y,
    };
    let inside = DetectorPose { source: DVec3::new(-30.0, -20.0, 1.0), ..arm(30.0, 6.0) };
    let poses = [arm(0.0, 6.0), arm(90.0, 5.0), arm(-40.0, 0.3), arm(60.0, 30.0), above, inside];
    let job = |pose| {
        let beam = Beam::new(&View::Pose(pose), volume.grid(), SIZE).expect("valid");
        ViewJob { beam, early_exit: true, spectral: None, lut_addresses: [0, 0] }
    };
    poses.map(job).into()
}

/// Holds the images to those for which every cell of every ray is walked, bit by bit.
fn same_bits(volume: &Arc<Volume>, method: Method, layers: Layers) {
    let scene = Scene { method, ..Scene::new(SIZE).expect("valid") };
    let plan = Plan::new(&scene, volume, Backend::Cpu, None).expect("valid");
    let views = views(volume);
    let project = |engine: &Cpu| {
        let job = Job { views: &views, layers, progress: Progress::new(SILENT) };
        engine.project(&job).expect("memory")
    };
    let mut engine = Cpu::new(volume.clone(), &scene, &plan).expect("valid");
    // Only tiles look for the ends of rays.
    engine.sweeps = false;
    let occupied = volume.occupancy().and_then(|occupancy| occupancy.of(Matter::ANY)).expect("memory");
    engine.occupied = Some(occupied);
    let tightened = project(&engine);
    engine.occupied = None;
    let whole = project(&engine);
    let bits = |image: &[f32]| image.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert!(whole.areal_density.iter().filter(|&&a| a > 0.0).count() > 100 || whole.areal_density.is_empty());
    assert_eq!(bits(&tightened.areal_density), bits(&whole.areal_density), "{method}: areal density");
    assert_eq!(bits(&tightened.intensity), bits(&whole.intensity), "{method}: intensity");
    assert_eq!(bits(&tightened.line_integral), bits(&whole.line_integral), "{method}: line integral");
    assert_eq!(bits(&tightened.bone_path), bits(&whole.bone_path), "{method}: bone path");
}

#[test]
fn cells_of_vacuum_are_passed_over_without_a_trace() {
    let volume = volume();
    let algorithms = [
        Algorithm::Joseph,
        Algorithm::Siddon,
        Algorithm::DistanceDriven,
        Algorithm::March { step: 1.0 },
        Algorithm::March { step: 0.3 },
        Algorithm::March { step: 8.0 },
    ];
    for algorithm in algorithms {
        for accumulation in [Accumulation::Naive, Accumulation::Blocked, Accumulation::Compensated] {
            same_bits(&volume, Method { accumulation, ..algorithm.into() }, Layers::ALL);
        }
        same_bits(&volume, Method { storage: Storage::Byte, ..algorithm.into() }, Layers::ALL);
        // A ray may stop early: where depends on what it has met, not on how far it has gone.
        same_bits(&volume, algorithm.into(), Layers { intensity: true, ..Layers::default() });
    }
}
