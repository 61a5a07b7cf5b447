//! What voxels hold: materials, calibrations, thresholds, one label or eight, and how they are stored.

use std::sync::Arc;

use drr::Scene;
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid};
use drr::physics::{Calibration, DensitySegment, MassAttenuation, Thresholds};
use drr::volume::{Classification, Volume};

use crate::Test;
use crate::support::{awkward_grid, chest_hu, classification, noise, poses, projector, requests};
use crate::twin::{conforms, conforms_with, kinds};

pub(super) const TESTS: [Test; 7] = [
    ("with_one_material_with_two_and_with_eight", with_one_material_with_two_and_with_eight),
    ("with_every_calibration", with_every_calibration),
    ("with_calibrations_of_ones_own", with_calibrations_of_ones_own),
    ("with_every_threshold_scheme", with_every_threshold_scheme),
    ("of_one_label", of_one_label),
    ("of_round_densities", of_round_densities),
    ("of_vacuum", of_vacuum),
];

const SIZE: [usize; 2] = [40, 28];

const EIGHT: [&str; 8] =
    ["air", "lung", "soft_tissue", "bone_cortical", "adipose", "muscle", "blood", "titanium"];

fn small() -> (Grid, DetectorPose) {
    let grid = awkward_grid([40, 45, 38]);
    (grid, poses(&grid, SIZE)[4].1)
}

/// A scene with these materials, of which one is bone.
fn scene(materials: &[&str], bone: Option<u8>) -> Scene {
    let scene = Scene::new(SIZE).expect("valid");
    let materials = MassAttenuation::named(materials, *scene.spectrum.grid()).expect("tabulated");
    Scene { materials, bone, ..scene }
}

/// A chest on a table of padding, with every density that a calibration has, up to metal.
fn chest_and_extremes(dimensions: [usize; 3]) -> Vec<i16> {
    let mut hu = chest_hu(dimensions);
    let slices = hu.len() / dimensions[2];
    hu[..slices].fill(-2000);
    for (i, hu) in hu.iter_mut().enumerate().filter(|(i, _)| i % 97 == 0) {
        *hu = (-1100.0 + 5000.0 * noise(i as u64)) as i16;
    }
    hu
}

fn with_one_material_with_two_and_with_eight(backend: Backend) {
    let (grid, pose) = small();
    let hu = chest_hu(grid.dimensions());
    for count in [1, 2, 8] {
        let labels: Vec<u8> =
            (0..hu.len()).map(|i| (noise(i as u64 / 50) * f64::from(count)) as u8).collect();
        let scene = scene(&EIGHT[..usize::from(count)], Some(count - 1));
        let int16 = Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid");
        conforms(backend, "int16", &Arc::new(int16), &scene, &requests([pose]));
        let halves: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.5).collect();
        let float32 = Volume::from_float32(grid, &halves, Some(&labels), &classification()).expect("valid");
        conforms(backend, "float32", &Arc::new(float32), &scene, &requests([pose]));
    }
}

/// Thresholds decide the labels; materials, and whether any is bone, follow from them.
fn classified(backend: Backend, calibration: &str, thresholds: &str) {
    let (grid, pose) = small();
    let how = Classification::named(calibration, thresholds).expect("built in");
    let names: Vec<&str> = how.thresholds.materials().iter().map(String::as_str).collect();
    let bone = names.iter().position(|name| name.contains("bone")).map(|bone| bone as u8);
    let hu = chest_and_extremes(grid.dimensions());
    let volume = Volume::from_int16(grid, &hu, None, &how).expect("valid");
    let name = format!("{calibration}, {thresholds}");
    conforms(backend, &name, &Arc::new(volume), &scene(&names, bone), &requests([pose]));
}

fn with_every_calibration(backend: Backend) {
    for calibration in Calibration::names() {
        classified(backend, calibration, Thresholds::DEFAULT);
    }
}

