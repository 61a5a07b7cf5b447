//! Effects on the CPU: what a scene without them pays for their being there, and what a second spectrum costs beside a
//! projection. Ratios carry over to other machines; seconds do not.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::sync::Arc;
use std::time::Instant;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::effects::{DetectorBlur, Effects, Noise};
use drr::engine::cpu::Cpu;
use drr::engine::{Backend, Engine, Job, Layers, Progress, SILENT, ViewJob};
use drr::geometry::{DetectorPose, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Spectrum, Thresholds};
use drr::raycast::Beam;
use drr::volume::{Classification, Volume, VolumeBuilder};
use drr::{Context, Projector, Scene, ViewRequest};

const SIZE: [usize; 2] = [720, 720];
const ONLY: Layers = Layers { intensity: true, line_integral: false, areal_density: false, bone_path: false };
/// Runs of each side, in turns.
const TURNS: usize = 7;

fn thorax() -> Arc<Volume> {
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid([256, 256, 240]).expect("valid");
    let mut builder = VolumeBuilder::int16(grid, &how, false).expect("memory");
    phantom.voxelise(&grid, |_, hu, _| builder.push_int16(hu, None)).expect("axis-aligned");
    Arc::new(builder.finish().expect("complete"))
}

fn pair(volume: &Volume) -> [View; 2] {
    DetectorPose::stereo_pair(volume.grid(), 1000.0, 1500.0, 0.9, SIZE).map(View::Pose)
}

/// Medians of two things that are timed in turns, s.
fn medians(mut turns: [&mut dyn FnMut(); 2]) -> [f64; 2] {
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        for (turn, times) in turns.iter_mut().zip(&mut times) {
            let start = Instant::now();
            turn();
            times.push(start.elapsed().as_secs_f64());
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[TURNS / 2]
    })
}

/// The engine knows no effect: what it takes alone is what a projector without them would.
fn off(context: &Context, projector: &Projector, views: &[ViewRequest]) {
    let (volume, scene) = (projector.volume(), projector.scene());
    let engine = context.install(|| Cpu::new(volume.clone(), scene, projector.plan())).expect("memory");
    let job = |view: &ViewRequest| ViewJob {
        beam: Beam::new(&view.view, volume.grid(), SIZE).expect("valid"),
        early_exit: false,
        spectral: None,
        lut_addresses: [0, 0],
    };
    let jobs: Vec<_> = views.iter().map(job).collect();
    let [with, without] =
        medians([&mut || drop(projector.project(views, ONLY, SILENT).expect("projects")), &mut || {
            let job = Job { views: &jobs, layers: ONLY, progress: Progress::new(SILENT) };
            drop(context.install(|| engine.project(&job)).expect("projects"));
        }]);
    println!(
        "effects there but off: {with:.3} s; the engine alone: {without:.3} s; ratio {:.3}",
        with / without
    );
}

fn second_spectrum(projector: &Projector, views: &[ViewRequest]) {
    let exposure = projector.expose(views, SILENT).expect("exposes");
    let softer = Spectrum::named("W80_2p5Al", *projector.scene().spectrum.grid()).expect("built in");
    let softer = Scene { spectrum: softer, ..projector.scene().clone() };
    let noisy = Effects {
        detector_blur: Some(DetectorBlur::gaussians(&[(1.0, 0.3)]).expect("valid")),
        noise: Some(Noise { photons_per_pixel: 1e4, quantum: true, electronic_photons: 0.0, seed: 0 }),
        ..Effects::default()
    };
    let noisy = Scene { effects: noisy, ..softer.clone() };
    for (name, scene) in [("spectrum", softer), ("spectrum with blur and noise", noisy)] {
        let [first, second] =
            medians([&mut || drop(projector.project(views, ONLY, SILENT).expect("projects")), &mut || {
                drop(exposure.develop(&scene, ONLY).expect("develops"));
            }]);
        println!(
            "a second {name}: {second:.3} s; the first projection: {first:.3} s; part {:.3}",
            second / first
        );
    }
}

fn effects(criterion: &mut Criterion) {
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let volume = thorax();
    let views = pair(&volume);
    let scene = Scene { expected_views: views.into(), ..Scene::new(SIZE).expect("valid") };
    let projector = Projector::new(&context, volume, scene).expect("valid");
    let views = views.map(ViewRequest::from);
    off(&context, &projector, &views);
    second_spectrum(&projector, &views);
    let exposure = projector.expose(&views, SILENT).expect("exposes");
    let mut group = criterion.benchmark_group("effects, 256×256×240 voxels, two views");
    group.sample_size(10);
    group.bench_function("projection", |b| {
        b.iter(|| projector.project(&views, ONLY, SILENT).expect("projects"));
    });
    group.bench_function("second spectrum", |b| {
        b.iter(|| exposure.develop(projector.scene(), ONLY).expect("develops"));
    });
    group.finish();
}

criterion_group!(benches, effects);
criterion_main!(benches);
