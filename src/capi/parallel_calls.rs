//! What the functions of both widths of a parallel projector do.

use crate::allocation::reserved;
use crate::capi::context::DrrContext;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::outputs::check_views;
use crate::capi::parallel_geometry::DrrParallelGeometry;
use crate::capi::{memory, motion, options};
use crate::error::{Error, Result};
use crate::parallel::{ParallelProjector, RaySelection, ViewParameters};
use crate::real::Real;

/// The five parameters of `count` views, which are valid.
///
/// # Safety
/// As for [`memory::read_array`], of five values per view.
unsafe fn views(parameters: *const f64, count: usize) -> Result<Vec<ViewParameters>> {
    // SAFETY: the caller's promise is the same.
    let values = unsafe { memory::read_array("parameters", parameters, count * ViewParameters::COUNT)? };
    let mut views = reserved(count, "the views")?;
    for (v, values) in values.as_chunks().0.iter().enumerate() {
        let view = ViewParameters::from_array(*values);
        let first = v * ViewParameters::COUNT;
        let translation = format!("[{}] and [{}], (dx, 0, dz)", first + 3, first + 4);
        view.validate().map_err(|error| motion::in_array(error, first, &translation))?;
        views.push(view);
    }
    Ok(views)
}

/// Which rays count.
struct Rays<'a> {
    mask: Option<Vec<bool>>,
    lengths: Option<&'a [[f64; 2]]>,
}

impl Rays<'_> {
    /// # Safety
    /// `mask` is null or `pixels` bytes, `lengths` null, misaligned or twice as many numbers; nobody writes there during
    /// the value's life.
    unsafe fn read(mask: *const u8, lengths: *const f64, pixels: usize) -> Result<Self> {
        // SAFETY: the caller's promise is the same; a pair of numbers is aligned as one.
        unsafe {
            let lengths = memory::read_optional("lengths", lengths.cast::<[f64; 2]>(), pixels)?;
            Ok(Self { mask: memory::read_mask(mask, pixels)?, lengths })
        }
    }

    fn selection(&self) -> RaySelection<'_> {
        RaySelection { mask: self.mask.as_deref(), lengths: self.lengths }
    }
}

/// The same error, of lengths that C has two of per pixel.
fn of_rays(error: Error) -> Error {
    error.called("lengths[", "lengths of pixel [")
}

/// # Safety
/// The pointers are as `drr_parallel_create` says.
pub(super) unsafe fn create<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    context: *const DrrContext,
    geometry: *const DrrParallelGeometry,
    volume: *const T,
    parallel: *mut *mut O,
) -> Result<()> {
    memory::check("parallel", parallel, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let context = unsafe { handle::borrow("context", context)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let (geometry, quadrature) = unsafe { options::read("geometry", geometry)? }.read()?;
    let voxels = geometry.dimensions.iter().product();
    // SAFETY: the C caller passes one value per voxel.
    let volume = unsafe { memory::read_array("volume", volume, voxels)? };
    let made = ParallelProjector::new(&context, geometry, quadrature, volume)?;
    // SAFETY: `parallel` is not null and aligned; the C caller passes a place for one handle.
    unsafe { parallel.write(handle::create(made)) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_parallel_forward_project_view` says.
pub(super) unsafe fn forward_project_view<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    parallel: *const O,
    parameters: *const f64,
    (mask, lengths): (*const u8, *const f64),
    image: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("parallel", parallel)? };
    let pixels = projector.geometry().pixels();
    memory::check("image", image, pixels)?;
    // SAFETY: the C caller passes five parameters, and one value per pixel or null.
    let (views, rays) = unsafe { (views(parameters, 1)?, Rays::read(mask, lengths, pixels)?) };
    let made = projector.forward_project_view(&views[0], rays.selection()).map_err(of_rays)?;
    // SAFETY: checked above; the C caller passes a place for one image.
    unsafe { memory::write_array(image, &made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_parallel_batch_forward_project` says.
pub(super) unsafe fn batch_forward_project<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    parallel: *const O,
    parameters: *const f64,
    view_count: usize,
    images: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("parallel", parallel)? };
    check_views(view_count)?;
    memory::check("images", images, projector.geometry().pixels() * view_count)?;
    // SAFETY: the C caller passes five parameters per view.
    let views = unsafe { views(parameters, view_count)? };
    let made = projector.batch_forward_project(&views)?;
    // SAFETY: checked above; the C caller passes a place for the images of all views.
    unsafe { memory::write_array(images, &made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_parallel_adjoint` says.
pub(super) unsafe fn adjoint<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    parallel: *const O,
    parameters: *const f64,
    (images, view_count): (*const T, usize),
    volume: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("parallel", parallel)? };
    check_views(view_count)?;
    memory::check("volume", volume, projector.geometry().dimensions.iter().product())?;
    // SAFETY: the C caller passes five parameters and an image per view.
    let (views, images) = unsafe {
        let pixels = projector.geometry().pixels() * view_count;
        (views(parameters, view_count)?, memory::read_array("images", images, pixels)?)
    };
    let made = projector.adjoint(&views, images)?;
    // SAFETY: checked above; the C caller passes a place for one volume.
    unsafe { memory::write_array(volume, &made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_parallel_view_loss_value_and_grad` says.
pub(super) unsafe fn view_loss_value_and_grad<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    parallel: *const O,
    parameters: *const f64,
    measured: *const T,
    (mask, lengths): (*const u8, *const f64),
    places: LossPlaces,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("parallel", parallel)? };
    let pixels = projector.geometry().pixels();
    places.check(ViewParameters::COUNT)?;
    // SAFETY: the C caller passes five parameters, an image, and one value per pixel or null.
    let (views, measured, rays) = unsafe {
        (
            views(parameters, 1)?,
            memory::read_array("measured", measured, pixels)?,
            Rays::read(mask, lengths, pixels)?,
        )
    };
    let made = projector.view_loss_value_and_grad(&views[0], measured, rays.selection()).map_err(of_rays)?;
    // SAFETY: checked above; the C caller passes places for 1, 5 and 25 numbers.
    unsafe { places.write(&made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_parallel_view_jacobian` says.
pub(super) unsafe fn view_jacobian<T: Real, O: Opaque<Value = ParallelProjector<T>>>(
    parallel: *const O,
    parameters: *const f64,
    (mask, lengths): (*const u8, *const f64),
    (image, jacobian): (*mut T, *mut T),
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("parallel", parallel)? };
    let pixels = projector.geometry().pixels();
    memory::check_optional("image", image, pixels)?;
    memory::check("jacobian", jacobian, pixels * ViewParameters::COUNT)?;
    // SAFETY: the C caller passes five parameters, and one value per pixel or null.
    let (views, rays) = unsafe { (views(parameters, 1)?, Rays::read(mask, lengths, pixels)?) };
    let made = projector.view_jacobian(&views[0], rays.selection()).map_err(of_rays)?;
    // SAFETY: checked above; the C caller passes places for an image, or null, and for five planes.
    unsafe {
        memory::write_array(image, &made.image);
        memory::write_planes(jacobian, &made.derivatives);
    }
    Ok(())
}
