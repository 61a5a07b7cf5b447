//! Line integrals of a scalar volume and their adjoint, in float64: the twin of those in float32.

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::ray_transform_calls::{self, Rays};
use crate::capi::scene::DrrAlgorithm;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolumeDescriptor;
use crate::ray_transform::RayTransform;

/// As DrrRayTransform, in float64. A handle of the other type is refused.
pub struct DrrRayTransformF64 {
    _opaque: [u8; 0],
}

impl Opaque for DrrRayTransformF64 {
    type Value = RayTransform<f64>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr ray8");
    const NAME: &'static str = "DrrRayTransformF64";
}

/// As drr_ray_transform_create, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_create_f64(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    poses: *const DrrDetectorPose,
    view_count: usize,
    width: usize,
    height: usize,
    algorithm: DrrAlgorithm,
    step_voxels: f64,
    transform: *mut *mut DrrRayTransformF64,
) -> DrrStatus {
    let size = [width, height];
    let rays = Rays { descriptor, poses, view_count, size, algorithm, step_voxels };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::create(context, &rays, transform) })
}

/// As drr_ray_transform_destroy, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_destroy_f64(transform: *mut DrrRayTransformF64) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("transform", transform) })
}

/// As drr_ray_transform_forward, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_forward_f64(
    transform: *const DrrRayTransformF64,
    volume: *const f64,
    images: *mut f64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::forward(transform, volume, images) })
}

/// As drr_ray_transform_adjoint, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_ray_transform_adjoint_f64(
    transform: *const DrrRayTransformF64,
    images: *const f64,
    volume: *mut f64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { ray_transform_calls::adjoint(transform, images, volume) })
}
