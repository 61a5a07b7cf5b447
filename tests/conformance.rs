//! Each fast algorithm against its float64 twin: numerics.md's first line, for every layer, kind of volume, number of
//! materials and awkward geometry.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::physics::MassAttenuation;
use drr::volume::Volume;
use drr::{Algorithm, Scene, ViewRequest};
use glam::DVec3;
use support::{
    awkward_grid, chest_hu, classification, max_relative, noise, poses, projector, relative_l2, requests,
    volume,
};

const ALGORITHMS: [Algorithm; 6] = [
    Algorithm::Joseph,
    Algorithm::March { step: 1.0 },
    Algorithm::March { step: 0.5 },
    Algorithm::March { step: 0.37 },
    Algorithm::March { step: 2.7 },
    Algorithm::Siddon,
];

const SIZE: [usize; 2] = [40, 28];

/// Relative L2 and largest relative error of ordinary grids.
const ORDINARY: [f64; 2] = [4e-7, 1e-5];

/// Holds every algorithm and layer to its twin: relative L2 at most `l2`; every line integral p to 2e-6 p + 1e-6; every
/// areal density above a twentieth of the largest to `worst`.
fn conforms(name: &str, volume: &Arc<Volume>, scene: &Scene, views: &[ViewRequest], [l2, worst]: [f64; 2]) {
    for algorithm in ALGORITHMS {
        let projector = projector(Backend::Cpu, volume, Scene { algorithm, ..scene.clone() });
        let fast = projector.project(views, Layers::ALL, SILENT).expect("projects");
        let truth = projector.reference(algorithm, views, Layers::ALL, SILENT).expect("projects");
        for (layer, x, t) in [
            ("intensity", &fast.intensity, &truth.intensity),
            ("areal density", &fast.areal_density, &truth.areal_density),
            ("bone path", &fast.bone_path, &truth.bone_path),
        ] {
            let error = relative_l2(x, t);
            assert!(error <= l2, "{algorithm:?}, {name}, {layer}: relative L2 {error:.2e}");
        }
        for (&p, exact) in fast.line_integral.iter().zip(&truth.line_integral) {
            let error = (f64::from(p) - exact).abs();
            assert!(error <= 2e-6 * exact + 1e-6, "{algorithm:?}, {name}: p {p} for {exact}");
        }
        let largest = truth.areal_density.iter().copied().fold(0.0, f64::max);
        assert!(largest > 1e-3, "{name} sees nothing");
        let error = max_relative(&fast.areal_density, &truth.areal_density, 0.05 * largest);
        assert!(error <= worst, "{algorithm:?}, {name}: max relative {error:.2e}");
    }
}

#[test]
fn from_every_side_and_from_inside() {
    let grid = awkward_grid([70, 61, 53]);
    let volume = volume(grid);
    for (name, pose) in poses(&grid, SIZE) {
        conforms(name, &volume, &Scene::new(SIZE).expect("valid"), &requests([pose]), ORDINARY);
    }
}

#[test]
fn through_projection_matrices_and_from_afar() {
    let grid = Grid::centred([60, 50, 55], DVec3::new(1.1, 1.3, 0.9)).expect("valid");
    let volume = volume(grid);
    let scene = Scene::new(SIZE).expect("valid");
    for distance in [400.0, 1e4, 1e6, 1e9] {
        let pose = DetectorPose::c_arm(DVec3::ZERO, 23.0, distance, distance + 300.0, 2.0, SIZE);
        conforms("pose", &volume, &scene, &requests([pose]), ORDINARY);
        if distance < 1e9 {
            let projection = Projection::from_pose(&pose, SIZE).expect("valid");
            conforms("matrix", &volume, &scene, &[View::Projection(projection).into()], ORDINARY);
        }
    }
}

