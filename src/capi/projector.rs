//! Projectors: views in, images out.

use std::ffi::{CString, c_char};

use crate::allocation::reserved;
use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::lut::{self, Tables};
use crate::capi::outputs::{DrrOutputs, Places};
use crate::capi::scene::DrrScene;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolume;
use crate::capi::{memory, names, options};
use crate::engine::Backend;
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
        let made = Projector::new(&volume.context, volume.volume.clone(), scene).map_err(names::in_c)?;
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
/// the handle is refused. A poisoned projector still has its plan: the report of a defect may need it.
///
/// The string belongs to the projector and lives as long. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_describe(projector: *const DrrProjector) -> *const c_char {
    let mut plan = std::ptr::null();
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive as long as it uses the string.
        plan = unsafe { handle::borrow_even_poisoned("projector", projector)? }.plan.as_ptr();
        Ok(())
    });
    plan
}

/// Projects the `view_count` `views`, 1 to DRR_MAX_VIEWS, given by projection matrices. Rays are half-lines from the
/// source, or full lines for a parallel beam: no detector ends them.
///
/// `views` and the tables behind their LUT addresses are only read during the call. An address, aligned to 4 bytes, is a
/// host pointer on engines of the CPU and an address of its memory on a GPU, where the tables must be complete before
/// the call. The values there are checked, the address itself cannot be. Metal's command buffers read only what is
/// resident for them: there tables need drr_projector_encode, and nothing of them is checked.
/// Tables of a view need DRR_EFFECT_POLYENERGETIC; a view's spectrum is used as it is, without the scene's detector
/// response. With enableEarlyExit the intensity may differ by exp(-15) of I0; where other images are asked for that
/// would change too, rays are not stopped; nor are they in a scene with effects or a second detector layer, which refuses
/// tables of a view. A focal spot, scatter and blur need views given by poses.
///
/// Everything is computed before anything is written: on failure the outputs are as before. Fails with
/// DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_OUT_OF_MEMORY, DRR_STATUS_DEVICE when a GPU fails, or DRR_STATUS_CANCELLED
/// when outputs->progress answers false. Any thread, also with one projector from many at once, each with outputs of
/// its own. The same call gives the same bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_project(
    projector: *const DrrProjector,
    views: *const ProjectionUniforms,
    view_count: usize,
    outputs: *const DrrOutputs,
) -> DrrStatus {
    let mut tables = Tables::default();
    // SAFETY: a view's tables are the C caller's, as described, and stay as they are during the call.
    let request = |value: &ProjectorValue, view: &ProjectionUniforms| unsafe {
        uniforms_request(&mut tables, value, view)
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { project(projector, "views", views, view_count, outputs, request) })
}

/// The request of a view that is given by uniforms.
///
/// # Safety
/// As for [`Tables::model`].
pub(super) unsafe fn uniforms_request(
    tables: &mut Tables,
    value: &ProjectorValue,
    view: &ProjectionUniforms,
) -> Result<ViewRequest> {
    let mut request = ViewRequest::from(View::Projection(view.into()));
    request.early_exit = view.enableEarlyExit.get();
    if value.projector.plan().engine == Backend::Metal {
        request.lut_addresses = lut::addresses(value, view)?;
    } else {
        // SAFETY: the caller's promise is the same.
        request.spectral = unsafe { tables.model(value, view)? };
    }
    Ok(request)
}

/// Projects `view_count` views, 1 to DRR_MAX_VIEWS, given by `poses` in float64, one per view. Rays are the segments
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
    mut request: impl FnMut(&ProjectorValue, &V) -> Result<ViewRequest>,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let value = unsafe { handle::borrow("projector", projector)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let places = Places::from(unsafe { options::read("outputs", outputs)? });
    let layers = places.layers(value.projector.scene(), view_count)?;
    // SAFETY: the C caller passes `view_count` views.
    let views = unsafe { memory::read_array(argument, views, view_count)? };
    let requests = requests(argument, views, |view| request(&value, view))?;
    // SAFETY: the C caller passes a function that may be called until this call returns.
    let monitor = unsafe { places.monitor(value.projector.rays(&requests)) };
    let images = value.projector.project(&requests, layers, &|rays| monitor.report(rays));
    let images = images.map_err(|error| names::in_c(error).called("views", argument))?;
    monitor.complete()?;
    // SAFETY: the C caller passes places for the images of `view_count` views.
    unsafe { places.write(&images) };
    Ok(())
}

