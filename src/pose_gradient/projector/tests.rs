//! Derivatives against differences, values against the reference engine.

mod kinks;
mod losses;

use glam::{DAffine3, DMat3};

use super::*;
use crate::engine::reference::Reference;
use crate::engine::{Job, Layers, Progress, SILENT, ViewJob};
use crate::geometry::{Grid, View};
use crate::method::Algorithm;
use crate::physics::{Calibration, DetectorResponse, Thresholds};
use crate::raycast::Beam;
use crate::volume::{Classification, Volume};

const SIZE: [usize; 2] = [8, 7];
const DIMENSIONS: [usize; 3] = [14, 12, 13];
const ALGORITHMS: [Algorithm; 4] =
    [Algorithm::Joseph, Algorithm::March { step: 0.7 }, Algorithm::Exact, Algorithm::Siddon];

/// Anisotropic voxels on axes that are neither at right angles nor those of the world; about 30 mm wide.
fn sheared() -> Grid {
    let columns =
        DMat3::from_cols(DVec3::new(-2.0, 0.1, 0.0), DVec3::new(0.3, 2.4, 0.2), DVec3::new(0.0, 0.5, 2.2));
    Grid::new(DIMENSIONS, DAffine3 { matrix3: columns, translation: DVec3::new(40.0, -9.0, 5.0) })
        .expect("valid")
}

fn upright() -> Grid {
    Grid::centred(DIMENSIONS, DVec3::new(2.0, 2.5, 2.2)).expect("valid")
}

/// Densities without any symmetry; four labels in patches.
fn volume(grid: Grid) -> Arc<Volume> {
    let [nx, ny, nz] = DIMENSIONS;
    let place = |n: usize| [n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64);
    let hu = |n: usize| {
        let [x, y, z] = place(n);
        let smooth = 600.0 * (0.4 * x + 0.2 * y * (0.3 * z).cos()).sin() + 30.0 * z;
        (smooth + (n * 7919 % 101) as f64) as f32
    };
    let label = |n: usize| {
        let [x, y, z] = place(n);
        ((0.3 * x + 0.2 * z + (0.5 * y).sin()).floor() as u8) % 4
    };
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("known");
    let hu: Vec<f32> = (0..nx * ny * nz).map(hu).collect();
    let labels: Vec<u8> = (0..nx * ny * nz).map(label).collect();
    Arc::new(Volume::from_float32(grid, &hu, Some(&labels), &how).expect("valid"))
}

/// 120 kVp, four materials, a detector that weights energies.
fn scene(algorithm: Algorithm) -> Scene {
    let scene = Scene::new(SIZE).expect("valid");
    let response = DetectorResponse::named("bottom_energy", *scene.spectrum.grid()).expect("known");
    Scene { detector_layers: vec![response], method: algorithm.into(), ..scene }
}

fn projector<T: Real>(volume: &Arc<Volume>, scene: &Scene) -> PoseProjector<T> {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    PoseProjector::new(&context, volume.clone(), scene).expect("valid")
}

/// Source and detector on either side of the volume, the source in it, the detector in it.
fn views(grid: &Grid) -> [DetectorPose; 3] {
    let around = |source: f64, detector: f64, pixel: f64| {
        DetectorPose::c_arm(grid.centre(), 23.0, source, source + detector, pixel, SIZE)
    };
    [around(200.0, 100.0, 4.5), around(6.3, 100.0, 9.0), around(150.0, 3.7, 2.0)]
}

const MOTIONS: [RigidMotion; 2] = [
    RigidMotion { angles: [0.123, -0.071, 0.617], translation: DVec3::new(0.33, -0.41, 1.27) },
    RigidMotion { angles: [-0.52, 0.31, -1.9], translation: DVec3::new(-2.1, 0.7, -0.9) },
];

fn moved(motion: &RigidMotion, k: usize, by: f64) -> RigidMotion {
    let mut moved = *motion;
    if k < 3 {
        moved.angles[k] += by;
    } else {
        moved.translation[k - 3] += by;
    }
    moved
}

/// What tells one smooth piece of a pixel's signal from the next, where the ray is concerned: its driving axis, and whether
/// it passes.
fn pieces(grid: &Grid, view: &DetectorPose, motion: &RigidMotion) -> Vec<(usize, bool)> {
    let seen = motion.seen_from(view, grid.centre());
    let beam = Beam::new(&View::Pose(seen), grid, SIZE).expect("valid");
    let rays = (0..SIZE[0] * SIZE[1]).map(|n| beam.ray((n % SIZE[0]) as f64, (n / SIZE[0]) as f64));
    rays.map(|ray| (ray.axis, ray.clip(DIMENSIONS).is_some())).collect()
}

