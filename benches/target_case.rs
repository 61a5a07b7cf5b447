//! The full target case on the CPU: 720×720×665 int16 voxels of 0.5 mm, two 720×720 views at ±6°, four materials,
//! 136 energy bins. Beside it, in the same run, the floor: one streaming read of the voxels. Ratios to it carry over to
//! other machines; seconds do not.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::hint::black_box;
use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume, VolumeBuilder, Voxels};
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::DQuat;
use rayon::prelude::*;

const DIMENSIONS: [usize; 3] = [720, 720, 665];
const SIZE: [usize; 2] = [720, 720];

/// HU of the thorax phantom with noise, all slices.
fn thorax() -> (Grid, Vec<i16>) {
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid(DIMENSIONS).expect("valid");
    let mut hu = Vec::with_capacity(grid.voxel_count());
    let keep = |_: usize, slice: &[i16], _: &[u8]| {
        hu.extend_from_slice(slice);
        Ok(())
    };
    phantom.voxelise(&grid, keep).expect("axis-aligned");
    (grid, hu)
}

/// The same view of a patient who lies askew.
fn turned(pose: &DetectorPose, grid: &Grid) -> DetectorPose {
    let turn = DQuat::from_rotation_x(0.12) * DQuat::from_rotation_y(0.17) * DQuat::from_rotation_z(0.5);
    DetectorPose {
        source: grid.centre() + turn * (pose.source - grid.centre()),
        first_pixel: grid.centre() + turn * (pose.first_pixel - grid.centre()),
        column_step: turn * pose.column_step,
        row_step: turn * pose.row_step,
    }
}

fn target_case(criterion: &mut Criterion) {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let (grid, hu) = thorax();
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let mut group = criterion.benchmark_group("target case");
    group.sample_size(10);

    group.bench_function("upload: HU to voxels", |bencher| {
        bencher.iter(|| {
            let mut builder = VolumeBuilder::int16(grid, &how, false).expect("memory");
            context.install(|| builder.push_int16(&hu, None)).expect("valid");
            builder.finish().expect("complete")
        });
    });
    let volume = Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"));
    drop(hu);

    let Voxels::Coded { codes, .. } = volume.voxels() else { unreachable!("HU are integers") };
    group.bench_function("floor: one read of the voxels", |bencher| {
        let sum = |piece: &[u16]| piece.iter().fold(0_u64, |sum, &code| sum + u64::from(code));
        bencher.iter(|| black_box(context.install(|| codes.par_chunks(1 << 16).map(sum).sum::<u64>())));
    });

    let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 0.9, SIZE);
    let views: Vec<ViewRequest> = pair.into_iter().map(|pose| View::Pose(pose).into()).collect();
    let oblique: Vec<ViewRequest> =
        pair.into_iter().map(|pose| View::Pose(turned(&pose, &grid)).into()).collect();
    let only = Layers { intensity: true, ..Layers::default() };
    let mut time = |name: String, volume: &Arc<Volume>, algorithm: Algorithm, views: &[ViewRequest]| {
        let scene = Scene { method: algorithm.into(), ..Scene::new(SIZE).expect("valid") };
        let projector = Projector::new(&context, volume.clone(), scene).expect("valid");
        group.bench_function(name, |bencher| {
            bencher.iter(|| projector.project(views, only, SILENT).expect("projects"));
        });
    };
    for algorithm in [Algorithm::Joseph, Algorithm::Siddon, Algorithm::March { step: 0.5 }] {
        time(format!("two views, {}", algorithm.name()), &volume, algorithm, &views);
    }
    time("two oblique views, joseph".into(), &volume, Algorithm::Joseph, &oblique);
    drop(volume);
    let (grid, hu) = thorax();
    let water = vec![2; hu.len()];
    let volume = Arc::new(Volume::from_int16(grid, &hu, Some(&water), &how).expect("valid"));
    time("two views of one material, joseph".into(), &volume, Algorithm::Joseph, &views);
    time("two oblique views of one material, joseph".into(), &volume, Algorithm::Joseph, &oblique);
    group.finish();
}

criterion_group!(benches, target_case);
criterion_main!(benches);
