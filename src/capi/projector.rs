//! Projectors: views in, images out.

use std::ffi::{CString, c_char};

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::outputs::{DrrOutputs, Places};
use crate::capi::scene::DrrScene;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolume;
use crate::capi::{lut, memory, options};
use crate::error::Result;
use crate::geometry::View;
use crate::projector::{Projector, ViewRequest};
use crate::shared::ProjectionUniforms;

/// One volume, one scene, and the plan made for them. Immutable: any number of threads may project with one at
/// once. Keeps its volume and its context alive.
pub struct DrrProjector {
    _opaque: [u8; 0],
}

/// What a projector's handle owns.
pub(super) struct ProjectorValue {
    pub(super) projector: Projector,
    /// Whether views may bring tables of their own.
    pub(super) polyenergetic: bool,
    /// The march's step, for a reference projection with another algorithm than the scene's.
    pub(super) step_voxels: f64,
    plan: CString,
}

impl Opaque for DrrProjector {
    type Value = ProjectorValue;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr proj");
    const NAME: &'static str = "DrrProjector";
}

/// Plans `scene` for `volume` and makes the context's engine ready.
///
/// The scene and its tables are only read during the call. On success `*projector` is a new handle, to be given to
/// drr_projector_destroy; on failure `*projector` is left as it is. Fails with DRR_STATUS_INVALID_ARGUMENT, also
/// when the volume has a label that is not below material_count; with DRR_STATUS_UNSUPPORTED when the engine does
/// not have the algorithm; with DRR_STATUS_OUT_OF_MEMORY. Any thread; nobody may write to the inputs during the
/// call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_create(
    volume: *const DrrVolume,
    scene: *const DrrScene,
    projector: *mut *mut DrrProjector,
) -> DrrStatus {
    guard(|| {
        memory::check("projector", projector, 1)?;
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let volume = unsafe { handle::borrow("volume", volume)? };
        // SAFETY: the C caller passes a struct of the size that it says.
        let given = unsafe { options::read("scene", scene)? };
        // SAFETY: the C caller's tables are as the fields' descriptions say.
        let scene = unsafe { given.read()? };
        let made = Projector::new(&volume.context, volume.volume.clone(), scene)
            .map_err(|error| error.called("scene.materials", "scene.mass_attenuation"))?;
        let plan = CString::new(made.plan().to_json()).unwrap_or_default();
        let value = ProjectorValue {
            projector: made,
            polyenergetic: given.is_polyenergetic(),
            step_voxels: given.step_voxels,
            plan,
        };
        // SAFETY: `projector` is not null and aligned; the C caller passes a place for one handle.
        unsafe { projector.write(handle::create(value)) };
        Ok(())
    })
}

/// Gives a projector up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_destroy(projector: *mut DrrProjector) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("projector", projector) })
}

/// The plan in JSON: what runs and why, what it costs, its error, and what was left out. NULL, with a message, when
/// the handle is refused.
///
/// The string belongs to the projector and lives as long. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_describe(projector: *const DrrProjector) -> *const c_char {
    let mut plan = std::ptr::null();
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive as long as it uses the string.
        plan = unsafe { handle::borrow("projector", projector)? }.plan.as_ptr();
        Ok(())
    });
    plan
}

/// Projects `view_count` views, 1 to DRR_MAX_VIEWS, given by projection matrices. Rays are half-lines from the
/// source, or full lines for a parallel beam: no detector ends them.
///
/// `views` and the tables behind their LUT addresses are only read during the call; on engines of the CPU an
/// address is a host pointer, aligned to 4 bytes. The values there are checked, the address itself cannot be.
/// Tables of a view need DRR_EFFECT_POLYENERGETIC; a view's spectrum is used as it is, without the scene's detector
/// response. With enableEarlyExit the intensity may differ by exp(-15) of I0; where other images are asked for that
/// would change too, rays are not stopped.
///
/// Everything is computed before anything is written: on failure the outputs are as before. Fails with
/// DRR_STATUS_INVALID_ARGUMENT or DRR_STATUS_OUT_OF_MEMORY. Any thread, also with one projector from many at once,
/// each with outputs of its own. The same call gives the same bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_project(
    projector: *const DrrProjector,
    views: *const ProjectionUniforms,
    view_count: usize,
    outputs: *const DrrOutputs,
) -> DrrStatus {
    // SAFETY: a view's tables are the C caller's, as described.
    let request = |value: &ProjectorValue, view: &ProjectionUniforms| unsafe {
        Ok(ViewRequest {
            view: View::Projection(view.projection()),
            early_exit: view.enableEarlyExit.get(),
            spectral: lut::spectral_model(value, view)?,
        })
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { project(projector, "views", views, view_count, outputs, request) })
}

/// Projects `view_count` views, 1 to DRR_MAX_VIEWS, given by source and detector in float64. Rays are the segments
/// from the source to the pixels' centres: what lies behind a pixel does not count.
///
/// Otherwise as drr_projector_project.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_project_poses(
    projector: *const DrrProjector,
    poses: *const DrrDetectorPose,
    view_count: usize,
    outputs: *const DrrOutputs,
) -> DrrStatus {
    let request = |_: &ProjectorValue, pose: &DrrDetectorPose| Ok(View::Pose(pose.into()).into());
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { project(projector, "poses", poses, view_count, outputs, request) })
}

/// # Safety
/// The pointers are as [`drr_projector_project`] says.
unsafe fn project<V: Copy>(
    projector: *const DrrProjector,
    argument: &str,
    views: *const V,
    view_count: usize,
    outputs: *const DrrOutputs,
    request: impl Fn(&ProjectorValue, &V) -> Result<ViewRequest>,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let value = unsafe { handle::borrow("projector", projector)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let places = Places::from(unsafe { options::read("outputs", outputs)? });
    let layers = places.layers(&value.projector, view_count)?;
    // SAFETY: the C caller passes `view_count` views.
    let views = unsafe { memory::read_array(argument, views, view_count)? };
    let requests = requests(argument, views, |view| request(value, view))?;
    let images = value.projector.project(&requests, layers, &|_| ())?;
    // SAFETY: the C caller passes places for the images of `view_count` views.
    unsafe { places.write(&images) };
    Ok(())
}

/// The requests of all views; an error says which view it is about.
pub(super) fn requests<V>(
    argument: &str,
    views: &[V],
    request: impl Fn(&V) -> Result<ViewRequest>,
) -> Result<Vec<ViewRequest>> {
    let named = |(v, view): (usize, &V)| {
        let request = request(view).and_then(|request| request.view.validate().map(|()| request));
        request.map_err(|error| error.of(&format!("{argument}[{v}]")))
    };
    views.iter().enumerate().map(named).collect()
}
