//! What a parallel projector asks for beside its volume, in bytes that its calls hold at once.
#![allow(missing_docs, reason = "a test program")]
#![allow(unsafe_code, reason = "an allocator that counts")]

#[path = "support/held.rs"]
mod held;

use drr::Context;
use drr::engine::Backend;
use drr::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters};
use glam::DVec3;
use held::held;

/// Bytes beside the result of images, of values and gradients, of the adjoint, for cubes of this side.
fn measure(side: usize) -> [usize; 3] {
    let context = Context::new(Backend::Cpu, 2).expect("threads start");
    let geometry = ParallelGeometry::new([side; 3], DVec3::ONE, [side; 2], [1.0; 2]);
    let volume: Vec<f32> = (0..side.pow(3)).map(|n| (n % 17) as f32).collect();
    let projector = ParallelProjector::new(&context, geometry, Quadrature::Steps, &volume).expect("valid");
    let view = ViewParameters { alpha: 0.02, beta: -0.01, phi: 0.4, dx: 1.5, dz: -2.0 };
    let rays = RaySelection::default();
    let (measured, image) = held(|| projector.forward_project_view(&view, rays).expect("valid"));
    let home = ViewParameters::default();
    let (_, loss) = held(|| projector.view_loss_value_and_grad(&home, &measured, rays).expect("valid"));
    let (back, adjoint) = held(|| projector.adjoint(&[view], &measured).expect("valid"));
    [image - 4 * measured.len(), loss, adjoint - 4 * back.len()]
}

#[test]
fn calls_hold_little_beside_volume_and_image() {
    // The document's bound is 16 MB at 256³, 256² and 256 steps. Images and losses need memory by the pixel or the
    // column, whatever the number of voxels and steps; the adjoint a few slabs of the volume.
    let [small, large] = [64, 256].map(measure);
    // Measured at 256 with 2 threads: 306 KB beside the image, 109 KB for value and gradient, 8.5 MB beside the volume.
    assert!(large[0] < 1 << 20 && large[1] < 400 << 10 && large[2] < 16_000_000, "{small:?} {large:?}");
    assert!(large[1] < 8 * small[1], "{small:?} {large:?}");
}
