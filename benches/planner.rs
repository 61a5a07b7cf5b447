//! The planner on the CPU: what planning takes beside the projection that it plans, and how its predictions compare with
//! measured times, in several scenes. Ratios carry over to other machines; seconds do not.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::sync::Arc;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::engine::{Backend, Layers, SILENT};
use drr::geometry::{DetectorPose, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::planner::{Effort, candidates};
use drr::volume::{Classification, Volume, VolumeBuilder};
use drr::{Context, Energies, Projector, Scene, Tolerance, ViewRequest};

const SIZE: [usize; 2] = [720, 720];
const ONLY: Layers = Layers { intensity: true, line_integral: false, areal_density: false, bone_path: false };
/// Scenes: side of the volume, voxels.
const SIDES: [usize; 3] = [128, 256, 400];
const TOLERANCES: [f64; 3] = [10.0, 2.0, 0.1];

fn thorax(side: usize) -> Arc<Volume> {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid([side, side, side * 9 / 10]).expect("valid");
    let mut builder = VolumeBuilder::int16(grid, &how, false).expect("memory");
    phantom.voxelise(&grid, |_, hu, _| builder.push_int16(hu, None)).expect("axis-aligned");
    Arc::new(builder.finish().expect("complete"))
}

fn scene(volume: &Volume) -> Scene {
    let pair = DetectorPose::stereo_pair(volume.grid(), 1000.0, 1500.0, 0.9, SIZE);
    Scene { expected_views: pair.map(View::Pose).into(), ..Scene::new(SIZE).expect("valid") }
}

fn requests(scene: &Scene) -> Vec<ViewRequest> {
    scene.expected_views.iter().map(|&view| view.into()).collect()
}

fn median_seconds(projector: &Projector) -> f64 {
    let views = requests(projector.scene());
    let mut times: Vec<f64> = (0..3)
        .map(|_| {
            let start = Instant::now();
            projector.project(&views, ONLY, SILENT).expect("projects");
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[1]
}

/// Prints, for every scene, predicted over measured time of every candidate, relative to Joseph's; and, for every
/// tolerance, the chosen method's time over that of the fastest that the planner's own measurements allow.
fn predictions(context: &Context) {
    for side in SIDES {
        let volume = thorax(side);
        let scene = scene(&volume);
        let effort = Effort::new(&scene.expected_views, volume.grid(), &scene).expect("valid");
        let measured: Vec<_> = candidates(Energies::All)
            .into_iter()
            .map(|method| {
                let projector = Projector::new(context, volume.clone(), Scene { method, ..scene.clone() });
                (method, median_seconds(&projector.expect("valid")))
            })
            .collect();
        let ratio = |(method, seconds): &(drr::Method, f64)| {
            context.costs().seconds(context, *method, &effort, 106) / seconds
        };
        for pair in &measured {
            println!("{side} voxels, {}: {:.3} s, predicted {:.2} times", pair.0, pair.1, ratio(pair));
        }
        for hu in TOLERANCES {
            let tolerant = Scene { tolerance: Some(Tolerance::hu(hu)), ..scene.clone() };
            let projector = Projector::new(context, volume.clone(), tolerant).expect("within reach");
            let chosen = projector.plan().method.algorithm;
            let choice = projector.plan().choice.as_ref().expect("a choice");
            let misses = |method: &drr::Method| {
                choice.candidates.iter().any(|c| {
                    c.method.algorithm == method.algorithm && c.hu.is_some_and(|error| error.rms_high > hu)
                })
            };
            let fastest = measured.iter().filter(|(method, _)| !misses(method)).map(|(_, s)| *s);
            let own =
                measured.iter().find(|(method, _)| method.algorithm == chosen).map_or(f64::NAN, |m| m.1);
            let fastest = fastest.fold(f64::INFINITY, f64::min);
            println!("{side} voxels, {hu} HU: {chosen}, {:.2} times the fastest that may do", own / fastest);
        }
    }
}

fn planning(criterion: &mut Criterion) {
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    predictions(&context);
    let volume = thorax(400);
    let scene = scene(&volume);
    let mut group = criterion.benchmark_group("planning");
    group.sample_size(10);
    let mut n = 0;
    group.bench_function("2 HU, not planned before", |bencher| {
        bencher.iter(|| {
            // Another tolerance every time: the context remembers.
            n += 1;
            let tolerance = Some(Tolerance::hu(2.0 + 1e-9 * f64::from(n)));
            Projector::new(&context, volume.clone(), Scene { tolerance, ..scene.clone() }).expect("planned")
        });
    });
    let tolerant = Scene { tolerance: Some(Tolerance::STANDARD), ..scene.clone() };
    group.bench_function("2 HU, planned before", |bencher| {
        bencher.iter(|| Projector::new(&context, volume.clone(), tolerant.clone()).expect("planned"));
    });
    let projector = Projector::new(&context, volume.clone(), scene).expect("valid");
    let views = requests(projector.scene());
    group.bench_function("two views, joseph", |bencher| {
        bencher.iter(|| projector.project(&views, ONLY, SILENT).expect("projects"));
    });
    group.finish();
}

criterion_group!(benches, planning);
criterion_main!(benches);