/// Largest distance of derivatives and central differences, relative to the largest derivative by the same parameter.
fn off(projector: &PoseProjector<f64>, view: &DetectorPose, motion: &RigidMotion, signal: Signal) -> f64 {
    let jacobian = projector.jacobian(view, motion, signal).expect("valid");
    let grid = projector.volume().grid();
    let mut worst = 0.0_f64;
    for k in 0..6 {
        let h = if k < 3 { 1e-7 } else { 1e-6 };
        let largest = jacobian.derivatives[k].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
        assert!(largest > 0.0, "parameter {k}");
        let at = |by: f64| {
            let motion = moved(motion, k, by);
            (projector.project(view, &motion, signal).expect("valid"), pieces(grid, view, &motion))
        };
        let ((after, pieces_after), (before, pieces_before)) = (at(h), at(-h));
        for n in (0..after.len()).filter(|&n| pieces_after[n] == pieces_before[n]) {
            let difference = 0.5 * (after[n] - before[n]) / h;
            worst = worst.max((difference - jacobian.derivatives[k][n]).abs() / largest);
        }
    }
    worst
}

#[test]
fn derivatives_are_those_of_differences() {
    for grid in [upright(), sheared()] {
        let volume = volume(grid);
        for algorithm in ALGORITHMS {
            let projector = projector(&volume, &scene(algorithm));
            for (v, view) in views(&grid).iter().enumerate() {
                for (motion, signal) in MOTIONS.iter().zip([Signal::LineIntegral, Signal::Intensity]) {
                    let off = off(&projector, view, motion, signal);
                    assert!(off < 1e-7, "{algorithm}, view {v}, {signal:?}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn the_mean_of_a_pixel_s_rays_has_the_mean_s_derivatives() {
    let grid = sheared();
    let scene = Scene { supersampling: 3, ..scene(Algorithm::Joseph) };
    let projector = projector(&volume(grid), &scene);
    for signal in [Signal::LineIntegral, Signal::Intensity] {
        let off = off(&projector, &views(&grid)[0], &MOTIONS[0], signal);
        assert!(off < 1e-7, "{signal:?}: {off:e}");
    }
}

#[test]
fn values_are_those_of_the_reference_engine() {
    let grid = sheared();
    let volume = volume(grid);
    for (algorithm, supersampling) in ALGORITHMS.into_iter().flat_map(|a| [(a, 1), (a, 2)]) {
        let scene = Scene { supersampling, ..scene(algorithm) };
        let projector = projector::<f64>(&volume, &scene);
        let reference = Reference::new(volume.clone(), &scene, algorithm).expect("valid");
        for view in views(&grid) {
            let seen = View::Pose(MOTIONS[0].seen_from(&view, grid.centre()));
            let beam = Beam::new(&seen, &grid, SIZE).expect("valid");
            let job = ViewJob { beam, early_exit: false, spectral: None, lut_addresses: [0, 0] };
            let job = Job { views: &[job], layers: Layers::ALL, progress: Progress::new(SILENT) };
            let images = reference.project_f64(&job).expect("valid");
            for (signal, expected) in
                [(Signal::LineIntegral, &images.line_integral), (Signal::Intensity, &images.intensity)]
            {
                let image = projector.project(&view, &MOTIONS[0], signal).expect("valid");
                let jacobian = projector.jacobian(&view, &MOTIONS[0], signal).expect("valid");
                assert_eq!(image, jacobian.image);
                for (value, expected) in image.iter().zip(expected) {
                    let off = (value - expected).abs();
                    assert!(off <= 1e-13 * expected, "{algorithm}: {value} {expected}");
                }
            }
        }
    }
}

#[test]
fn float32_has_the_twin_s_derivatives() {
    let grid = sheared();
    let volume = volume(grid);
    for algorithm in ALGORITHMS {
        let wide = projector::<f64>(&volume, &scene(algorithm));
        let narrow = projector::<f32>(&volume, &scene(algorithm));
        for view in views(&grid) {
            let wide = wide.jacobian(&view, &MOTIONS[0], Signal::LineIntegral).expect("valid");
            let narrow = narrow.jacobian(&view, &MOTIONS[0], Signal::LineIntegral).expect("valid");
            for (wide, narrow) in wide.derivatives.iter().zip(&narrow.derivatives) {
                let largest = wide.iter().fold(0.0_f64, |most, d| most.max(d.abs()));
                let off = wide.iter().zip(narrow).map(|(a, &b)| (a - f64::from(b)).abs()).fold(0.0, f64::max);
                assert!(off < 1e-5 * largest, "{algorithm}: {off:e} of {largest:e}");
            }
        }
    }
}
