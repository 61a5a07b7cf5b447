//! Where rays meet anything, on the target case: 720×720×665 int16 voxels of 0.5 mm and views of 720×720 pixels. Beside it,
//! in the same run, the floor: one streaming read of the voxels. Ratios to it carry over to other machines; seconds do not.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::{Criterion, criterion_group, criterion_main};
use drr::Context;
use drr::engine::Backend;
use drr::geometry::{DetectorPose, Grid, View};
use drr::phantom::Phantom;
use drr::physics::{Calibration, Thresholds};
use drr::raycast::{RayCache, RaySpan, ViewSpans};
use drr::volume::{Classification, Matter, Volume, VolumeBuilder, Voxels};
use rayon::prelude::*;

const DIMENSIONS: [usize; 3] = [720, 720, 665];
const SIZE: [usize; 2] = [720, 720];

/// The thorax phantom with noise, also in the air around it.
fn thorax(context: &Context) -> (Grid, Volume) {
    let phantom = Phantom::thorax().with_noise(true);
    let grid = phantom.grid(DIMENSIONS).expect("valid");
    let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
    let mut builder = VolumeBuilder::int16(grid, &how, false).expect("memory");
    context
        .install(|| phantom.voxelise(&grid, |_, hu, _| builder.push_int16(hu, None)))
        .expect("axis-aligned");
    (grid, builder.finish().expect("complete"))
}

/// Part of the rays' length in the volume that is skipped.
fn skipped(view: &ViewSpans) -> f64 {
    let sum = |part: fn(&RaySpan) -> f64| view.spans().iter().map(part).sum::<f64>();
    let skipped = sum(|span| span.skipped_mm);
    skipped / (skipped + sum(RaySpan::length_mm))
}

fn raycast(criterion: &mut Criterion) {
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let (grid, volume) = thorax(&context);
    let mut group = criterion.benchmark_group("raycast");
    group.sample_size(10);

    let Voxels::Coded { codes, .. } = volume.voxels() else { unreachable!("HU are integers") };
    group.bench_function("floor: one read of the voxels", |bencher| {
        let sum = |piece: &[u16]| piece.iter().fold(0_u64, |sum, &code| sum + u64::from(code));
        bencher.iter(|| black_box(context.install(|| codes.par_chunks(1 << 16).map(sum).sum::<u64>())));
    });
    drop(volume);
    let mut last = None;
    group.bench_function("occupancy, made once for a volume", |bencher| {
        bencher.iter_custom(|count| {
            (0..count).fold(Duration::ZERO, |total, _| {
                drop(last.take());
                let (_, volume) = thorax(&context);
                let start = Instant::now();
                black_box(context.install(|| volume.occupancy().expect("on the host").bytes()));
                let total = total + start.elapsed();
                last = Some(volume);
                total
            })
        });
    });

    let volume = Arc::new(last.unwrap_or_else(|| thorax(&context).1));
    let pair = DetectorPose::stereo_pair(&grid, 1000.0, 1500.0, 0.9, SIZE).map(View::Pose);
    for (name, labels, floor) in [("all matter", 255, 0.0), ("above 0.02 g/cm³", 255, 0.02), ("bone", 8, 0.0)]
    {
        let matter = Matter::new(labels, floor).expect("valid");
        let mut cache = RayCache::new(&context, volume.clone());
        let part = skipped(cache.update(&pair[0], SIZE, matter).expect("valid"));
        println!("{name}: {:.1} % of the length is skipped", 100.0 * part);
        let mut view = 0;
        group.bench_function(format!("a view's spans, {name}"), |bencher| {
            bencher.iter(|| {
                view = 1 - view;
                black_box(cache.update(&pair[view], SIZE, matter).expect("valid").hits());
            });
        });
    }
    group.finish();
}

criterion_group!(benches, raycast);
criterion_main!(benches);