#[test]
fn with_one_material_with_eight_and_with_float_densities() {
    let grid = awkward_grid([40, 45, 38]);
    let hu = chest_hu(grid.dimensions());
    let (_, pose) = poses(&grid, SIZE)[4];
    let eight = ["air", "lung", "soft_tissue", "bone_cortical", "adipose", "muscle", "blood", "titanium"];
    for count in [1, 2, 8] {
        let labels: Vec<u8> =
            (0..hu.len()).map(|i| (noise(i as u64 / 50) * f64::from(count)) as u8).collect();
        let mut scene = Scene::new(SIZE).expect("valid");
        scene.materials =
            MassAttenuation::named(&eight[..usize::from(count)], *scene.spectrum.grid()).expect("tabulated");
        scene.bone = Some(count - 1);
        let int16 = Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid");
        conforms("int16", &Arc::new(int16), &scene, &requests([pose]), ORDINARY);
        let halves: Vec<f32> = hu.iter().map(|&hu| f32::from(hu) + 0.5).collect();
        let float32 = Volume::from_float32(grid, &halves, Some(&labels), &classification()).expect("valid");
        conforms("float32", &Arc::new(float32), &scene, &requests([pose]), ORDINARY);
    }
}

/// Rays that cross such a grid near its end are far from its middle: float32 must not notice. The voxels are white noise,
/// so that an error of position shows at once.
#[test]
fn in_thin_and_in_long_grids() {
    for (dimensions, spacing) in [
        ([1024, 1024, 2], DVec3::splat(0.1)),
        ([8000, 7, 5], DVec3::new(0.01, 1.0, 1.0)),
        ([1, 30, 40], DVec3::new(3.0, 1.0, 0.7)),
        ([50, 1, 1], DVec3::ONE),
        ([60, 60, 60], DVec3::new(0.01, 0.3, 10.0)),
    ] {
        let grid = Grid::centred(dimensions, spacing).expect("valid");
        let hu: Vec<i16> =
            (0..grid.voxel_count()).map(|i| (1400.0 * noise(i as u64) - 1000.0) as i16).collect();
        let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
        // Near a corner, where short chords are far from the middle.
        let target = DVec3::from_array(dimensions.map(|n| 0.9 * n as f64 - 0.5));
        let target = grid.index_to_world().transform_point3(target);
        for direction in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.9, 0.3, 0.1), DVec3::new(-0.2, 0.7, 0.6)]
        {
            let direction = direction.normalize();
            let [column_step, row_step] =
                [direction.any_orthonormal_pair().0, direction.any_orthonormal_pair().1]
                    .map(|step| 0.03 * spacing.max_element() * step);
            let first_pixel = target + 200.0 * direction - 6.5 * column_step - 5.5 * row_step;
            let pose =
                DetectorPose { source: target - 300.0 * direction, first_pixel, column_step, row_step };
            let name = format!("{dimensions:?} along {direction}");
            conforms(&name, &volume, &Scene::new([14, 12]).expect("valid"), &requests([pose]), ORDINARY);
        }
    }
}

/// Rays at 45° have two driving axes to choose from; rounding decides, and must not show.
#[test]
fn a_tie_of_driving_axes_is_no_jump() {
    let grid = Grid::centred([64, 64, 20], DVec3::ONE).expect("valid");
    let volume = volume(grid);
    let arm = |angle| DetectorPose::c_arm(DVec3::new(0.1, 0.2, 0.3), angle, 300.0, 500.0, 1.0, [1, 9]);
    for algorithm in [Algorithm::Joseph, Algorithm::Siddon, Algorithm::Exact] {
        let reference =
            projector(Backend::Reference, &volume, Scene { algorithm, ..Scene::new([1, 9]).expect("valid") });
        let images = reference.reference(
            algorithm,
            &requests([45.0 - 1e-9, 45.0 + 1e-9].map(arm)),
            Layers::ALL,
            SILENT,
        );
        let p = images.expect("projects").line_integral;
        assert!(p[4] > 0.5);
        // Joseph's samples lie elsewhere on either side; where the ray also climbs, they differ by a little.
        let bound = if algorithm == Algorithm::Joseph { 1e-5 } else { 1e-8 };
        for row in 0..9 {
            let jump = (p[row] / p[9 + row] - 1.0).abs();
            assert!(jump < bound, "{algorithm:?}, row {row}: {jump:.1e}");
        }
    }
}
