//! Every level of vector instructions against the march of tiles.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};

use crate::engine::cpu::Cpu;
use crate::engine::cpu::level::Kind;
use crate::engine::cpu::sweep::Sweep;
use crate::engine::{Backend, Engine, Images, Job, Layers, Progress, SILENT, ViewJob};
use crate::geometry::{DetectorPose, Grid, Projection, View};
use crate::plan::Plan;
use crate::raycast::Beam;
use crate::scene::Scene;
use crate::volume::{Classification, Volume};

const LAYERS: Layers = Layers { intensity: true, line_integral: true, areal_density: true, bone_path: false };

/// White noise of every material, beside vacuum.
fn volume(grid: Grid) -> Arc<Volume> {
    let how = Classification::named("water_anchored", "four_class_mcgpu_like").expect("built in");
    let [n0, n1, _] = grid.dimensions();
    let hu = |n: usize| {
        let (x, y) = (n % n0, n / n0 % n1);
        let noise = (n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
        if 3 * x < n0 || 5 * y > 4 * n1 { -1000 } else { (noise % 3000) as i16 - 1100 }
    };
    let hu: Vec<i16> = (0..grid.voxel_count()).map(hu).collect();
    Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"))
}

fn engine(volume: &Arc<Volume>, scene: &Scene) -> Cpu {
    let plan = Plan::new(scene, volume, Backend::Cpu, None).expect("valid");
    Cpu::new(volume.clone(), scene, &plan).expect("enough memory")
}

fn images(engine: &Cpu, views: &[View], size: [usize; 2]) -> Images<f32> {
    let view = |view: &View| ViewJob {
        beam: Beam::new(view, engine.volume.grid(), size).expect("valid"),
        early_exit: false,
        spectral: None,
        lut_addresses: [0, 0],
    };
    let views: Vec<_> = views.iter().map(view).collect();
    engine.project(&Job { views: &views, layers: LAYERS, progress: Progress::new(SILENT) }).expect("projects")
}

/// Views along every axis, with columns and rows along others, turned, from inside, and by matrices.
fn views(grid: &Grid, size: [usize; 2], pitch: f64) -> Vec<(String, View)> {
    let arm = |angle| DetectorPose::c_arm(grid.centre(), angle, 400.0, 601.0, pitch, size);
    let turned = |pose: DetectorPose, axis: DVec3, degrees: f64| {
        let turn = DQuat::from_axis_angle(axis, degrees.to_radians());
        DetectorPose {
            source: grid.centre() + turn * (pose.source - grid.centre()),
            first_pixel: grid.centre() + turn * (pose.first_pixel - grid.centre()),
            column_step: turn * pose.column_step,
            row_step: turn * pose.row_step,
        }
    };
    let mut poses = Vec::new();
    for angle in [-6.0, 0.0, 6.0, 45.0, 84.0, 90.0, 186.0] {
        poses.push((format!("arm at {angle}"), arm(angle)));
    }
    poses.push(("from above".into(), turned(arm(0.0), DVec3::X, 90.0)));
    poses.push(("from above, askew".into(), turned(arm(0.0), DVec3::X, 83.0)));
    poses.push(("rows along z".into(), turned(arm(3.0), DVec3::Y, 90.0)));
    poses.push(("oblique".into(), turned(turned(arm(20.0), DVec3::X, 12.0), DVec3::Y, 10.0)));
    poses.push(("wide".into(), DetectorPose::c_arm(grid.centre(), 30.0, 60.0, 90.0, 4.0 * pitch, size)));
    poses.push(("from inside".into(), DetectorPose { source: grid.centre(), ..arm(4.0) }));
    poses.push((
        "detector inside".into(),
        DetectorPose::c_arm(grid.centre(), 2.0, 400.0, 400.0, 0.6 * pitch, size),
    ));
    let mut views: Vec<_> = poses.iter().map(|(name, pose)| (name.clone(), View::Pose(*pose))).collect();
    for (name, pose) in &poses[..2] {
        let projection = Projection::from_pose(pose, size).expect("valid");
        views.push((format!("{name}, as a matrix"), View::Projection(projection)));
    }
    views
}

fn grids() -> Vec<Grid> {
    let shear =
        DMat3::from_cols(DVec3::new(-1.9, 0.1, 0.0), DVec3::new(0.05, 2.1, 0.2), DVec3::new(0.0, 0.7, 3.1));
    vec![
        Grid::centred([61, 50, 47], DVec3::splat(2.0)).expect("valid"),
        Grid::centred([40, 33, 90], DVec3::new(2.5, 3.0, 1.0)).expect("valid"),
        Grid::centred([1, 19, 30], DVec3::new(25.0, 5.0, 4.0)).expect("valid"),
        Grid::centred([70, 1, 2], DVec3::new(2.0, 30.0, 20.0)).expect("valid"),
        Grid::new([35, 41, 38], DAffine3 { matrix3: shear, translation: DVec3::new(30.0, -7.0, 9.0) })
            .expect("valid"),
    ]
}

/// Relative L2 of one layer against another.
fn off(a: &[f32], b: &[f32]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let difference = square(&mut a.iter().zip(b).map(|(&a, &b)| f64::from(a) - f64::from(b)));
    let size = square(&mut b.iter().map(|&b| f64::from(b)));
    if difference == 0.0 { 0.0 } else { (difference / size).sqrt() }
}

/// Rows of whole voxels, on their centres, from either end, and a source on a voxel's centre: places that float32 may take for the
/// neighbours of what they are.
#[test]
fn rows_on_voxels_are_seen_at_the_ends_of_bands() {
    for (spacing, n) in [(0.7, 47), (1.0, 65), (1.3, 33)] {
        let grid = Grid::centred([49, 40, n], DVec3::splat(spacing)).expect("valid");
        let volume = volume(grid);
        for height in [31, 32, 33, 63, 64, 65] {
            let size = [40, height];
            let mut engine = engine(&volume, &Scene::new(size).expect("valid"));
            let arm = DetectorPose::c_arm(grid.centre(), 0.0, 400.0, 600.0, 1.5 * spacing, size);
            let up = DetectorPose {
                first_pixel: arm.pixel(0.0, height as f64 - 1.0),
                row_step: -arm.row_step,
                ..arm
            };
            let source = grid.index_to_world().transform_point3(DVec3::new(30.0, 10.0, (n / 2) as f64));
            let matrix = DMat4::from_diagonal(DVec4::new(
                2.0 / (spacing * 40.0),
                2.0 / (spacing * height as f64),
                0.005,
                1.0,
            )) * DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2);
            let views = [
                View::Pose(arm),
                View::Pose(up),
                View::Pose(DetectorPose { source, ..arm }),
                View::Projection(Projection { matrix, source: DVec3::NAN }),
            ];
            for (v, view) in views.into_iter().enumerate() {
                engine.sweeps = false;
                let twin = images(&engine, &[view], size);
                engine.sweeps = true;
                for level in Kind::available() {
                    engine.level = level;
                    // Measured: at most 1.2e-7.
                    let off = off(&images(&engine, &[view], size).areal_density, &twin.areal_density);
                    assert!(
                        off <= 1e-6,
                        "{spacing} mm, {n} slices, {size:?}, view {v}, {}: {off:e}",
                        level.name()
                    );
                }
            }
        }
    }
}