/// The requests of all views; an error says which view it is about.
pub(super) fn requests<V>(
    argument: &str,
    views: &[V],
    mut request: impl FnMut(&V) -> Result<ViewRequest>,
) -> Result<Vec<ViewRequest>> {
    let mut requests = reserved(views.len(), "the views")?;
    for (v, view) in views.iter().enumerate() {
        let request = request(view).and_then(|request| request.view.validate().map(|()| request));
        requests.push(request.map_err(|error| error.of(&format!("{argument}[{v}]")))?);
    }
    Ok(requests)
}

#[cfg(test)]
mod tests {
    use std::ffi::CStr;

    use super::*;
    use crate::capi::context::{drr_context_create, drr_context_destroy};
    use crate::capi::geometry::drr_pose_c_arm;
    use crate::capi::outputs::drr_outputs_init;
    use crate::capi::scene::drr_scene_init;
    use crate::capi::status::{DRR_STATUS_INTERNAL, DRR_STATUS_OK, drr_last_error_message};
    use crate::capi::volume::{drr_volume_create, drr_volume_descriptor_init, drr_volume_destroy};
    use crate::engine::Layers;

    const WIDTH: usize = 4;

    /// A handle or a struct that a function of the C ABI fills.
    fn made<T>(make: impl FnOnce(*mut T) -> DrrStatus) -> T {
        let mut place = std::mem::MaybeUninit::uninit();
        assert_eq!(make(place.as_mut_ptr()), DRR_STATUS_OK);
        // SAFETY: a call that succeeds has written its result.
        unsafe { place.assume_init() }
    }

    #[test]
    fn a_panic_in_a_worker_poisons_the_projector_and_the_library_goes_on() {
        // SAFETY: pointers to one value of the right type each, or to as many as the descriptor and the scene say;
        // every handle is destroyed once.
        unsafe {
            let context = made(|place| drr_context_create(std::ptr::null(), place));
            let mut descriptor = made(|place| drr_volume_descriptor_init(place));
            descriptor.dimensions = [WIDTH; 3];
            let hu = [0_i16; WIDTH * WIDTH * WIDTH];
            let volume = made(|place| {
                drr_volume_create(context, &raw const descriptor, hu.as_ptr(), std::ptr::null(), place)
            });
            let mut scene = made(|place| drr_scene_init(place));
            (scene.detector_width, scene.detector_height) = (WIDTH, WIDTH);
            let create = || made(|place| drr_projector_create(volume, &raw const scene, place));
            let (spoilt, other): (*mut DrrProjector, *mut DrrProjector) = (create(), create());
            let centre = [1.5; 3];
            let pose =
                made(|place| drr_pose_c_arm(centre.as_ptr(), 0.0, 100.0, 200.0, 1.0, WIDTH, WIDTH, place));
            let mut image = [42.0_f32; WIDTH * WIDTH];
            let mut outputs = made(|place| drr_outputs_init(place));
            outputs.intensity = image.as_mut_ptr();
            let project = |projector| {
                let status = drr_projector_project_poses(projector, &raw const pose, 1, &raw const outputs);
                (status, outputs.intensity.read())
            };

            let panics = || {
                let value = handle::borrow("projector", spoilt)?;
                let view = View::Pose((&pose).into()).into();
                let wanted = Layers { intensity: true, ..Layers::default() };
                value.projector.project(&[view], wanted, &|_| panic!("a worker's defect")).map(drop)
            };
            assert_eq!(guard(panics), DRR_STATUS_INTERNAL);
            let message = || CStr::from_ptr(drr_last_error_message()).to_str().expect("UTF-8");
            assert_eq!(message(), "internal error: a worker's defect");

            assert_eq!(project(spoilt), (DRR_STATUS_INTERNAL, 42.0));
            assert!(message().starts_with("projector is poisoned: "), "{}", message());
            assert!(
                CStr::from_ptr(drr_projector_describe(spoilt)).to_str().expect("UTF-8").contains("stages")
            );
            // Its siblings and parents, and the threads that they share with it, go on.
            let (status, intensity) = project(other);
            assert!(status == DRR_STATUS_OK && intensity < 1.0, "{intensity}");
            let later = create();
            assert_eq!(project(later), (status, intensity));

            for projector in [spoilt, other, later] {
                assert_eq!(drr_projector_destroy(projector), DRR_STATUS_OK);
            }
            assert_eq!(drr_volume_destroy(volume), DRR_STATUS_OK);
            assert_eq!(drr_context_destroy(context), DRR_STATUS_OK);
        }
    }
}
