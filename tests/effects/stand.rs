//! A body in front of a detector, and what to do with its images.

use std::sync::Arc;

use drr::effects::Effects;
use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::physics::{Calibration, DetectorResponse, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Context, Projector, Scene, ViewRequest};
use glam::DVec3;

/// Pixels per side.
pub(crate) const SIDE: usize = 48;
pub(crate) const SIZE: [usize; 2] = [SIDE, SIDE];
pub(crate) const SIGNALS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

/// HU of a body by its voxels' centres, mm; 2 mm voxels around the origin.
pub(crate) fn volume(sides: [usize; 3], hu: impl Fn(DVec3) -> i16) -> Arc<Volume> {
    let grid = Grid::centred(sides, DVec3::splat(2.0)).expect("valid");
    let mut values = Vec::new();
    for k in 0..sides[2] {
        for j in 0..sides[1] {
            for i in 0..sides[0] {
                let index = DVec3::new(i as f64, j as f64, k as f64);
                values.push(hu(grid.index_to_world().transform_point3(index)));
            }
        }
    }
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    Arc::new(Volume::from_int16(grid, &values, None, &how).expect("valid"))
}

/// A block of soft tissue with a rod of bone in it, and vacuum beside it.
pub(crate) fn block() -> Arc<Volume> {
    volume([40, 30, 36], |at| {
        let inside = at.x.abs() < 30.0 && at.z.abs() < 28.0;
        match (inside, (at - DVec3::new(12.0, 0.0, 0.0)).length() < 9.0) {
            (true, true) => 1000,
            (true, false) => 0,
            (false, _) => -1000,
        }
    })
}

/// Nothing.
pub(crate) fn nothing() -> Arc<Volume> {
    volume([4, 4, 4], |_| -1000)
}

/// From 600 mm in front of the body's centre to a detector 900 mm away.
pub(crate) fn pose(pixel_mm: f64) -> DetectorPose {
    DetectorPose::c_arm(DVec3::ZERO, 7.0, 600.0, 900.0, pixel_mm, SIZE)
}

pub(crate) fn context() -> Context {
    Context::new(Backend::Cpu, 2).expect("threads start")
}

pub(crate) fn scene(effects: Effects) -> Scene {
    let expected_views = vec![View::Pose(pose(3.0))];
    Scene { effects, expected_views, ..Scene::new(SIZE).expect("valid") }
}

pub(crate) fn response(name: &str) -> DetectorResponse {
    DetectorResponse::named(name, *Scene::new(SIZE).expect("valid").spectrum.grid()).expect("built in")
}

pub(crate) fn projector(volume: &Arc<Volume>, scene: Scene) -> Projector {
    Projector::new(&context(), volume.clone(), scene).expect("valid")
}

pub(crate) fn view(pixel_mm: f64) -> ViewRequest {
    View::Pose(pose(pixel_mm)).into()
}

/// One view of `volume` with pixels of 3 mm.
pub(crate) fn image(volume: &Arc<Volume>, scene: Scene) -> Images<f32> {
    projector(volume, scene).project(&[view(3.0)], SIGNALS, SILENT).expect("projects")
}

/// The intensities of one view of `volume` with these effects.
pub(crate) fn intensity(volume: &Arc<Volume>, effects: Effects) -> Vec<f64> {
    image(volume, scene(effects)).intensity.into_iter().map(f64::from).collect()
}

/// The largest |a/b − 1|.
pub(crate) fn worst_ratio(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max)
}

pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Unbiased.
pub(crate) fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64
}

/// A Gaussian blur by its definition: sampled, normalised, edges held; σ in pixels.
pub(crate) fn blurred(image: &[f64], sigma: f64) -> Vec<f64> {
    let reach = (6.0 * sigma).ceil() as i32;
    let weight = |n: i32| (-0.5 * (f64::from(n) / sigma).powi(2)).exp();
    let total: f64 = (-reach..=reach).map(weight).sum();
    let at = |k: usize, n: i32| (k as i32 + n).clamp(0, SIDE as i32 - 1) as usize;
    let along = |image: &[f64], step: [usize; 2]| -> Vec<f64> {
        let pixel = |k: usize| {
            let (i, j) = (k % SIDE, k / SIDE);
            let tap = |n: i32| {
                let (i, j) = if step[0] == 1 { (at(i, n), j) } else { (i, at(j, n)) };
                weight(n) / total * image[j * SIDE + i]
            };
            (-reach..=reach).map(tap).sum()
        };
        (0..image.len()).map(pixel).collect()
    };
    along(&along(image, [1, 0]), [0, 1])
}
