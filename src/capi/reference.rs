//! The float64 twin.

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle;
use crate::capi::outputs::{DrrReferenceOutputs, Places};
use crate::capi::projector::{DrrProjector, requests};
use crate::capi::scene::{self, DrrAlgorithm};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, names, options};
use crate::geometry::View;

/// Projects in float64, slowly, with any algorithm: what the projector's images are measured against.
///
/// With the scene's own algorithm it is that algorithm's twin; DRR_ALGORITHM_EXACT is the truth about the
/// interpolated volume. DRR_ALGORITHM_MARCH takes the scene's step_voxels. The `view_count` `poses`, outputs,
/// failure and threads are as drr_projector_project_poses has them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_reference_project(
    projector: *const DrrProjector,
    algorithm: DrrAlgorithm,
    poses: *const DrrDetectorPose,
    view_count: usize,
    outputs: *const DrrReferenceOutputs,
) -> DrrStatus {
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let value = unsafe { handle::borrow("projector", projector)? };
        let algorithm = scene::algorithm(algorithm, value.step_voxels)?;
        // SAFETY: the C caller passes a struct of the size that it says.
        let places = Places::from(unsafe { options::read("outputs", outputs)? });
        let layers = places.layers(value.projector.scene(), view_count)?;
        // SAFETY: the C caller passes `view_count` poses.
        let poses = unsafe { memory::read_array("poses", poses, view_count)? };
        let requests = requests("poses", poses, |pose| Ok(View::Pose(pose.into()).into()))?;
        // SAFETY: the C caller passes a function that may be called until this call returns.
        let monitor = unsafe { places.monitor(value.projector.rays(&requests)) };
        let report = |rays| monitor.report(rays);
        let images = value.projector.reference(algorithm, &requests, layers, &report);
        let images = images.map_err(|error| names::in_c(error).called("views", "poses"))?;
        monitor.complete()?;
        // SAFETY: the C caller passes places for the images of `view_count` views.
        unsafe { places.write(&images) };
        Ok(())
    })
}
