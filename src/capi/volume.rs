//! Volumes: CT numbers, labels and their place in the world.

use std::sync::Arc;

use glam::{DAffine3, DMat4};

use crate::Context;
use crate::capi::boundary::guard;
use crate::capi::context::DrrContext;
use crate::capi::handle::{self, Opaque};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, options};
use crate::error::{Error, Result};
use crate::geometry::Grid;
use crate::volume::{Classification, Volume};

/// A curve from CT numbers to mass density: one of the DRR_CALIBRATION constants. Other values are refused. CT numbers
/// above 3071 HU, the ceiling of 12-bit scanners, count as 3071, those from -1024 to -1000 as -1000; below -1024 is
/// padding outside the scan, which is vacuum.
pub type DrrCalibration = u32;

/// 1 + HU/1000 g/cm³ up to water, then a line through cortical bone (1641.885 HU, 1.92 g/cm³).
pub const DRR_CALIBRATION_WATER_ANCHORED: DrrCalibration = 0;
/// Schneider et al. 2000: 1.018 g/cm³ at 0 HU; has jumps.
pub const DRR_CALIBRATION_SCHNEIDER_2000: DrrCalibration = 1;
/// Two lines with 1.03 g/cm³ at 0 HU.
pub const DRR_CALIBRATION_BILINEAR_1P03: DrrCalibration = 2;
/// 1 + HU/1000 g/cm³: bone comes out too dense, but it is what most projectors assume.
pub const DRR_CALIBRATION_LINEAR: DrrCalibration = 3;

/// Which CT numbers are which material where no label is given: one of the DRR_THRESHOLDS constants. Other values
/// are refused. The n-th class has label n.
pub type DrrThresholds = u32;

/// air -950 lung -200 soft tissue 200 cortical bone: the specification's four materials.
pub const DRR_THRESHOLDS_FOUR_CLASS: DrrThresholds = 0;
/// air -799 soft tissue 351 cortical bone. Label 1 is soft tissue: needs a table of three materials.
pub const DRR_THRESHOLDS_THREE_CLASS: DrrThresholds = 1;
/// air -950 lung -120 adipose -53 soft tissue 120 cortical bone. Needs a table of five materials.
pub const DRR_THRESHOLDS_FIVE_CLASS: DrrThresholds = 2;
/// air -950 lung -200 adipose -20 soft tissue 200 cortical bone 2995 titanium. Needs a table of six materials.
pub const DRR_THRESHOLDS_SIX_CLASS: DrrThresholds = 3;

/// Shape, place and meaning of a volume's voxels. Fill it with drr_volume_descriptor_init, then set `dimensions`
/// and what else should differ.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrVolumeDescriptor {
    /// Set by drr_volume_descriptor_init.
    pub struct_size: usize,
    /// Voxels along i, j, k: each 1 to 32768, at most 2^32 in all. Voxel (i, j, k) is at
    /// (k × dimensions[1] + j) × dimensions[0] + i. Default 0, which is refused.
    pub dimensions: [usize; 3],
    /// Voxel index to world, mm, column-major: the centre of voxel (i, j, k) is at index_to_world × (i, j, k, 1),
    /// so entries 12 to 14 are the CENTRE of voxel (0, 0, 0). Any invertible map with entries up to 1e10 and
    /// columns of at least 1e-9 mm: shear, mirroring and anisotropy are allowed; the last row (entries 3, 7, 11, 15)
    /// must be 0, 0, 0, 1. Default identity.
    pub index_to_world: [f64; 16],
    /// CT number to density. Default DRR_CALIBRATION_WATER_ANCHORED.
    pub calibration: DrrCalibration,
    /// CT number to material, where no labels are given. Default DRR_THRESHOLDS_FOUR_CLASS.
    pub thresholds: DrrThresholds,
}

const DESCRIPTOR_SIZE: usize = size_of::<[usize; 4]>() + 136;

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl options::Options for DrrVolumeDescriptor {
    const SIZES: &'static [usize] = &[DESCRIPTOR_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            dimensions: [0; 3],
            index_to_world: DMat4::IDENTITY.to_cols_array(),
            calibration: DRR_CALIBRATION_WATER_ANCHORED,
            thresholds: DRR_THRESHOLDS_FOUR_CLASS,
        }
    }
}

const _: () = assert!(size_of::<DrrVolumeDescriptor>() == DESCRIPTOR_SIZE);

impl DrrVolumeDescriptor {
    pub(super) fn grid(&self) -> Result<Grid> {
        let matrix = DMat4::from_cols_array(&self.index_to_world);
        let last_row = matrix.row(3).to_array();
        if last_row != [0.0, 0.0, 0.0, 1.0] {
            let argument = "descriptor.index_to_world, last row (entries 3, 7, 11, 15)";
            return Err(Error::invalid(argument, format!("{last_row:?}"), "0, 0, 0, 1"));
        }
        Grid::new(self.dimensions, DAffine3::from_mat4(matrix)).map_err(|error| error.of("descriptor"))
    }

