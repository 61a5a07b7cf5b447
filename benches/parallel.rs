//! The parallel projector on the CPU: 256³ float32 voxels of 1.4 mm, 256×256 pixels, 256 steps, tilted a little.
//! Beside it, in the same run, the floor: one streaming read of the voxels. Ratios to it carry over to other
//! machines; seconds do not. Zeros, waves and noise take the same time within 5 %; subnormal voxels took 20 times as
//! long.
//!
//! To compare with JAX: the document's scan over steps with a checkpointed step,
//! `jax.jit(jax.value_and_grad(loss))`, this geometry and pose, on the same cores in the same quarter of an hour,
//! this before it and after. Once, with voxels other than these, on two cores at a load of 19 (JAX 0.10.2), medians:
//! forward 117 to 133 ms against 420, value and gradient 164 to 189 ms against 2313.
#![allow(missing_docs, reason = "criterion makes public functions")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use drr::Context;
use drr::engine::Backend;
use drr::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters};
use glam::DVec3;
use rayon::prelude::*;

const SIDE: usize = 256;
const SPACING: f64 = 1.4;

/// Where the object is measured, and where it is taken to be.
const MEASURED: ViewParameters =
    ViewParameters { alpha: 0.020, beta: -0.015, phi: 0.030, dx: 1.50, dz: -2.25 };
const ASSUMED: ViewParameters = ViewParameters { alpha: 0.005, beta: 0.004, phi: -0.006, dx: 0.30, dz: 0.70 };

/// A ball of water with waves in it, 1/mm.
fn volume() -> Vec<f32> {
    let value = |n: usize| {
        let [x, y, z] = [n % SIDE, n / SIDE % SIDE, n / (SIDE * SIDE)].map(|i| i as f32 / 127.5 - 1.0);
        let inside = x * x + y * y + z * z < 0.9;
        if inside { 0.02 + 0.004 * (9.0 * x).sin() * (7.0 * y).cos() * (11.0 * z).sin() } else { 0.0 }
    };
    (0..SIDE * SIDE * SIDE).into_par_iter().map(value).collect()
}

fn parallel(criterion: &mut Criterion) {
    let voxels = volume();
    let context = Context::new(Backend::Cpu, 0).expect("threads start");
    let geometry = ParallelGeometry::new([SIDE; 3], DVec3::splat(SPACING), [SIDE; 2], [SPACING; 2]);
    let projector = ParallelProjector::new(&context, geometry, Quadrature::Steps, &voxels).expect("valid");
    let rays = RaySelection::default();
    let measured = projector.forward_project_view(&MEASURED, rays).expect("projects");

    let mut group = criterion.benchmark_group("parallel");
    group.bench_function("floor: one read of the voxels", |bencher| {
        let sum = |piece: &[f32]| piece.iter().fold(0_u32, |sum, value| sum ^ value.to_bits());
        let read = || voxels.par_chunks(1 << 16).map(sum).reduce(|| 0, |a, b| a ^ b);
        bencher.iter(|| black_box(context.install(read)));
    });
    group.bench_function("forward", |bencher| {
        bencher.iter(|| projector.forward_project_view(&ASSUMED, rays).expect("projects"));
    });
    group.bench_function("value, gradient and JᵀJ", |bencher| {
        bencher.iter(|| projector.view_loss_value_and_grad(&ASSUMED, &measured, rays).expect("projects"));
    });
    for degrees in [45.0_f64, 90.0] {
        let view = ViewParameters { phi: degrees.to_radians(), ..ASSUMED };
        group.bench_function(format!("forward, φ = {degrees}°"), |bencher| {
            bencher.iter(|| projector.forward_project_view(&view, rays).expect("projects"));
        });
    }
    group.sample_size(10);
    group.bench_function("adjoint", |bencher| {
        bencher.iter(|| projector.adjoint(&[ASSUMED], &measured).expect("projects"));
    });
    group.bench_function("forward, eight views", |bencher| {
        bencher.iter(|| projector.batch_forward_project(&[ASSUMED; 8]).expect("projects"));
    });
    group.finish();
}

criterion_group!(benches, parallel);
criterion_main!(benches);
