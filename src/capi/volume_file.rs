//! Volumes that come from files.

use std::ffi::c_char;
use std::path::Path;
use std::sync::Arc;

use glam::DMat4;

use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::handle;
use crate::capi::status::DrrStatus;
use crate::capi::volume::{DrrVolume, DrrVolumeDescriptor, VolumeValue};
use crate::capi::{memory, options};
use crate::error::Result;
use crate::volume::{Classification, Volume};

/// Makes a volume of a CT in a file, slice by slice: memory for one slice is needed beside the volume.
///
/// `path` is UTF-8 and ends in NUL: a file of NIfTI-1 (.nii, .nii.gz), MetaImage (.mha, .mhd) or NRRD (.nrrd, .nhdr),
/// or, in builds with the Cargo feature `dicom`, a folder with one series of DICOM files, or a file with all frames of
/// one. Of `*descriptor`, calibration and thresholds are read;
/// on success its dimensions and index_to_world become those of the file, in a world that is LPS (x to the patient's
/// left, y to the back, z to the head), and `*volume` is a new handle, to be given to drr_volume_destroy. On failure
/// both are left as they are. What is passed over in a folder is not told. Fails with DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_FILE, DRR_STATUS_OUT_OF_MEMORY, or
/// DRR_STATUS_UNSUPPORTED in builds without the Cargo feature `formats`. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_load(
    context: *const DrrContext,
    path: *const c_char,
    descriptor: *mut DrrVolumeDescriptor,
    volume: *mut *mut DrrVolume,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { load(context, path, descriptor, volume) })
}

/// # Safety
/// The pointers are as [`drr_volume_load`] says.
unsafe fn load(
    context: *const DrrContext,
    path: *const c_char,
    descriptor: *mut DrrVolumeDescriptor,
    volume: *mut *mut DrrVolume,
) -> Result<()> {
    memory::check("volume", volume, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let context = unsafe { handle::borrow("context", context)? };
    // SAFETY: the C caller passes a string.
    let path = Path::new(unsafe { memory::read_text("path", path)? });
    // SAFETY: the C caller passes a struct of the size that it says.
    let how = unsafe { options::read("descriptor", descriptor)? }.classification()?;
    let made = Arc::new(context.install(|| read(path, &how))?);
    let grid = made.grid();
    // SAFETY: `descriptor` was read, so its fields are there; it and `volume`, which is not null and aligned, are the C
    // caller's to be written. Dimensions and map are in every version of the struct.
    unsafe {
        (*descriptor).dimensions = grid.dimensions();
        (*descriptor).index_to_world = DMat4::from(grid.index_to_world()).to_cols_array();
        volume.write(handle::create(VolumeValue { context: context.clone(), volume: made }));
    }
    Ok(())
}

#[cfg(feature = "formats")]
fn read(path: &Path, how: &Classification) -> Result<Volume> {
    let mut ct = crate::formats::open_ct(path, None)?;
    crate::formats::read_volume(ct.as_mut(), how)
}

#[cfg(not(feature = "formats"))]
fn read(path: &Path, _how: &Classification) -> Result<Volume> {
    let why = "this build of the library reads no files; valid: one with the Cargo feature `formats`";
    Err(crate::error::Error::Unsupported(format!("{}: {why}", path.display())))
}
