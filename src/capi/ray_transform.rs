//! Line integrals of a scalar volume and their adjoint, in float32.

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::ray_transform_calls::{self, Rays};
use crate::capi::scene::DrrAlgorithm;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolumeDescriptor;
use crate::ray_transform::RayTransform;

/// The matrix A whose row for a pixel holds the lengths, mm, with which voxels count along the ray to it, in float32: A
/// x are the line integrals of a volume x, and A^T b is the back-projection of images b, which is the transpose for
/// every algorithm. The matrix is never stored. Immutable: any number of threads may use one at once. Keeps its context
/// alive.
///
/// Voxel (i, j, k) is at (k × dimensions[1] + j) × dimensions[0] + i, in any unit, for instance attenuation per mm.
/// Pixel (i, j), i = column, of view v is at (v × height + j) × width + i.
pub struct DrrRayTransform {
    _opaque: [u8; 0],
}

impl Opaque for DrrRayTransform {
    type Value = RayTransform<f32>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr ray4");
    const NAME: &'static str = "DrrRayTransform";
}

/// Plans the rays from the sources of `view_count` `poses`, 1 to DRR_MAX_VIEWS, to the pixels of a detector of `width`
/// × `height` pixels, each 1 to 32768, through the voxels of `descriptor`.
///
/// `step_voxels` is for DRR_ALGORITHM_MARCH as in DrrScene, and not read for other algorithms. The descriptor's
/// calibration and thresholds are checked, and otherwise not read. Descriptor and poses are only read during the call.
///
/// On success `*transform` is a new handle, to be given to drr_ray_transform_destroy; on failure `*transform` is left
/// as it is. Fails with DRR_STATUS_INVALID_ARGUMENT or DRR_STATUS_OUT_OF_MEMORY. Any thread; nobody may write to the
/// inputs during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_create(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    poses: *const DrrDetectorPose,
    view_count: usize,
    width: usize,
    height: usize,
    algorithm: DrrAlgorithm,
    step_voxels: f64,
    transform: *mut *mut DrrRayTransform,
) -> DrrStatus {
    let size = [width, height];
    let rays = Rays { descriptor, poses, view_count, size, algorithm, step_voxels };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::create(context, &rays, transform) })
}

/// Gives a transform up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_destroy(transform: *mut DrrRayTransform) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("transform", transform) })
}

/// A x: the line integrals of `volume`, one finite value per voxel, in all views; mm times the volume's unit. `images`
/// has one value per pixel of every view.
///
/// `volume` is only read during the call; `images` is written on success only. Fails with DRR_STATUS_INVALID_ARGUMENT
/// or DRR_STATUS_OUT_OF_MEMORY. Any thread, also with one transform from many at once. The same call gives the same
/// bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_forward(
    transform: *const DrrRayTransform,
    volume: *const f32,
    images: *mut f32,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::forward(transform, volume, images) })
}

/// A^T b: the back-projection of `images`, one finite value per pixel of all views. The scalar product of A x with b is
/// that of x with A^T b, but for rounding.
///
/// Otherwise as drr_ray_transform_forward, the other way.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_adjoint(
    transform: *const DrrRayTransform,
    images: *const f32,
    volume: *mut f32,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::adjoint(transform, images, volume) })
}
