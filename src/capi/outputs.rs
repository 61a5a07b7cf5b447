//! Where images go.

use crate::capi::boundary::guard;
use crate::capi::memory;
use crate::capi::options::{self, Options};
use crate::capi::status::DrrStatus;
use crate::engine::{Images, Layers};
use crate::error::{Error, Result};
use crate::projector::Projector;

/// Most views of one call.
pub const DRR_MAX_VIEWS: usize = 65_536;

/// Where a projection's float32 images go; NULL for what is not wanted, which then costs nothing. Fill it with
/// drr_outputs_init, then set at least one.
///
/// Pixel (i, j), i = column, of view v is at (v × detector_height + j) × detector_width + i. The arrays are the
/// caller's; they are written on success only.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrOutputs {
    /// Set by drr_outputs_init.
    pub struct_size: usize,
    /// Detector signal, in the units of the spectrum.
    pub intensity: *mut f32,
    /// p = -ln(I / I0). Finite wherever the areal densities are, also where the intensity underflows to 0.
    pub line_integral: *mut f32,
    /// Integral of density along the ray per material, g/cm². Pixel (i, j) of material m of view v is at
    /// ((v × material_count + m) × detector_height + j) × detector_width + i.
    pub areal_density: *mut f32,
    /// Length through voxels of bone, mm. Only with DRR_EFFECT_BONE_PATH.
    pub bone_path_mm: *mut f32,
}

/// Where a reference projection's float64 images go. As DrrOutputs.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrReferenceOutputs {
    /// Set by drr_reference_outputs_init.
    pub struct_size: usize,
    /// As DrrOutputs.
    pub intensity: *mut f64,
    /// As DrrOutputs.
    pub line_integral: *mut f64,
    /// As DrrOutputs.
    pub areal_density: *mut f64,
    /// As DrrOutputs.
    pub bone_path_mm: *mut f64,
}

const OUTPUTS_SIZE: usize = size_of::<[usize; 5]>();

// SAFETY: repr(C), no padding (asserted), starts with its size; raw pointers only.
unsafe impl Options for DrrOutputs {
    const SIZES: &'static [usize] = &[OUTPUTS_SIZE];
    fn defaults() -> Self {
        let none = std::ptr::null_mut();
        let struct_size = size_of::<Self>();
        Self { struct_size, intensity: none, line_integral: none, areal_density: none, bone_path_mm: none }
    }
}

// SAFETY: as above.
unsafe impl Options for DrrReferenceOutputs {
    const SIZES: &'static [usize] = &[OUTPUTS_SIZE];
    fn defaults() -> Self {
        let none = std::ptr::null_mut();
        let struct_size = size_of::<Self>();
        Self { struct_size, intensity: none, line_integral: none, areal_density: none, bone_path_mm: none }
    }
}

const _: () = assert!(size_of::<DrrOutputs>() == OUTPUTS_SIZE);
const _: () = assert!(size_of::<DrrReferenceOutputs>() == OUTPUTS_SIZE);

/// The places for a call's layers, whatever their type.
pub(super) struct Places<T> {
    intensity: *mut T,
    line_integral: *mut T,
    areal_density: *mut T,
    bone_path: *mut T,
}

impl From<DrrOutputs> for Places<f32> {
    fn from(o: DrrOutputs) -> Self {
        let DrrOutputs { intensity, line_integral, areal_density, bone_path_mm: bone_path, .. } = o;
        Self { intensity, line_integral, areal_density, bone_path }
    }
}

impl From<DrrReferenceOutputs> for Places<f64> {
    fn from(o: DrrReferenceOutputs) -> Self {
        let DrrReferenceOutputs { intensity, line_integral, areal_density, bone_path_mm: bone_path, .. } = o;
        Self { intensity, line_integral, areal_density, bone_path }
    }
}

impl<T: Copy> Places<T> {
    /// Checks the places for `views` views and says which layers are wanted.
    pub(super) fn layers(&self, projector: &Projector, views: usize) -> Result<Layers> {
        if !(1..=DRR_MAX_VIEWS).contains(&views) {
            return Err(Error::invalid("view_count", views, format!("1 … {DRR_MAX_VIEWS}")));
        }
        let scene = projector.scene();
        let materials = scene.materials.names().len();
        // At most 2^16 views of 2^30 pixels and 8 materials: no overflow in 64 bits.
        let pixels = views as u64 * (scene.detector[0] * scene.detector[1]) as u64;
        let wanted = |name: &str, place: *mut T, values: u64| {
            if !place.is_null() {
                memory::check(name, place, usize::try_from(values).unwrap_or(usize::MAX))?;
            }
            Ok(!place.is_null())
        };
        let layers = Layers {
            intensity: wanted("outputs.intensity", self.intensity, pixels)?,
            line_integral: wanted("outputs.line_integral", self.line_integral, pixels)?,
            areal_density: wanted("outputs.areal_density", self.areal_density, pixels * materials as u64)?,
            bone_path: wanted("outputs.bone_path_mm", self.bone_path, pixels)?,
        };
        if layers == Layers::default() {
            return Err(Error::invalid("outputs", "NULL for every image", "at least one image"));
        }
        if layers.bone_path && scene.bone.is_none() {
            let valid = "NULL, because the scene is without DRR_EFFECT_BONE_PATH";
            return Err(Error::invalid("outputs.bone_path_mm", "not NULL", valid));
        }
        Ok(layers)
    }

    /// Copies the images to the caller.
    ///
    /// # Safety
    /// Each place that is not null has room for its layer of `images`.
    pub(super) unsafe fn write(&self, images: &Images<T>) {
        // SAFETY: by the caller's promise; `layers` saw to alignment.
        unsafe {
            memory::write_array(self.intensity, &images.intensity);
            memory::write_array(self.line_integral, &images.line_integral);
            memory::write_array(self.areal_density, &images.areal_density);
            memory::write_array(self.bone_path, &images.bone_path);
        }
    }
}

/// Fills `*outputs` with NULL and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_outputs_init(outputs: *mut DrrOutputs) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("outputs", outputs) })
}

/// Fills `*outputs` with NULL and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_reference_outputs_init(outputs: *mut DrrReferenceOutputs) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("outputs", outputs) })
}
