//! The differentiable projector of a parallel beam, in float64: the twin of the one in float32.

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::parallel_calls;
use crate::capi::parallel_geometry::DrrParallelGeometry;
use crate::capi::status::DrrStatus;
use crate::parallel::ParallelProjector;

/// As DrrParallel, in float64. The two are different types, so that a program that mixes them is not compiled; a handle
/// that is cast is refused.
pub struct DrrParallelF64 {
    _opaque: [u8; 0],
}

impl Opaque for DrrParallelF64 {
    type Value = ParallelProjector<f64>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr par8");
    const NAME: &'static str = "DrrParallelF64";
}

/// As drr_parallel_create, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_create_f64(
    context: *const DrrContext,
    geometry: *const DrrParallelGeometry,
    volume: *const f64,
    parallel: *mut *mut DrrParallelF64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::create(context, geometry, volume, parallel) })
}

/// As drr_parallel_destroy, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_destroy_f64(parallel: *mut DrrParallelF64) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("parallel", parallel) })
}

/// As drr_parallel_forward_project_view, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_forward_project_view_f64(
    parallel: *const DrrParallelF64,
    parameters: *const f64,
    mask: *const u8,
    lengths: *const f64,
    image: *mut f64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::forward_project_view(parallel, parameters, (mask, lengths), image) })
}

/// As drr_parallel_batch_forward_project, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_batch_forward_project_f64(
    parallel: *const DrrParallelF64,
    parameters: *const f64,
    view_count: usize,
    images: *mut f64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::batch_forward_project(parallel, parameters, view_count, images) })
}

/// As drr_parallel_adjoint, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_adjoint_f64(
    parallel: *const DrrParallelF64,
    parameters: *const f64,
    view_count: usize,
    images: *const f64,
    volume: *mut f64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::adjoint(parallel, parameters, (images, view_count), volume) })
}

/// As drr_parallel_view_loss_value_and_grad, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_view_loss_value_and_grad_f64(
    parallel: *const DrrParallelF64,
    parameters: *const f64,
    measured: *const f64,
    mask: *const u8,
    lengths: *const f64,
    loss: *mut f64,
    gradient: *mut f64,
    hessian: *mut f64,
) -> DrrStatus {
    let (rays, places) = ((mask, lengths), LossPlaces { loss, gradient, hessian });
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe {
        parallel_calls::view_loss_value_and_grad(parallel, parameters, measured, rays, places)
    })
}

/// As drr_parallel_view_jacobian, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_view_jacobian_f64(
    parallel: *const DrrParallelF64,
    parameters: *const f64,
    mask: *const u8,
    lengths: *const f64,
    image: *mut f64,
    jacobian: *mut f64,
) -> DrrStatus {
    let (rays, places) = ((mask, lengths), (image, jacobian));
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::view_jacobian(parallel, parameters, rays, places) })
}
