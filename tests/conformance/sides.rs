//! Where source and detector are.

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::volume::Volume;
use drr::{Algorithm, Scene};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use crate::Test;
use crate::support::{awkward_grid, classification, noise, poses, projector, requests, volume};
use crate::twin::{conforms, conforms_with, kinds};

pub(super) const TESTS: [Test; 5] = [
    ("in_strongly_sheared_grids", in_strongly_sheared_grids),
    ("from_every_side_and_from_inside", from_every_side_and_from_inside),
    ("through_projection_matrices_and_from_afar", through_projection_matrices_and_from_afar),
    ("along_parallel_rays", along_parallel_rays),
    ("in_thin_and_in_long_grids", in_thin_and_in_long_grids),
];

const SIZE: [usize; 2] = [40, 28];

fn from_every_side_and_from_inside(backend: Backend) {
    let grid = awkward_grid([70, 61, 53]);
    let volume = volume(grid);
    for (name, pose) in poses(&grid, SIZE) {
        conforms(backend, name, &volume, &Scene::new(SIZE).expect("valid"), &requests([pose]));
    }
}

fn through_projection_matrices_and_from_afar(backend: Backend) {
    let grid = Grid::centred([60, 50, 55], DVec3::new(1.1, 1.3, 0.9)).expect("valid");
    let volume = volume(grid);
    let scene = Scene::new(SIZE).expect("valid");
    for distance in [400.0, 1e4, 1e6, 1e9] {
        let pose = DetectorPose::c_arm(DVec3::ZERO, 23.0, distance, distance + 300.0, 2.0, SIZE);
        conforms(backend, "pose", &volume, &scene, &requests([pose]));
        if distance < 1e9 {
            let projection = Projection::from_pose(&pose, SIZE).expect("valid");
            conforms(backend, "matrix", &volume, &scene, &[View::Projection(projection).into()]);
        }
    }
}

fn along_parallel_rays(backend: Backend) {
    let grid = Grid::centred([60, 50, 55], DVec3::new(1.1, 1.3, 0.9)).expect("valid");
    let volume = volume(grid);
    for turn in [DMat3::IDENTITY, DMat3::from_rotation_y(1.1), DMat3::from_rotation_x(0.4)] {
        let matrix = DMat4::from_diagonal(DVec4::new(0.02, 0.025, 0.005, 1.0)) * DMat4::from_mat3(turn);
        let view = View::Projection(Projection { matrix, source: DVec3::NAN });
        conforms(backend, "parallel", &volume, &Scene::new(SIZE).expect("valid"), &[view.into()]);
    }
}

/// Rays that cross such a grid near its end are far from its middle: float32 must not notice. The voxels are white noise,
/// so that an error of position shows at once.
fn in_thin_and_in_long_grids(backend: Backend) {
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
            conforms(backend, &name, &volume, &Scene::new([14, 12]).expect("valid"), &requests([pose]));
        }
    }
}

/// Rays at 45° have two driving axes to choose from; rounding decides, and must not show.
pub(super) fn a_tie_of_driving_axes_is_no_jump() {
    let grid = Grid::centred([64, 64, 20], DVec3::ONE).expect("valid");
    let volume = volume(grid);
    let arm = |angle| DetectorPose::c_arm(DVec3::new(0.1, 0.2, 0.3), angle, 300.0, 500.0, 1.0, [1, 9]);
    for algorithm in [Algorithm::Joseph, Algorithm::Siddon, Algorithm::Exact] {
        let reference = projector(
            Backend::Reference,
            &volume,
            Scene { method: algorithm.into(), ..Scene::new([1, 9]).expect("valid") },
        );
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

/// A ray's length is what is left of columns that nearly cancel.
fn in_strongly_sheared_grids(backend: Backend) {
    for shear in [30.7, 300.7, 3000.7] {
        let columns = DMat3::from_cols(DVec3::X, DVec3::new(shear, 1.0, 0.0), DVec3::Z);
        let place = DAffine3 { matrix3: columns, translation: DVec3::ZERO };
        let grid = Grid::new([61, 51, 41], place).expect("valid");
        let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| (100.0 * noise(i as u64 / 5)) as i16).collect();
        let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
        let direction = DVec3::new(1.0, 1.0, 0.0).normalize();
        let (column_step, row_step) = (0.1 * direction.any_orthonormal_pair().0, 0.1 * DVec3::Z);
        let first_pixel = grid.centre() + 500.0 * direction - 10.0 * column_step - 8.0 * row_step;
        let source = grid.centre() - 1000.0 * direction;
        let pose = DetectorPose { source, first_pixel, column_step, row_step };
        let scene = Scene::new([20, 16]).expect("valid");
        conforms_with(kinds(backend), backend, &format!("shear {shear}"), &volume, &scene, &requests([pose]));
    }
}
