//! Images in a cone beam and their derivatives with respect to where the object is, in float64: the twin of those in float32.

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::pose_gradient::DrrPoseSignal;
use crate::capi::pose_gradient_calls::{self, Moved};
use crate::capi::scene::DrrScene;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolume;
use crate::pose_gradient::PoseProjector;

/// As DrrPoseGradient, in float64. A handle of the other type is refused.
pub struct DrrPoseGradientF64 {
    _opaque: [u8; 0],
}

impl Opaque for DrrPoseGradientF64 {
    type Value = PoseProjector<f64>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr pog8");
    const NAME: &'static str = "DrrPoseGradientF64";
}

/// As drr_pose_gradient_create, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_create_f64(
    volume: *const DrrVolume,
    scene: *const DrrScene,
    pivot: *const f64,
    pose_gradient: *mut *mut DrrPoseGradientF64,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::create(volume, scene, pivot, pose_gradient) })
}

/// As drr_pose_gradient_destroy, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_destroy_f64(pose_gradient: *mut DrrPoseGradientF64) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("pose_gradient", pose_gradient) })
}

/// As drr_pose_gradient_project, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_project_f64(
    pose_gradient: *const DrrPoseGradientF64,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    image: *mut f64,
) -> DrrStatus {
    let view = Moved { pose, parameters, signal };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::project(pose_gradient, view, image) })
}

/// As drr_pose_gradient_loss_value_and_grad, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_loss_value_and_grad_f64(
    pose_gradient: *const DrrPoseGradientF64,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    measured: *const f64,
    mask: *const u8,
    loss: *mut f64,
    gradient: *mut f64,
    hessian: *mut f64,
) -> DrrStatus {
    let (view, places) = (Moved { pose, parameters, signal }, LossPlaces { loss, gradient, hessian });
    let image = (measured, mask);
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::loss_value_and_grad(pose_gradient, view, image, places) })
}

/// As drr_pose_gradient_jacobian, in float64.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_jacobian_f64(
    pose_gradient: *const DrrPoseGradientF64,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    image: *mut f64,
    jacobian: *mut f64,
) -> DrrStatus {
    let view = Moved { pose, parameters, signal };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::jacobian(pose_gradient, view, (image, jacobian)) })
}
