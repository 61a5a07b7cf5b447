//! The differentiable projector of a parallel beam, in float32.

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::parallel_calls;
use crate::capi::parallel_geometry::DrrParallelGeometry;
use crate::capi::status::DrrStatus;
use crate::parallel::ParallelProjector;

/// One volume before a parallel beam, in float32: images of it as it moves rigidly, and their derivatives. Immutable:
/// any number of threads may use one at once. Keeps its context alive.
///
/// A view has five parameters: alpha, beta, phi, rotations about x, y (the beam) and z, RADIANS, up to 100,
/// right-handed; dx, dz, translations, mm, up to 1e10. The point q of the volume is then at R q + (dx, 0, dz) with R =
/// R_y(beta) R_x(alpha) R_z(phi), about the world's origin. A motion along the beam would change nothing.
pub struct DrrParallel {
    _opaque: [u8; 0],
}

impl Opaque for DrrParallel {
    type Value = ParallelProjector<f32>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr par4");
    const NAME: &'static str = "DrrParallel";
}

/// Makes a projector of `volume`: one value per voxel, finite, for instance attenuation per mm. It is copied.
///
/// Geometry and volume are only read during the call. On success `*parallel` is a new handle, to be given to
/// drr_parallel_destroy; on failure `*parallel` is left as it is. Fails with DRR_STATUS_INVALID_ARGUMENT,
/// DRR_STATUS_OUT_OF_MEMORY, or what the context's engine adds to that. Any thread; nobody may write to the inputs
/// during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_create(
    context: *const DrrContext,
    geometry: *const DrrParallelGeometry,
    volume: *const f32,
    parallel: *mut *mut DrrParallel,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::create(context, geometry, volume, parallel) })
}

/// Gives a projector up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_destroy(parallel: *mut DrrParallel) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("parallel", parallel) })
}

/// The `image` of one view, one value per pixel: line integrals, mm times the volume's unit. Pixel (u, v), u = column,
/// is at v × detector_columns + u, as in everything that has one value per pixel.
///
/// `parameters` are 5: alpha, beta, phi (radians), dx, dz (mm). `mask` is one byte per pixel, 0 for rays that do not
/// count: their pixels are 0; NULL for all; at least one must count. `lengths` are two numbers per pixel, mm: of pixel
/// p the part of the ray from y = lengths[2 × p] to y = lengths[2 × p + 1] counts, of the step at either end the part
/// inside; NULL for all of the ray.
///
/// Inputs are only read during the call; `image` is written on success only. Fails with DRR_STATUS_INVALID_ARGUMENT,
/// DRR_STATUS_OUT_OF_MEMORY, or DRR_STATUS_DEVICE when a GPU fails. Any thread, also with one projector from many at
/// once. The same call gives the same bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_forward_project_view(
    parallel: *const DrrParallel,
    parameters: *const f64,
    mask: *const u8,
    lengths: *const f64,
    image: *mut f32,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::forward_project_view(parallel, parameters, (mask, lengths), image) })
}

/// The `images` of `view_count` views, 1 to DRR_MAX_VIEWS: parameter n of view i is parameters[5 × i + n], and pixel
/// (u, v) of its image is at (i × detector_rows + v) × detector_columns + u.
///
/// Otherwise as drr_parallel_forward_project_view of every ray.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_batch_forward_project(
    parallel: *const DrrParallel,
    parameters: *const f64,
    view_count: usize,
    images: *mut f32,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::batch_forward_project(parallel, parameters, view_count, images) })
}

/// The transpose of drr_parallel_batch_forward_project, A: the volume A^T b of `images` b, one finite value per pixel
/// of every view, for which the scalar product of A x with b is that of x with A^T b for every volume x. In the images'
/// unit, times mm; what volume the handle was made of does not matter. `volume` is a place for one value per voxel.
///
/// Otherwise as drr_parallel_batch_forward_project; computed on the context's CPU threads, whatever its engine.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_adjoint(
    parallel: *const DrrParallel,
    parameters: *const f64,
    view_count: usize,
    images: *const f32,
    volume: *mut f32,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::adjoint(parallel, parameters, (images, view_count), volume) })
}

/// What a step of Gauss and Newton needs, in one pass: with r = image - measured over the rays that count, and J = its
/// derivatives with respect to the five parameters, `*loss` is the sum of r^2, halved; gradient[n] the derivative of
/// the loss with respect to parameter n, which is the n-th entry of J^T r; hessian[5 × m + n] that of J^T J. Per
/// radian, per mm.
///
/// `measured` is an image, finite where rays count, and not read elsewhere. `loss` is a place for 1 number, `gradient`
/// for 5, `hessian` for 25, or NULL.
///
/// Otherwise as drr_parallel_forward_project_view.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_view_loss_value_and_grad(
    parallel: *const DrrParallel,
    parameters: *const f64,
    measured: *const f32,
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

/// The image of one view and its derivatives with respect to the five parameters, per radian and per mm. `jacobian` has
/// 5 values per pixel: that of pixel (u, v) with respect to parameter n is at (n × detector_rows + v) ×
/// detector_columns + u. `image` may be NULL.
///
/// Otherwise as drr_parallel_forward_project_view.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_view_jacobian(
    parallel: *const DrrParallel,
    parameters: *const f64,
    mask: *const u8,
    lengths: *const f64,
    image: *mut f32,
    jacobian: *mut f32,
) -> DrrStatus {
    let (rays, places) = ((mask, lengths), (image, jacobian));
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { parallel_calls::view_jacobian(parallel, parameters, rays, places) })
}