#[test]
fn every_level_sees_what_tiles_see() {
    for grid in grids() {
        let volume = volume(grid);
        for (size, supersampling, pitch) in [([45, 38], 1, 4.0), ([16, 8], 1, 9.0), ([33, 17], 3, 6.0)] {
            let scene = Scene { supersampling, ..Scene::new(size).expect("valid") };
            let mut engine = engine(&volume, &scene);
            let mut swept = 0;
            for (name, view) in views(&grid, size, pitch) {
                engine.sweeps = false;
                let twin = images(&engine, &[view], size);
                engine.sweeps = true;
                let beam = Beam::new(&view, &grid, size).expect("valid").on_ray_grid(supersampling);
                swept += usize::from(Sweep::pays(&beam, size.map(|side| side * supersampling)));
                for level in Kind::available() {
                    engine.level = level;
                    let got = images(&engine, &[view], size);
                    let name = format!("{:?} {size:?} {name} {}", grid.dimensions(), level.name());
                    for (layer, got, twin) in [
                        ("areal density", &got.areal_density, &twin.areal_density),
                        ("line integral", &got.line_integral, &twin.line_integral),
                        ("intensity", &got.intensity, &twin.intensity),
                    ] {
                        // Measured: at most 7.2e-7, at any level.
                        let off = off(got, twin);
                        assert!(off <= 1e-6, "{name}: {layer} off by {off:e}");
                    }
                }
            }
            assert!(swept > 5, "{:?} {size:?}: only {swept} views are swept", grid.dimensions());
        }
    }
}
