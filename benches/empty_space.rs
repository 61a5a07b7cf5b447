//! What passing over empty space gains, and what it costs where there is none: four scenes as they are, and with their vacuum
//! filled with the faintest voxels there are, 1 HU above it, over which nothing passes.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};

const DIMENSIONS: [usize; 3] = [360, 360, 332];
const SIZE: [usize; 2] = [360, 360];
const VACUUM: i16 = -1000;

/// HU of the thorax phantom with noise.
fn thorax(grid: &Grid) -> Vec<i16> {
    let mut hu = Vec::with_capacity(grid.voxel_count());
    let keep = |_: usize, slice: &[i16], _: &[u8]| {
        hu.extend_from_slice(slice);
        Ok(())
    };
    Phantom::thorax().with_noise(true).voxelise(grid, keep).expect("axis-aligned");
    hu
}

/// The scenes by name.
fn scenes(grid: &Grid) -> [(&'static str, Vec<i16>); 4] {
    let noise = |n: usize| ((n as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 59) as i16;
    let [n0, n1, _] = DIMENSIONS;
    let spine = |n: usize| {
        let off = |at: usize, n: usize| (at as f64 - 0.5 * n as f64).abs() / n as f64;
        let inside = off(n % n0, n0) < 0.06 && off(n / n0 % n1, n1) < 0.06;
        if inside { 300 + noise(n) } else { VACUUM }
    };
    let each = |hu: &dyn Fn(usize) -> i16| (0..grid.voxel_count()).map(hu).collect();
    [
        ("full box", each(&|n| 40 + noise(n))),
        ("chest", thorax(grid)),
        ("spine alone", each(&spine)),
        ("vacuum", each(&|_| VACUUM)),
    ]
}

fn empty_space(criterion: &mut Criterion) {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let grid = Phantom::thorax().grid(DIMENSIONS).expect("valid");
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 1.8, SIZE);
    let views: Vec<ViewRequest> = pair.into_iter().map(|pose| View::Pose(pose).into()).collect();
    let only = Layers { areal_density: true, ..Layers::default() };
    let mut group = criterion.benchmark_group("empty space");
    group.sample_size(10);
    for (scene, hu) in scenes(&grid) {
        let filled: Vec<i16> = hu.iter().map(|&hu| hu.max(VACUUM + 1)).collect();
        for (fill, hu) in [("as it is", hu), ("filled", filled)] {
            let volume = Arc::new(Volume::from_int16(grid, &hu, None, &how).expect("valid"));
            for algorithm in [Algorithm::Joseph, Algorithm::March { step: 1.0 }] {
                let scene_of = Scene { method: algorithm.into(), ..Scene::new(SIZE).expect("valid") };
                let projector = Projector::new(&context, volume.clone(), scene_of).expect("valid");
                group.bench_function(format!("{scene}, {fill}, {}", algorithm.name()), |bencher| {
                    bencher.iter(|| projector.project(&views, only, SILENT).expect("projects"));
                });
            }
        }
    }
    group.finish();
}

criterion_group!(benches, empty_space);
criterion_main!(benches);
