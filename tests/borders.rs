//! The border and clipping contract of every algorithm on every engine: what a volume's box is, what counts of a ray,
//! and what a ray that misses returns.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::volume::Volume;
use drr::{Algorithm, Scene, ViewRequest};
use glam::{DMat4, DVec3, DVec4};
use support::{awkward_grid, classification, poses, projector, requests};

/// 0 HU: 1 g/cm³ of soft tissue in the water-anchored calibration.
fn uniform(grid: Grid) -> Arc<Volume> {
    let hu = vec![0; grid.voxel_count()];
    Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"))
}

fn every_algorithm() -> Vec<(Backend, Algorithm)> {
    let fast = [
        Algorithm::Joseph,
        Algorithm::March { step: 0.5 },
        Algorithm::March { step: 0.37 },
        Algorithm::March { step: 8.0 },
        Algorithm::Siddon,
        Algorithm::DistanceDriven,
    ];
    let mut all: Vec<_> = fast.iter().flat_map(|&a| [(Backend::Cpu, a), (Backend::Reference, a)]).collect();
    all.push((Backend::Reference, Algorithm::Exact));
    all
}

fn soft_tissue(
    volume: &Arc<Volume>,
    how: (Backend, Algorithm),
    size: [usize; 2],
    views: &[ViewRequest],
) -> Vec<f32> {
    let scene = Scene { method: how.1.into(), ..Scene::new(size).expect("valid") };
    let images = projector(how.0, volume, scene).project(views, Layers::ALL, SILENT).expect("projects");
    (0..views.len()).flat_map(|view| images.areal_density(view, 2).to_vec()).collect()
}

/// A detector of parallel rays along an axis, through points of the unit grid.
fn along(axis: usize, x: DVec3) -> View {
    let [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
    let row = |a: usize, scale: f64| {
        let mut n = [0.0; 3];
        n[a] = scale;
        DVec4::new(n[0], n[1], n[2], -scale * x[a])
    };
    let matrix = DMat4::from_cols(row(u, 0.01), row(v, 0.01), row(axis, 0.001), DVec4::W).transpose();
    View::Projection(Projection { matrix, source: DVec3::ZERO })
}

#[test]
fn ten_voxels_of_one_centimetre_give_ten_grams_per_square_centimetre() {
    let grid = Grid::axis_aligned([10, 10, 10], DVec3::splat(10.0), DVec3::ZERO).expect("valid");
    let volume = uniform(grid);
    for how in every_algorithm() {
        for axis in 0..3 {
            // Through centres, between them, in the outer half voxel, and on the lower face.
            for at in [40.0, 35.0, 33.3, -4.9, 94.9, -5.0] {
                let through = soft_tissue(&volume, how, [1, 1], &[along(axis, DVec3::splat(at)).into()])[0];
                assert!((through - 10.0).abs() < 2e-6, "{how:?}, axis {axis}, at {at}: {through}");
            }
            for at in [-5.001, 95.0, 95.001] {
                let beside = soft_tissue(&volume, how, [1, 1], &[along(axis, DVec3::splat(at)).into()])[0];
                assert_eq!(beside, 0.0, "{how:?}, axis {axis}, at {at}");
            }
        }
    }
}

#[test]
fn a_uniform_volume_gives_every_ray_its_chord() {
    let size = [24, 18];
    for grid in
        [awkward_grid([31, 44, 27]), Grid::centred([1, 9, 30], DVec3::new(5.0, 1.0, 2.0)).expect("valid")]
    {
        let volume = uniform(grid);
        for (name, pose) in poses(&grid, size) {
            let views = requests([pose]);
            // The chord in double precision, from the box alone.
            let beam = drr::raycast::Beam::new(&View::Pose(pose), &grid, size).expect("valid");
            let chords: Vec<f64> = (0..size[0] * size[1])
                .map(|p| beam.ray((p % size[0]) as f64, (p / size[0]) as f64))
                .map(|ray| {
                    ray.clip(grid.dimensions()).map_or(0.0, |s| 0.1 * ray.mm_per_slice * (s.leave - s.enter))
                })
                .collect();
            assert!(chords.iter().any(|&c| c > 0.1), "{name} sees nothing");
            for how in every_algorithm() {
                for (got, chord) in soft_tissue(&volume, how, size, &views).into_iter().zip(&chords) {
                    let error = (f64::from(got) - chord).abs();
                    assert!(error <= 1e-6 * chord + 1e-6, "{how:?}, {name}: {got} for a chord of {chord}");
                }
            }
        }
    }
}

#[test]
fn a_ray_that_misses_returns_i0_exactly() {
    let grid = Grid::centred([8, 8, 8], DVec3::ONE).expect("valid");
    let pose = DetectorPose::c_arm(DVec3::new(0.0, 0.0, 500.0), 0.0, 1000.0, 1500.0, 1.0, [4, 4]);
    let scene = Scene::new([4, 4]).expect("valid");
    let i0 = scene.spectrum.total();
    for (backend, supersampling) in (1..=16).flat_map(|n| [(Backend::Cpu, n), (Backend::Reference, n)]) {
        let projector = projector(backend, &uniform(grid), Scene { supersampling, ..scene.clone() });
        let images = projector.project(&requests([pose]), Layers::ALL, SILENT).expect("projects");
        assert!(images.intensity.iter().all(|&i| i == i0 as f32));
        let twin =
            projector.reference(Algorithm::Joseph, &requests([pose]), Layers::ALL, SILENT).expect("projects");
        assert!(twin.intensity.iter().all(|&i| i == i0), "{supersampling}");
        assert!(
            images
                .line_integral
                .iter()
                .chain(&images.areal_density)
                .chain(&images.bone_path)
                .all(|&x| x == 0.0)
        );
    }
}

/// A float32 sample a rounding error outside its cell is extrapolated; vacuum must stay vacuum all the same.
#[test]
fn vacuum_beside_bone_is_never_negative() {
    let grid = Grid::axis_aligned([3, 200, 3], DVec3::ONE, DVec3::ZERO).expect("valid");
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| if i % 3 == 2 { 3000 } else { -1000 }).collect();
    let volume = Arc::new(Volume::from_int16(grid, &hu, None, &classification()).expect("valid"));
    for step in 0..200 {
        let x = 1.0 - 1e-9 * f64::from(step);
        let beside = DVec3::new(x, 0.0, 1.0);
        for algorithm in [Algorithm::Joseph, Algorithm::March { step: 0.5 }] {
            let scene = Scene { method: algorithm.into(), ..Scene::new([1, 1]).expect("valid") };
            let images = projector(Backend::Cpu, &volume, scene).project(
                &[along(1, beside).into()],
                Layers::ALL,
                SILENT,
            );
            let images = images.expect("projects");
            assert!(images.areal_density.iter().all(|&a| a >= 0.0), "{algorithm:?} at {x}: {images:?}");
            assert!(images.line_integral[0] >= 0.0);
        }
    }
}

