//! What the functions of both widths of a pose gradient do.

use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle::{self, Opaque};
use crate::capi::normal_equations::LossPlaces;
use crate::capi::pose_gradient::{DRR_SIGNAL_INTENSITY, DRR_SIGNAL_LINE_INTEGRAL, DrrPoseSignal};
use crate::capi::scene::DrrScene;
use crate::capi::volume::DrrVolume;
use crate::capi::{memory, motion, names, options};
use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, RigidMotion};
use crate::pose_gradient::{PoseProjector, Signal};
use crate::real::Real;

/// Number of parameters of a motion: three angles and a translation.
const PARAMETERS: usize = 6;

/// One view of the object after a motion.
#[derive(Clone, Copy)]
pub(super) struct Moved {
    pub(super) pose: *const DrrDetectorPose,
    pub(super) parameters: *const f64,
    pub(super) signal: DrrPoseSignal,
}

impl Moved {
    /// A view and a motion that are valid.
    ///
    /// # Safety
    /// Unless they are null or misaligned, the pointers are to one pose and to six numbers.
    unsafe fn read(&self) -> Result<(DetectorPose, RigidMotion, Signal)> {
        // SAFETY: the caller's promise is the same.
        let (pose, values) = unsafe {
            let pose = memory::read_array("pose", self.pose, 1)?;
            (DetectorPose::from(&pose[0]), memory::read_array("parameters", self.parameters, PARAMETERS)?)
        };
        pose.validate().map_err(|error| error.of("pose"))?;
        let (angles, translation) = (values[..3].try_into(), glam::DVec3::from_slice(&values[3..]));
        let moved = RigidMotion { angles: angles.unwrap_or_default(), translation };
        moved.validate().map_err(|error| motion::in_array(error, 0, "[3] to [5], the translation"))?;
        let signal = match self.signal {
            DRR_SIGNAL_LINE_INTEGRAL => Signal::LineIntegral,
            DRR_SIGNAL_INTENSITY => Signal::Intensity,
            code => return Err(Error::invalid("signal", code, "one of the DRR_SIGNAL constants, 0 … 1")),
        };
        Ok((pose, moved, signal))
    }
}

/// # Safety
/// The pointers are as `drr_pose_gradient_create` says.
pub(super) unsafe fn create<T: Real, O: Opaque<Value = PoseProjector<T>>>(
    volume: *const DrrVolume,
    scene: *const DrrScene,
    pivot: *const f64,
    pose_gradient: *mut *mut O,
) -> Result<()> {
    memory::check("pose_gradient", pose_gradient, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let volume = unsafe { handle::borrow("volume", volume)? };
    // SAFETY: the C caller passes a struct of the size that it says, whose tables are as described.
    let scene = unsafe { options::read("scene", scene)?.read()? };
    // SAFETY: the C caller passes three numbers, or null.
    let pivot = unsafe { memory::read_optional("pivot", pivot, 3)? };
    let mut made = PoseProjector::new(&volume.context, volume.volume.clone(), &scene).map_err(names::in_c)?;
    if let Some(pivot) = pivot {
        made = made.with_pivot(glam::DVec3::from_slice(pivot))?;
    }
    // SAFETY: `pose_gradient` is not null and aligned; the C caller passes a place for one handle.
    unsafe { pose_gradient.write(handle::create(made)) };
    Ok(())
}

/// Pixels of an image.
fn pixels<T: Real>(projector: &PoseProjector<T>) -> usize {
    projector.size().into_iter().product()
}

/// # Safety
/// The pointers are as `drr_pose_gradient_project` says.
pub(super) unsafe fn project<T: Real, O: Opaque<Value = PoseProjector<T>>>(
    pose_gradient: *const O,
    view: Moved,
    image: *mut T,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("pose_gradient", pose_gradient)? };
    memory::check("image", image, pixels(&projector))?;
    // SAFETY: the C caller passes one pose and six numbers.
    let (pose, moved, signal) = unsafe { view.read()? };
    let made = projector.project(&pose, &moved, signal)?;
    // SAFETY: checked above; the C caller passes a place for one image.
    unsafe { memory::write_array(image, &made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_pose_gradient_loss_value_and_grad` says.
pub(super) unsafe fn loss_value_and_grad<T: Real, O: Opaque<Value = PoseProjector<T>>>(
    pose_gradient: *const O,
    view: Moved,
    (measured, mask): (*const T, *const u8),
    places: LossPlaces,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("pose_gradient", pose_gradient)? };
    let pixels = pixels(&projector);
    places.check(PARAMETERS)?;
    // SAFETY: the C caller passes one pose and six numbers, an image, and one byte per pixel or null.
    let ((pose, moved, signal), measured, mask) = unsafe {
        (view.read()?, memory::read_array("measured", measured, pixels)?, memory::read_mask(mask, pixels)?)
    };
    let made = projector.loss_value_and_grad(&pose, &moved, signal, measured, mask.as_deref())?;
    // SAFETY: checked above; the C caller passes places for 1, 6 and 36 numbers.
    unsafe { places.write(&made) };
    Ok(())
}

/// # Safety
/// The pointers are as `drr_pose_gradient_jacobian` says.
pub(super) unsafe fn jacobian<T: Real, O: Opaque<Value = PoseProjector<T>>>(
    pose_gradient: *const O,
    view: Moved,
    (image, jacobian): (*mut T, *mut T),
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let projector = unsafe { handle::borrow("pose_gradient", pose_gradient)? };
    let pixels = pixels(&projector);
    memory::check_optional("image", image, pixels)?;
    memory::check("jacobian", jacobian, pixels * PARAMETERS)?;
    // SAFETY: the C caller passes one pose and six numbers.
    let (pose, moved, signal) = unsafe { view.read()? };
    let made = projector.jacobian(&pose, &moved, signal)?;
    // SAFETY: checked above; the C caller passes places for an image, or null, and for six planes.
    unsafe {
        memory::write_array(image, &made.image);
        memory::write_planes(jacobian, &made.derivatives);
    }
    Ok(())
}