/// Curves that the built-in ones do not have: level, up and down, steeper above, with a jump.
fn with_calibrations_of_ones_own(backend: Backend) {
    let (grid, pose) = small();
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| (3900.0 * noise(i as u64) - 900.0) as i16).collect();
    let line = |from: f64, to: f64, at_0: f64, slope: f64| DensitySegment {
        first_hu: from,
        end_hu: to,
        intercept: at_0,
        slope,
    };
    for (name, segments) in [
        ("a level ceiling", vec![line(-1000.0, 100.0, 1.0, 1e-3), line(100.0, 1e4, 1.1, 0.0)]),
        ("level", vec![line(-1000.0, 1e4, 1.0, 0.0)]),
        ("up and down", vec![line(-1000.0, 1048.0, 1.0, 1e-3), line(1048.0, 1e4, 3.096, -1e-3)]),
        ("steeper above", vec![line(-1000.0, 0.0, 1.0, 1e-3), line(0.0, 1e4, 1.0, 2e-3)]),
        ("with a jump", vec![line(-1000.0, 0.0, 1.0, 1e-3), line(0.0, 1e4, 1.2, 1e-3)]),
    ] {
        let calibration = Calibration::new(name, segments).expect("valid");
        let thresholds = Thresholds::named(Thresholds::DEFAULT).expect("built in");
        let how = Classification { calibration, thresholds };
        for labels in [None, Some(vec![2; hu.len()])] {
            let volume = Volume::from_int16(grid, &hu, labels.as_deref(), &how).expect("valid");
            let scene = Scene::new(SIZE).expect("valid");
            conforms_with(kinds(backend), backend, name, &Arc::new(volume), &scene, &requests([pose]));
        }
    }
}

fn with_every_threshold_scheme(backend: Backend) {
    for thresholds in Thresholds::names() {
        classified(backend, Calibration::DEFAULT, thresholds);
    }
    classified(backend, "schneider2000", "six_class");
    classified(backend, "linear", "deepdrr_thresholds");
}

/// Nothing has to be told apart; with each way from a voxel's code to its density, and with a label that is not 0.
fn of_one_label(backend: Backend) {
    let (grid, pose) = small();
    let hu = chest_and_extremes(grid.dimensions());
    for (calibration, label) in [("water_anchored", 5), ("linear", 0), ("schneider2000", 7)] {
        let how = Classification::named(calibration, Thresholds::DEFAULT).expect("built in");
        let labels = vec![label; hu.len()];
        let scene = scene(&EIGHT, Some(label));
        let int16 = Volume::from_int16(grid, &hu, Some(&labels), &how).expect("valid");
        conforms_with(kinds(backend), backend, calibration, &Arc::new(int16), &scene, &requests([pose]));
    }
    let wide: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.25).collect();
    let float32 = Volume::from_float32(grid, &wide, Some(&vec![3; hu.len()]), &classification());
    let volume = Arc::new(float32.expect("valid"));
    conforms_with(kinds(backend), backend, "float32", &volume, &scene(&EIGHT, Some(3)), &requests([pose]));
}

/// Powers of two, whose bits are few: none of them is taken for vacuum, and vacuum for none of them.
fn of_round_densities(backend: Backend) {
    let (grid, pose) = small();
    let how = Classification::named("linear", Thresholds::DEFAULT).expect("built in");
    let density = |i: usize| [0.0, 0.125, 0.5, 1.0, 2.0, 4.0][(6.0 * noise(i as u64 / 5)) as usize];
    let hu: Vec<f32> = (0..grid.voxel_count()).map(|i| 1000.0 * density(i) - 1000.0).collect();
    for labels in [1, 4] {
        let labels: Vec<u8> =
            (0..hu.len()).map(|i| (noise(i as u64 / 9) * f64::from(labels)) as u8).collect();
        let volume = Arc::new(Volume::from_float32(grid, &hu, Some(&labels), &how).expect("valid"));
        let scene = scene(&EIGHT[..4], Some(0));
        conforms_with(kinds(backend), backend, "float32", &volume, &scene, &requests([pose]));
    }
}

/// Where nothing attenuates, rays are as if nothing were there; but padding may be labelled bone.
fn of_vacuum(backend: Backend) {
    let (grid, pose) = small();
    let labels: Vec<u8> = (0..grid.voxel_count()).map(|i| (noise(i as u64) * 4.0) as u8).collect();
    let volume = Volume::from_int16(grid, &vec![-2000; labels.len()], Some(&labels), &classification());
    let volume = Arc::new(volume.expect("valid"));
    for &algorithm in kinds(backend) {
        let projector =
            projector(backend, &volume, Scene { method: algorithm.into(), ..scene(&EIGHT[..4], Some(3)) });
        let images = projector.project(&requests([pose]), Layers::ALL, SILENT).expect("projects");
        let truth = projector.reference(algorithm, &requests([pose]), Layers::ALL, SILENT).expect("projects");
        let i0 = projector.scene().spectrum.total() as f32;
        assert!(images.intensity.iter().all(|&intensity| intensity == i0));
        assert!(images.line_integral.iter().all(|&p| p == 0.0));
        assert!(images.areal_density.iter().all(|&areal| areal == 0.0));
        let error = crate::support::relative_l2(&images.bone_path, &truth.bone_path);
        assert!(error < 2e-6 && truth.bone_path.iter().any(|&mm| mm > 10.0), "{algorithm:?}: {error:.1e}");
    }
}