#[test]
fn what_lies_behind_the_detector_or_the_source_does_not_count() {
    let grid = Grid::centred([20, 20, 20], DVec3::ONE).expect("valid");
    let volume = uniform(grid);
    let whole = DetectorPose::c_arm(DVec3::ZERO, 0.0, 1000.0, 1500.0, 1.0, [1, 1]);
    for how in every_algorithm() {
        for (source_y, pixel_y, mm) in
            [(-1000.0, 500.0, 20.0), (-1000.0, 3.25, 13.25), (-1.5, 500.0, 11.5), (0.5, 0.75, 0.25)]
        {
            let pose = DetectorPose {
                source: DVec3::new(0.25, source_y, 0.25),
                first_pixel: DVec3::new(0.25, pixel_y, 0.25),
                ..whole
            };
            let got = soft_tissue(&volume, how, [1, 1], &requests([pose]))[0];
            assert!((f64::from(got) - 0.1 * mm).abs() < 1e-6, "{how:?}: {got} g/cm² for {mm} mm");
            let turned = DetectorPose { source: pose.first_pixel, first_pixel: pose.source, ..pose };
            let back = soft_tissue(&volume, how, [1, 1], &requests([turned]))[0];
            assert!((back - got).abs() < 1e-6, "{how:?}: {got} there, {back} back");
        }
        let cone = Projection::from_pose(&whole, [1, 1]).expect("valid");
        let inside =
            Projection::from_pose(&DetectorPose { source: DVec3::ZERO, ..whole }, [1, 1]).expect("valid");
        for (projection, mm) in [(cone, 20.0), (inside, 10.0)] {
            let got = soft_tissue(&volume, how, [1, 1], &[View::Projection(projection).into()])[0];
            assert!((f64::from(got) - 0.1 * mm).abs() < 1e-6, "{how:?}: {got} g/cm² for {mm} mm");
        }
    }
}

