//! What the functions of both widths of a ray transform do.

use crate::allocation::reserved;
use crate::capi::context::DrrContext;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::outputs::check_views;
use crate::capi::scene::{DrrAlgorithm, algorithm};
use crate::capi::volume::DrrVolumeDescriptor;
use crate::capi::{memory, options};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::linear_operator::LinearOperator;
use crate::ray_transform::RayTransform;
use crate::real::Real;

/// What a transform is made for.
pub(super) struct Rays {
    pub(super) descriptor: *const DrrVolumeDescriptor,
    pub(super) poses: *const DrrDetectorPose,
    pub(super) view_count: usize,
    /// Width and height.
    pub(super) size: [usize; 2],
    pub(super) algorithm: DrrAlgorithm,
    pub(super) step_voxels: f64,
}

/// # Safety
/// The pointers are as `drr_ray_transform_create` says.
pub(super) unsafe fn create<T: Real, O: Opaque<Value = RayTransform<T>>>(
    context: *const DrrContext,
    rays: &Rays,
    transform: *mut *mut O,
) -> Result<()> {
    memory::check("transform", transform, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let context = unsafe { handle::borrow("context", context)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let descriptor = unsafe { options::read("descriptor", rays.descriptor)? };
    let grid = descriptor.grid()?;
    descriptor.classification()?;
    check_views(rays.view_count)?;
    // SAFETY: the C caller passes as many poses.
    let poses = unsafe { memory::read_array("poses", rays.poses, rays.view_count)? };
    let algorithm = algorithm(rays.algorithm, rays.step_voxels)?;
    let mut views = reserved(poses.len(), "the views")?;
    views.extend(poses.iter().map(|pose| View::Pose(pose.into())));
    let made = RayTransform::new(&context, grid, &views, rays.size, algorithm).map_err(in_c)?;
    // SAFETY: `transform` is not null and aligned; the C caller passes a place for one handle.
    unsafe { transform.write(handle::create(made)) };
    Ok(())
}

/// The same error to a caller in C.
fn in_c(error: Error) -> Error {
    let names =
        [("views", "poses"), ("size[0]", "width"), ("size[1]", "height"), ("algorithm.step", "step_voxels")];
    names.into_iter().fold(error, |error, (from, to)| error.called(from, to))
}

/// # Safety
/// The pointers are as `drr_ray_transform_forward` says.
pub(super) unsafe fn forward<T: Real, O: Opaque<Value = RayTransform<T>>>(
    transform: *const O,
    volume: *const T,
    images: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let transform = unsafe { handle::borrow("transform", transform)? };
    memory::check("images", images, transform.range())?;
    // SAFETY: the C caller passes one value per voxel.
    let volume = unsafe { memory::read_array("volume", volume, transform.domain())? };
    let made = transform.forward(volume)?;
    // SAFETY: checked above; the C caller passes a place for the images of all views.
    unsafe { memory::write_array(images, &made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_ray_transform_adjoint` says.
pub(super) unsafe fn adjoint<T: Real, O: Opaque<Value = RayTransform<T>>>(
    transform: *const O,
    images: *const T,
    volume: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let transform = unsafe { handle::borrow("transform", transform)? };
    memory::check("volume", volume, transform.domain())?;
    // SAFETY: the C caller passes the images of all views.
    let images = unsafe { memory::read_array("images", images, transform.range())? };
    let made = transform.adjoint(images)?;
    // SAFETY: checked above; the C caller passes a place for one volume.
    unsafe { memory::write_array(volume, &made) };
    Ok(())
}
