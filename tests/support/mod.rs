//! What the integration tests share: small volumes with detail everywhere, awkward geometries, error measures.
#![allow(dead_code, missing_docs, reason = "every test program uses its own part")]

pub(crate) mod needing;

use std::process::Command;
use std::sync::Arc;

use drr::engine::Backend;
use drr::geometry::{DetectorPose, Grid, View};
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Context, Projector, Scene, ViewRequest};
use glam::{DAffine3, DMat3, DVec3};

pub(crate) fn classification() -> Classification {
    Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in")
}

/// A hash of integers to 0 … 1, so that tests need no state.
pub(crate) fn noise(n: u64) -> f64 {
    let mut z = n.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A chest of sorts: a body with two lungs, a spine and noise, all four materials, HU by voxel.
pub(crate) fn chest_hu([n0, n1, n2]: [usize; 3]) -> Vec<i16> {
    let mut hu = Vec::with_capacity(n0 * n1 * n2);
    for k in 0..n2 {
        for j in 0..n1 {
            for i in 0..n0 {
                let at = |x: usize, n: usize| 2.0 * (x as f64 + 0.5) / n as f64 - 1.0;
                let (x, y, z) = (at(i, n0), at(j, n1), at(k, n2));
                let inside =
                    |cx: f64, cy: f64, a: f64, b: f64| ((x - cx) / a).powi(2) + ((y - cy) / b).powi(2) < 1.0;
                let tissue = if !inside(0.0, 0.0, 0.9, 0.7) {
                    -1000.0
                } else if inside(0.0, 0.45, 0.12, 0.15) {
                    700.0 + 200.0 * z
                } else if inside(-0.42, -0.05, 0.3, 0.42) || inside(0.42, -0.05, 0.3, 0.42) {
                    -820.0
                } else {
                    40.0
                };
                let jitter = if tissue > -999.0 { 30.0 * (noise(hu.len() as u64) - 0.5) } else { 0.0 };
                hu.push((tissue + jitter).round() as i16);
            }
        }
    }
    hu
}

/// A sheared, mirrored, anisotropic grid far from the world's origin.
pub(crate) fn awkward_grid(dimensions: [usize; 3]) -> Grid {
    let columns =
        DMat3::from_cols(DVec3::new(-1.9, 0.1, 0.0), DVec3::new(0.05, 2.1, 0.2), DVec3::new(0.0, 0.7, 3.1));
    Grid::new(dimensions, DAffine3 { matrix3: columns, translation: DVec3::new(430.0, -77.0, 1210.0) })
        .expect("valid")
}

pub(crate) fn volume(grid: Grid) -> Arc<Volume> {
    Arc::new(Volume::from_int16(grid, &chest_hu(grid.dimensions()), None, &classification()).expect("valid"))
}

/// Whether the engine `host` can run: this machine's C++ compiler, or what is in the way.
pub(crate) fn host_compiler() -> Result<(), String> {
    Context::new(Backend::Host, 1).map_err(|error| error.to_string())?;
    let compiler = std::env::var_os("CXX").unwrap_or_else(|| "c++".into());
    match Command::new(&compiler).arg("--version").output() {
        Ok(output) if output.status.success() => Ok(()),
        Ok(output) => Err(format!("{}: {}", compiler.display(), output.status)),
        Err(error) => Err(format!("no C++ compiler: {}: {error}", compiler.display())),
    }
}

/// Views that look along every axis, obliquely, and from inside.
pub(crate) fn poses(grid: &Grid, size: [usize; 2]) -> Vec<(&'static str, DetectorPose)> {
    let extent = grid.length_mm(DVec3::from_array(grid.dimensions().map(|n| n as f64)));
    let pixel = 1.6 * extent / size[0] as f64;
    let arm = |angle| DetectorPose::c_arm(grid.centre(), angle, 1000.0, 1500.0, pixel, size);
    let turned = |pose: DetectorPose, turn: DMat3| {
        let point = |p: DVec3| grid.centre() + turn * (p - grid.centre());
        DetectorPose {
            source: point(pose.source),
            first_pixel: point(pose.first_pixel),
            column_step: turn * pose.column_step,
            row_step: turn * pose.row_step,
        }
    };
    vec![
        ("stereo left", arm(-6.0)),
        ("lateral", arm(90.0)),
        ("diagonal", arm(45.0)),
        ("from above", turned(arm(0.0), DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2))),
        ("oblique", turned(arm(33.0), DMat3::from_rotation_x(0.6) * DMat3::from_rotation_y(0.4))),
        ("source inside", DetectorPose { source: grid.centre(), ..arm(20.0) }),
        (
            "detector inside",
            DetectorPose::c_arm(grid.centre(), 10.0, 500.0, 500.0, 0.7 * extent / size[0] as f64, size),
        ),
    ]
}

pub(crate) fn projector(backend: Backend, volume: &Arc<Volume>, scene: Scene) -> Projector {
    let context = Context::new(backend, 2).expect("threads start");
    Projector::new(&context, volume.clone(), scene).expect("the scene is valid")
}

pub(crate) fn requests(poses: impl IntoIterator<Item = DetectorPose>) -> Vec<ViewRequest> {
    poses.into_iter().map(|pose| View::Pose(pose).into()).collect()
}

/// ‖x − truth‖ / ‖truth‖; 0 for two zero images.
pub(crate) fn relative_l2(x: &[f32], truth: &[f64]) -> f64 {
    assert_eq!(x.len(), truth.len());
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut x.iter().zip(truth).map(|(&a, b)| f64::from(a) - b));
    if difference == 0.0 { 0.0 } else { difference / norm(&mut truth.iter().copied()) }
}

/// Largest |x − truth| / |truth| over pixels where |truth| is above `floor`.
pub(crate) fn max_relative(x: &[f32], truth: &[f64], floor: f64) -> f64 {
    let above = x.iter().zip(truth).filter(|(_, t)| t.abs() > floor);
    // What is not a number is larger than any.
    let larger = |a: f64, b: f64| if a >= b { a } else { b };
    above.map(|(&a, t)| ((f64::from(a) - t) / t).abs()).fold(0.0, larger)
}
