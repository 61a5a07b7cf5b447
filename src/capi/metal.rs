//! Volumes whose voxels a Metal pipeline has on the GPU already.

use std::ffi::c_void;
use std::sync::Arc;

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::handle;
use crate::capi::status::DrrStatus;
use crate::capi::volume::{DrrVolume, DrrVolumeDescriptor, VolumeValue};
use crate::capi::{memory, options};
use crate::volume::Volume;

/// Makes a volume of the int16 CT numbers in a texture of Metal's, which are read where they are: nothing is copied.
///
/// `context` must be of DRR_BACKEND_METAL. `texture` is an id<MTLTexture> of its GPU: MTLTextureType3D,
/// MTLPixelFormatR16Sint, usage with MTLTextureUsageShaderRead, as large as descriptor->dimensions; texel (i, j, k) is
/// voxel (i, j, k), and the descriptor's thresholds decide what it is made of. The volume retains it. Its texels may be
/// written before and after, but not while a call or a command buffer projects the volume; nothing but Metal orders the
/// two. What the volume holds is not looked at: every material of the thresholds is taken to occur, so a scene must have
/// them all.
///
/// On success `*volume` is a new handle, to be given to drr_volume_destroy; on failure `*volume` is left as it is. Fails
/// with DRR_STATUS_INVALID_ARGUMENT; with DRR_STATUS_UNSUPPORTED when the context has another engine, as it has
/// everywhere but on Apple's systems; with DRR_STATUS_OUT_OF_MEMORY. drr_reference_project cannot read such a volume and
/// fails with DRR_STATUS_UNSUPPORTED. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_create_metal_texture(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    texture: *mut c_void,
    volume: *mut *mut DrrVolume,
) -> DrrStatus {
    guard(|| {
        memory::check("volume", volume, 1)?;
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let context = unsafe { handle::borrow("context", context)? };
        // SAFETY: the C caller passes a struct of the size that it says.
        let descriptor = unsafe { options::read("descriptor", descriptor)? };
        let (grid, classification) = (descriptor.grid()?, descriptor.classification()?);
        // Objects are aligned at least as pointers are.
        memory::check("texture", texture.cast::<usize>(), 1)?;
        // SAFETY: the C caller passes a texture when the context's engine has them.
        let texture = unsafe { context.texture(texture, grid.dimensions())? };
        let made = Arc::new(Volume::from_texture(grid, texture, &classification)?);
        // SAFETY: `volume` is not null and aligned; the C caller passes a place for one handle.
        unsafe { volume.write(handle::create(VolumeValue { context: context.clone(), volume: made })) };
        Ok(())
    })
}
