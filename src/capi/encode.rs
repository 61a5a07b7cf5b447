//! Projections into a queue of the caller's: the images stay on the device.

use std::ffi::c_void;

use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle;
use crate::capi::lut::Tables;
use crate::capi::outputs::Places;
use crate::capi::projector::{DrrProjector, ProjectorValue, requests, uniforms_request};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, options};
use crate::engine::DeviceOutputs;
use crate::error::Result;
use crate::geometry::View;
use crate::projector::ViewRequest;
use crate::shared::ProjectionUniforms;

/// Where the float32 images of an encoded projection go, on the device; NULL for what is not wanted, which then costs
/// nothing. Fill it with drr_device_outputs_init, then set at least one.
///
/// An image is a CUdeviceptr, cast to a pointer, with DRR_BACKEND_CUDA; an id<MTLBuffer>, written from its first byte
/// on, with DRR_BACKEND_METAL. Pixels lie as those of DrrOutputs. Images must have room for all views, and must not
/// overlap.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrDeviceOutputs {
    /// Set by drr_device_outputs_init.
    pub struct_size: usize,
    /// As DrrOutputs.
    pub intensity: *mut c_void,
    /// As DrrOutputs.
    pub line_integral: *mut c_void,
    /// As DrrOutputs.
    pub areal_density: *mut c_void,
    /// As DrrOutputs.
    pub bone_path_mm: *mut c_void,
    /// The intensity as a picture: an id<MTLTexture> of the format R32Float, detector_width x detector_height pixels, 2D
    /// for one view or a 2D array of one slice per view. NULL with DRR_BACKEND_CUDA.
    pub intensity_texture: *mut c_void,
}

const OUTPUTS_SIZE: usize = size_of::<[usize; 6]>();

// SAFETY: repr(C), no padding (asserted), starts with its size; raw pointers only.
unsafe impl options::Options for DrrDeviceOutputs {
    const SIZES: &'static [usize] = &[OUTPUTS_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            intensity: std::ptr::null_mut(),
            line_integral: std::ptr::null_mut(),
            areal_density: std::ptr::null_mut(),
            bone_path_mm: std::ptr::null_mut(),
            intensity_texture: std::ptr::null_mut(),
        }
    }
}

const _: () = assert!(size_of::<DrrDeviceOutputs>() == OUTPUTS_SIZE);

impl DrrDeviceOutputs {
    /// Checked for `views` views as places on the host are: addresses and objects on a device are aligned as well.
    fn checked(&self, value: &ProjectorValue, views: usize) -> Result<DeviceOutputs> {
        memory::check_optional("outputs.intensity_texture", self.intensity_texture.cast::<f32>(), 1)?;
        let either = if self.intensity.is_null() { self.intensity_texture } else { self.intensity };
        let places = Places::<f32> {
            intensity: either.cast(),
            line_integral: self.line_integral.cast(),
            areal_density: self.areal_density.cast(),
            bone_path: self.bone_path_mm.cast(),
            progress: None,
            progress_data: std::ptr::null_mut(),
        };
        places.layers(value.projector.scene(), views)?;
        Ok(DeviceOutputs {
            intensity: self.intensity,
            line_integral: self.line_integral,
            areal_density: self.areal_density,
            bone_path: self.bone_path_mm,
            intensity_texture: self.intensity_texture,
        })
    }
}

/// Fills `*outputs` with NULL and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_device_outputs_init(outputs: *mut DrrDeviceOutputs) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("outputs", outputs) })
}

/// Puts the projection of the `view_count` `views`, 1 to DRR_MAX_VIEWS, into a queue of the caller's, and returns
/// without waiting for it: what comes later in the queue finds the images complete.
///
/// `queue` is a CUstream of the primary context of the context's GPU, or NULL for its default stream, with
/// DRR_BACKEND_CUDA; a stream that is being captured is refused. It is an id<MTLCommandBuffer> of the context's GPU,
/// which retains its references, has not been committed and has no open encoder, with DRR_BACKEND_METAL; the caller
/// commits it, and makes the tables behind LUT addresses, which only the GPU reads, resident for it. Queue and images
/// belong to the caller and must stay until the queue has run the projection; pointers to them are believed. Views,
/// their tables and `outputs` are only read during the call; LUT addresses are as for drr_projector_project. The
/// projector keeps what the queue needs: it must not be destroyed before the queue has run the projection.
///
/// The first call with new images or new kinds of views compiles a kernel, which takes about a second. On failure
/// nothing of the call is in the queue, but for DRR_STATUS_DEVICE and DRR_STATUS_OUT_OF_MEMORY, after which images may
/// be written. Fails with DRR_STATUS_INVALID_ARGUMENT; with DRR_STATUS_UNSUPPORTED for contexts of DRR_BACKEND_CPU and
/// DRR_BACKEND_REFERENCE, and for scenes with effects or a second detector layer, whose images are finished on the CPU.
/// What goes wrong while the queue runs is told by the queue. Any thread, also with one projector from many at once;
/// two threads must not use one queue at once where its own rules forbid it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_encode(
    projector: *const DrrProjector,
    views: *const ProjectionUniforms,
    view_count: usize,
    queue: *mut c_void,
    outputs: *const DrrDeviceOutputs,
) -> DrrStatus {
    let mut tables = Tables::default();
    let request = |value: &ProjectorValue, view: &ProjectionUniforms| {
        if [view.spectrumLutAddress, view.muLutAddress] != [0, 0] {
            // The addresses may be a device's, which an engine without one cannot read.
            value.projector.context().check_queues()?;
        }
        // SAFETY: a view's tables are the C caller's, as described, and stay as they are during the call.
        unsafe { uniforms_request(&mut tables, value, view) }
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { encode(projector, "views", views, view_count, queue, outputs, request) })
}

/// As drr_projector_encode, with views given by `poses` in float64, one per view, as for drr_projector_project_poses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_encode_poses(
    projector: *const DrrProjector,
    poses: *const DrrDetectorPose,
    view_count: usize,
    queue: *mut c_void,
    outputs: *const DrrDeviceOutputs,
) -> DrrStatus {
    let request = |_: &ProjectorValue, pose: &DrrDetectorPose| Ok(View::Pose(pose.into()).into());
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { encode(projector, "poses", poses, view_count, queue, outputs, request) })
}

/// # Safety The pointers are as [`drr_projector_encode`] says.
unsafe fn encode<V: Copy>(
    projector: *const DrrProjector,
    argument: &str,
    views: *const V,
    view_count: usize,
    queue: *mut c_void,
    outputs: *const DrrDeviceOutputs,
    mut request: impl FnMut(&ProjectorValue, &V) -> Result<ViewRequest>,
) -> Result<()> {
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let value = unsafe { handle::borrow("projector", projector)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let outputs = unsafe { options::read("outputs", outputs)? }.checked(&value, view_count)?;
    // SAFETY: the C caller passes `view_count` views.
    let views = unsafe { memory::read_array(argument, views, view_count)? };
    let requests = requests(argument, views, |view| request(&value, view))?;
    // SAFETY: queue and places are the C caller's, as described.
    unsafe { value.projector.encode(&requests, queue, &outputs) }
}
