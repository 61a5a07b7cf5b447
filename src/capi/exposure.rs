//! Exposures: rays that are cast once and developed many times.

use std::ffi::c_void;

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::lut::Tables;
use crate::capi::outputs::{DrrOutputs, DrrProgress, Places, check_views};
use crate::capi::progress::Monitor;
use crate::capi::projector::{DrrProjector, ProjectorValue, requests, uniforms_request};
use crate::capi::scene::DrrScene;
use crate::capi::status::DrrStatus;
use crate::capi::{memory, names, options};
use crate::error::Result;
use crate::exposure::Exposure;
use crate::geometry::View;
use crate::projector::ViewRequest;
use crate::scene::Scene;
use crate::shared::ProjectionUniforms;

/// What the rays of some views met: the areal density of every material, and where the scene has bone its path, for
/// each ray. Immutable: any number of threads may develop one at once. Keeps its context alive, and needs neither its
/// projector nor its volume.
pub struct DrrExposure {
    _opaque: [u8; 0],
}

/// What an exposure's handle owns.
pub(super) struct ExposureValue {
    exposure: Exposure<f32>,
    scene: Scene,
}

impl Opaque for DrrExposure {
    type Value = ExposureValue;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr expo");
    const NAME: &'static str = "DrrExposure";
}

/// Casts the rays of the `view_count` `views`, 1 to DRR_MAX_VIEWS, given by projection matrices, and keeps what they
/// met: 4 bytes per ray and material, and 4 per ray for bone. drr_exposure_develop makes images of it, without another
/// march.
///
/// `views` are only read during the call, and must be without LUT addresses; enableEarlyExit does not matter. A scene
/// with a focal spot needs views given by poses. `progress` hears how far the call is, and may cancel it, as that of
/// DrrOutputs; NULL for silence. `progress_data` is handed to it.
///
/// On success `*exposure` is a new handle, to be given to drr_exposure_destroy; on failure `*exposure` is left as it
/// is. Fails with DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_OUT_OF_MEMORY, DRR_STATUS_DEVICE when a GPU fails, or
/// DRR_STATUS_CANCELLED. Any thread, also with one projector from many at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_exposure_create(
    projector: *const DrrProjector,
    views: *const ProjectionUniforms,
    view_count: usize,
    progress: DrrProgress,
    progress_data: *mut c_void,
    exposure: *mut *mut DrrExposure,
) -> DrrStatus {
    let mut tables = Tables::default();
    // SAFETY: a view's tables are the C caller's, as described, and stay as they are during the call.
    let request = |value: &ProjectorValue, view: &ProjectionUniforms| unsafe {
        uniforms_request(&mut tables, value, view)
    };
    // SAFETY: the C caller passes a function that may be called until this call returns.
    let monitor = |rays| unsafe { Monitor::new(progress, progress_data, rays) };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { create(projector, ("views", views, view_count), request, monitor, exposure) })
}

/// Casts the rays of `view_count` views given by `poses` in float64, one per view, as for drr_projector_project_poses.
///
/// Otherwise as drr_exposure_create.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_exposure_create_poses(
    projector: *const DrrProjector,
    poses: *const DrrDetectorPose,
    view_count: usize,
    progress: DrrProgress,
    progress_data: *mut c_void,
    exposure: *mut *mut DrrExposure,
) -> DrrStatus {
    let request = |_: &ProjectorValue, pose: &DrrDetectorPose| Ok(View::Pose(pose.into()).into());
    // SAFETY: the C caller passes a function that may be called until this call returns.
    let monitor = |rays| unsafe { Monitor::new(progress, progress_data, rays) };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { create(projector, ("poses", poses, view_count), request, monitor, exposure) })
}

/// # Safety The pointers are as [`drr_exposure_create`] says.
unsafe fn create<V: Copy>(
    projector: *const DrrProjector,
    (argument, views, view_count): (&str, *const V, usize),
    mut request: impl FnMut(&ProjectorValue, &V) -> Result<ViewRequest>,
    monitor: impl FnOnce(u64) -> Monitor,
    exposure: *mut *mut DrrExposure,
) -> Result<()> {
    memory::check("exposure", exposure, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let value = unsafe { handle::borrow("projector", projector)? };
    check_views(view_count)?;
    // SAFETY: the C caller passes `view_count` views.
    let views = unsafe { memory::read_array(argument, views, view_count)? };
    let requests = requests(argument, views, |view| request(&value, view))?;
    let monitor = monitor(value.projector.rays(&requests) as u64);
    let made = value.projector.expose(&requests, &|rays| monitor.report(rays));
    let made = made.map_err(|error| names::in_c(error).called("views", argument))?;
    monitor.complete()?;
    let value = ExposureValue { exposure: made, scene: value.projector.scene().clone() };
    // SAFETY: `exposure` is not null and aligned; the C caller passes a place for one handle.
    unsafe { exposure.write(handle::create(value)) };
    Ok(())
}

/// Makes the images of all views of an exposure, as `scene` says, or, for NULL, as the scene that it was made with.
///
/// May differ from that scene: energies, spectrum, detector response and efficiency, second detector layer, filters,
/// values in mass_attenuation, heel, fall-off, scatter, blur, fill factor, noise. Must be the same: detector's size,
/// supersampling, material_count, whether mass_attenuation is NULL, bone, focal spot, implants. Algorithm, step and
/// tolerances say how rays are cast, which they have been: they are checked, and otherwise not read.
///
/// Scene and `outputs` are only read during the call; images lie as those of drr_projector_project, with one or two
/// detector layers as `scene` has; outputs->progress is not called. On failure the outputs are as before. Fails with
/// DRR_STATUS_INVALID_ARGUMENT or DRR_STATUS_OUT_OF_MEMORY. Any thread, also with one exposure from many at once, each
/// with outputs of its own. The same call gives the same bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_exposure_develop(
    exposure: *const DrrExposure,
    scene: *const DrrScene,
    outputs: *const DrrOutputs,
) -> DrrStatus {
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let value = unsafe { handle::borrow("exposure", exposure)? };
        let other = if scene.is_null() {
            None
        } else {
            // SAFETY: the C caller passes a struct of the size that it says, whose tables are as described.
            Some(unsafe { options::read("scene", scene)?.read()? })
        };
        let scene = other.as_ref().unwrap_or(&value.scene);
        // SAFETY: the C caller passes a struct of the size that it says.
        let places = Places::from(unsafe { options::read("outputs", outputs)? });
        let layers = places.layers(scene, value.exposure.views())?;
        let made = value.exposure.develop(scene, layers);
        let (images, _) = made.map_err(names::in_c)?;
        // SAFETY: the C caller passes places for the images of all views.
        unsafe { places.write(&images) };
        Ok(())
    })
}

/// Gives an exposure up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_exposure_destroy(exposure: *mut DrrExposure) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("exposure", exposure) })
}