#[test]
fn supersampling_averages_intensities() {
    let grid = awkward_grid([30, 25, 28]);
    let volume = support::volume(grid);
    let (_, pose) = poses(&grid, [12, 10])[0];
    let n = 3;
    let fine = DetectorPose {
        first_pixel: pose.pixel(-1.0 / 3.0, -1.0 / 3.0),
        column_step: pose.column_step / 3.0,
        row_step: pose.row_step / 3.0,
        ..pose
    };
    for backend in [Backend::Cpu, Backend::Reference] {
        let coarse = Scene { supersampling: n, ..Scene::new([12, 10]).expect("valid") };
        let coarse = projector(backend, &volume, coarse)
            .project(&requests([pose]), Layers::ALL, SILENT)
            .expect("projects");
        let rays = projector(backend, &volume, Scene::new([36, 30]).expect("valid"));
        let rays = rays.project(&requests([fine]), Layers::ALL, SILENT).expect("projects");
        let i0 = Scene::new([1, 1]).expect("valid").spectrum.total();
        for p in 0..120 {
            let (i, j) = (p % 12 * n, p / 12 * n);
            let mean: f64 =
                (0..n * n).map(|k| f64::from(rays.intensity[(j + k / n) * 36 + i + k % n])).sum::<f64>()
                    / 9.0;
            let got = f64::from(coarse.intensity[p]);
            assert!((got / mean - 1.0).abs() < 1e-6, "{backend:?} pixel {p}: {got} {mean}");
            let p_mean = -(mean / i0).ln();
            assert!((f64::from(coarse.line_integral[p]) - p_mean).abs() < 2e-6 * p_mean + 1e-6);
        }
    }
}

#[test]
fn bone_path_is_length_by_label_whatever_the_density() {
    let grid = Grid::centred([20, 30, 20], DVec3::new(1.0, 2.0, 1.0)).expect("valid");
    let labels: Vec<u8> =
        (0..grid.voxel_count()).map(|i| if (5..12).contains(&(i / 20 % 30)) { 3 } else { 2 }).collect();
    let hu: Vec<i16> = (0..grid.voxel_count()).map(|i| if i % 2 == 0 { -1000 } else { 900 }).collect();
    let volume = Arc::new(Volume::from_int16(grid, &hu, Some(&labels), &classification()).expect("valid"));
    let floats: Vec<f32> = hu.iter().map(|&h| f32::from(h)).collect();
    let dense =
        Arc::new(Volume::from_float32(grid, &floats, Some(&labels), &classification()).expect("valid"));
    let pose = DetectorPose::c_arm(DVec3::ZERO, 0.0, 1000.0, 1500.0, 1.0, [9, 9]);
    for volume in [volume, dense] {
        for how in every_algorithm() {
            let scene = Scene { method: how.1.into(), ..Scene::new([9, 9]).expect("valid") };
            let images = projector(how.0, &volume, scene)
                .project(&requests([pose]), Layers::ALL, SILENT)
                .expect("projects");
            for (p, &mm) in images.bone_path.iter().enumerate() {
                let offset = DVec3::new((p % 9) as f64 - 4.0, 1500.0, (p / 9) as f64 - 4.0);
                let exact = 14.0 * offset.length() / 1500.0;
                assert!((f64::from(mm) - exact).abs() < 2e-5, "{how:?} pixel {p}: {mm} for {exact}");
            }
        }
    }
}

#[test]
fn a_step_out_of_range_is_refused_also_by_the_reference() {
    let grid = Grid::centred([8, 8, 8], DVec3::ONE).expect("valid");
    let scene = Scene::new([4, 4]).expect("valid");
    let pose = DetectorPose::c_arm(DVec3::ZERO, 0.0, 100.0, 150.0, 1.0, [4, 4]);
    let projector = projector(Backend::Cpu, &uniform(grid), scene.clone());
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 8.1] {
        let algorithm = Algorithm::March { step };
        let error =
            projector.reference(algorithm, &requests([pose]), Layers::ALL, SILENT).expect_err("out of range");
        assert!(error.to_string().starts_with("scene.step_voxels is "), "{error}");
        assert!(Scene { method: algorithm.into(), ..scene.clone() }.validate().is_err());
    }
}