    pub(super) fn classification(&self) -> Result<Classification> {
        let calibration = match self.calibration {
            DRR_CALIBRATION_WATER_ANCHORED => "water_anchored",
            DRR_CALIBRATION_SCHNEIDER_2000 => "schneider2000",
            DRR_CALIBRATION_BILINEAR_1P03 => "bilinear_1p03",
            DRR_CALIBRATION_LINEAR => "linear",
            code => {
                let valid = "one of the DRR_CALIBRATION constants, 0 … 3";
                return Err(Error::invalid("descriptor.calibration", code, valid));
            }
        };
        let thresholds = match self.thresholds {
            DRR_THRESHOLDS_FOUR_CLASS => "four_class_mcgpu_like",
            DRR_THRESHOLDS_THREE_CLASS => "deepdrr_thresholds",
            DRR_THRESHOLDS_FIVE_CLASS => "schneider2000_merged",
            DRR_THRESHOLDS_SIX_CLASS => "six_class",
            code => {
                let valid = "one of the DRR_THRESHOLDS constants, 0 … 3";
                return Err(Error::invalid("descriptor.thresholds", code, valid));
            }
        };
        Classification::named(calibration, thresholds)
    }
}

/// A CT volume: density and material of every voxel. Immutable: any number of threads may use one at once. Keeps
/// its context alive; a projector keeps its volume alive, so it may be destroyed as soon as it is no longer named.
pub struct DrrVolume {
    _opaque: [u8; 0],
}

/// What a volume's handle owns.
pub(super) struct VolumeValue {
    pub(super) context: Context,
    pub(super) volume: Arc<Volume>,
}

impl Opaque for DrrVolume {
    type Value = VolumeValue;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr volu");
    const NAME: &'static str = "DrrVolume";
}

/// Fills `*descriptor` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_descriptor_init(descriptor: *mut DrrVolumeDescriptor) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("descriptor", descriptor) })
}

/// Makes a volume of int16 CT numbers. The voxels are copied: the caller's memory is free afterwards.
///
/// `hu` has one value in HU per voxel; what is below -1024 is padding and becomes vacuum. `labels` has one material
/// label, 0 to 7, per voxel, or is NULL: then the descriptor's thresholds decide. On success `*volume` is a new
/// handle, to be given to drr_volume_destroy; on failure `*volume` is left as it is. Fails with
/// DRR_STATUS_INVALID_ARGUMENT or DRR_STATUS_OUT_OF_MEMORY (2 bytes per voxel). Any thread; nobody may write to the
/// inputs during the call.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_create(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    hu: *const i16,
    labels: *const u8,
    volume: *mut *mut DrrVolume,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { create(context, descriptor, hu, labels, volume, Volume::from_int16) })
}

/// Makes a volume of float32 CT numbers, which need not be whole. As drr_volume_create, but NaN and infinities are
/// refused, and 5 bytes are held per voxel.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_create_float32(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    hu: *const f32,
    labels: *const u8,
    volume: *mut *mut DrrVolume,
) -> DrrStatus {
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { create(context, descriptor, hu, labels, volume, Volume::from_float32) })
}

/// A way to make a volume from voxels of type `T`.
type Make<T> = fn(Grid, &[T], Option<&[u8]>, &Classification) -> Result<Volume>;

/// # Safety
/// The pointers are as [`drr_volume_create`] says.
unsafe fn create<T: Copy + Sync>(
    context: *const DrrContext,
    descriptor: *const DrrVolumeDescriptor,
    hu: *const T,
    labels: *const u8,
    volume: *mut *mut DrrVolume,
    make: Make<T>,
) -> Result<()> {
    memory::check("volume", volume, 1)?;
    // SAFETY: the C caller passes a handle that stays alive during the call.
    let context = unsafe { handle::borrow("context", context)? };
    // SAFETY: the C caller passes a struct of the size that it says.
    let descriptor = unsafe { options::read("descriptor", descriptor)? };
    let (grid, classification) = (descriptor.grid()?, descriptor.classification()?);
    let count = grid.voxel_count();
    // SAFETY: the C caller passes one value per voxel, and one label per voxel or null.
    let (hu, labels) =
        unsafe { (memory::read_array("hu", hu, count)?, memory::read_optional("labels", labels, count)?) };
    let made = Arc::new(context.install(|| make(grid, hu, labels, &classification))?);
    // SAFETY: `volume` is not null and aligned; the C caller passes a place for one handle.
    unsafe { volume.write(handle::create(VolumeValue { context: context.clone(), volume: made })) };
    Ok(())
}

/// Gives a volume up; its projectors stay valid. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_volume_destroy(volume: *mut DrrVolume) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("volume", volume) })
}
