//! Line integrals of one material are those of a linear map.

use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::*;
use crate::geometry::{DetectorPose, Grid, Projection, View};
use crate::physics::{Calibration, Thresholds};
use crate::raycast::Beam;
use crate::volume::Classification;
use crate::{Context, LinearOperator, RayTransform};

const SIZE: [usize; 2] = [23, 17];

/// Axis-aligned, askew with shear and a mirrored axis, and a single slice.
fn grids() -> [Grid; 3] {
    let askew =
        DMat3::from_cols(DVec3::new(-1.7, 0.2, 0.0), DVec3::new(0.5, 1.9, 0.4), DVec3::new(0.1, 0.6, 2.5));
    let askew = DAffine3 { matrix3: askew, translation: DVec3::new(30.0, -12.0, 7.0) };
    [
        Grid::centred([19, 16, 14], DVec3::new(1.0, 1.3, 1.1)),
        Grid::new([14, 21, 10], askew),
        Grid::centred([12, 15, 1], DVec3::new(1.0, 1.2, 9.0)),
    ]
    .map(|grid| grid.expect("valid"))
}

/// Poses outside and inside the volume, rays of several driving axes, and a parallel beam. No ray runs in a plane between
/// voxels, where rounding decides to which side Siddon's lengths go.
fn views(grid: &Grid) -> Vec<View> {
    let centre = grid.centre() + DVec3::new(0.13, 0.07, 0.11);
    let pose = |angle, sad| DetectorPose::c_arm(centre, angle, sad, sad + 40.0, 2.5, SIZE);
    let matrix = DMat4::from_diagonal(DVec4::new(0.05, 0.06, 0.005, 1.0))
        * DMat4::from_rotation_y(0.7)
        * DMat4::from_translation(-centre);
    let mut views: Vec<_> = [(0.0, 90.0), (44.0, 60.0), (100.0, 2.0), (230.0, 500.0)]
        .into_iter()
        .map(|(angle, sad)| View::Pose(pose(angle, sad)))
        .collect();
    views.push(View::Projection(Projection::from_pose(&pose(48.0, 60.0), SIZE).expect("valid")));
    views.push(View::Projection(Projection { matrix, source: DVec3::NAN }));
    views
}

fn volume(grid: Grid) -> Volume {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|n| (n * 7919 % 2003) as i16 - 900).collect();
    Volume::from_int16(grid, &hu, Some(&vec![2; hu.len()]), &how).expect("valid")
}

#[test]
fn one_material_is_the_ray_transform_of_its_density() {
    let context = Context::new(Backend::Reference, 2).expect("threads");
    let scene = Scene::new(SIZE).expect("valid");
    for (n, grid) in grids().into_iter().enumerate() {
        let (volume, views) = (Arc::new(volume(grid)), views(&grid));
        let density: Vec<f64> = (0..grid.voxel_count()).map(|n| volume.voxels().get(n).density).collect();
        for algorithm in [
            Algorithm::Joseph,
            Algorithm::March { step: 0.7 },
            Algorithm::Siddon,
            Algorithm::DistanceDriven,
            Algorithm::Exact,
        ] {
            let reference = Reference::new(volume.clone(), &scene, algorithm).expect("valid");
            let transform = RayTransform::new(&context, grid, &views, SIZE, algorithm).expect("valid");
            let images = transform.forward(&density).expect("valid");
            for (pixel, line_integral) in images.into_iter().enumerate() {
                let (view, j, i) = (pixel / SIZE[0] / SIZE[1], pixel / SIZE[0] % SIZE[1], pixel % SIZE[0]);
                let beam = Beam::new(&views[view], &grid, SIZE).expect("valid");
                let (ray, footprint) = (beam.ray(i as f64, j as f64), beam.footprint(i as f64, j as f64));
                let span = ray.clip(grid.dimensions());
                let expected = span.map_or(0.0, |span| reference.areal_density(&ray, &footprint, span)[2]);
                // g/cm³ · mm and g/cm².
                let off = (0.1 * line_integral - expected).abs();
                assert!(off < 1e-13, "grid {n}, {algorithm}, view {view}: {expected}, {off:e} off");
            }
        }
    }
}
