//! Images in a cone beam and their derivatives with respect to where the object is, in float32.

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::pose_gradient_calls::{self, Moved};
use crate::capi::scene::DrrScene;
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolume;
use crate::pose_gradient::PoseProjector;

/// What an image holds: one of the DRR_SIGNAL constants. Other values are refused.
pub type DrrPoseSignal = u32;

/// p = -ln(I / I0), of what the detector sees.
pub const DRR_SIGNAL_LINE_INTEGRAL: DrrPoseSignal = 0;
/// I, in the units of the spectrum.
pub const DRR_SIGNAL_INTENSITY: DrrPoseSignal = 1;

/// One volume before one detector, samples in float32: images as the object moves rigidly, and their derivatives,
/// through spectrum and detector. Runs on the context's CPU threads. Immutable: any number of threads may use one at
/// once. Keeps its volume and its context alive.
///
/// A motion has six parameters: alpha, beta, phi, rotations about x, y and z, RADIANS, up to 100, right-handed; then
/// the translation t along x, y and z, mm, up to 1e10. It takes x to R (x - pivot) + pivot + t with R = R_y(beta)
/// R_x(alpha) R_z(phi); source and detector stay.
pub struct DrrPoseGradient {
    _opaque: [u8; 0],
}

impl Opaque for DrrPoseGradient {
    type Value = PoseProjector<f32>;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr pog4");
    const NAME: &'static str = "DrrPoseGradient";
}

/// Plans `scene` for `volume`: its spectrum, all energies of it, its detector's response, materials, algorithm and rays
/// per pixel. A scene with effects, a second detector layer, a tolerance or DRR_ALGORITHM_DISTANCE_DRIVEN is
/// DRR_STATUS_UNSUPPORTED, as is a volume in a texture. With DRR_ALGORITHM_SIDDON derivatives jump from ray to ray.
///
/// `pivot`, 3 values, world mm, up to 1e10, is the point that the object turns about; NULL for the volume's centre. The
/// inputs are only read during the call. On success `*pose_gradient` is a new handle, to be given to
/// drr_pose_gradient_destroy; on failure `*pose_gradient` is left as it is. Fails with DRR_STATUS_INVALID_ARGUMENT,
/// DRR_STATUS_UNSUPPORTED or DRR_STATUS_OUT_OF_MEMORY. Any thread; nobody may write to the inputs during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_create(
    volume: *const DrrVolume,
    scene: *const DrrScene,
    pivot: *const f64,
    pose_gradient: *mut *mut DrrPoseGradient,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::create(volume, scene, pivot, pose_gradient) })
}

/// Gives a pose gradient up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_destroy(pose_gradient: *mut DrrPoseGradient) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("pose_gradient", pose_gradient) })
}

/// The `image` of the object after a motion, one value per pixel, seen from one `pose`: pixel (i, j), i = column, is at
/// j × detector_width + i, as in everything that has one value per pixel. `parameters` are 6: alpha, beta, phi
/// (radians), then the translation (mm).
///
/// Inputs are only read during the call; `image` is written on success only. Fails with DRR_STATUS_INVALID_ARGUMENT or
/// DRR_STATUS_OUT_OF_MEMORY. Any thread, also with one handle from many at once. The same call gives the same bytes for
/// any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_project(
    pose_gradient: *const DrrPoseGradient,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    image: *mut f32,
) -> DrrStatus {
    let view = Moved { pose, parameters, signal };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::project(pose_gradient, view, image) })
}

/// What a step of Gauss and Newton needs, in one pass: with r = image - measured over the pixels that count, and J =
/// its derivatives with respect to the six parameters, `*loss` is the sum of r^2, halved; gradient[n] the derivative of
/// the loss with respect to parameter n, which is the n-th entry of J^T r; hessian[6 × m + n] that of J^T J. Per
/// radian, per mm. Sums over several poses are those of one problem.
///
/// `measured` is an image, finite where pixels count, and not read elsewhere. `mask` is one byte per pixel, 0 for those
/// that do not count; NULL for all; at least one must count. `loss` is a place for 1 number, `gradient` for 6,
/// `hessian` for 36, or NULL.
///
/// Otherwise as drr_pose_gradient_project.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_loss_value_and_grad(
    pose_gradient: *const DrrPoseGradient,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    measured: *const f32,
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

/// The image and its derivatives with respect to the six parameters, per radian and per mm. `jacobian` has 6 values per
/// pixel: that of pixel (i, j) with respect to parameter n is at (n × detector_height + j) × detector_width + i.
/// `image` may be NULL.
///
/// Otherwise as drr_pose_gradient_project.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_gradient_jacobian(
    pose_gradient: *const DrrPoseGradient,
    pose: *const DrrDetectorPose,
    parameters: *const f64,
    signal: DrrPoseSignal,
    image: *mut f32,
    jacobian: *mut f32,
) -> DrrStatus {
    let view = Moved { pose, parameters, signal };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { pose_gradient_calls::jacobian(pose_gradient, view, (image, jacobian)) })
}
