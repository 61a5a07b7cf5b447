//! Where images go.

use std::ffi::c_void;

use crate::capi::boundary::guard;
use crate::capi::memory;
use crate::capi::options::{self, Options};
use crate::capi::progress::Monitor;
use crate::capi::status::DrrStatus;
use crate::engine::{Images, Layers};
use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::shared::DrrBool;

/// Hears, while a call runs, the fraction of its rays that is done, 0 to 1, and answers whether to go on. `user_data`
/// is the caller's own.
///
/// Called after every few hundred rays of a thread, on a GPU after every few views: from the library's threads or the
/// calling one, one call at a time, with fractions that grow and end, unless the call fails, at 1. It should be quick,
/// because the thread that is in it projects nothing. It must not throw a C++ exception, not jump out with longjmp, and
/// not call this library.
///
/// Once it has answered false it is not called again, each thread finishes at most 1024 more rays, a GPU none, and the
/// call fails with DRR_STATUS_CANCELLED, having written nothing. The projector is as good as before.
pub type DrrProgress = Option<unsafe extern "C" fn(user_data: *mut c_void, fraction: f64) -> DrrBool>;

/// Most views of one call.
pub const DRR_MAX_VIEWS: usize = 65_536;

/// Where a projection's float32 images go; NULL for what is not wanted, which then costs nothing. Fill it with
/// drr_outputs_init, then set at least one.
///
/// Pixel (i, j), i = column, of view v is at (v × detector_height + j) × detector_width + i. With a second detector layer
/// intensity and line integral are two images per view: that pixel of layer l, 0 or 1, is at ((v × 2 + l) ×
/// detector_height + j) × detector_width + i. The arrays are the caller's; they are written on success only.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrOutputs {
    /// Set by drr_outputs_init.
    pub struct_size: usize,
    /// Detector signal, in the units of the spectrum. Noise is in these units too, and electronic noise may lead below 0.
    pub intensity: *mut f32,
    /// p = -ln(I / I0), where I0 is the noiseless signal of the pixel without the volume. Finite wherever the areal
    /// densities are, also where the intensity underflows to 0; infinite where noise, or the underflow of a scene with
    /// effects or a second detector layer, leaves no signal.
    pub line_integral: *mut f32,
    /// Integral of density along the ray per material, g/cm². Pixel (i, j) of material m of view v is at
    /// ((v × material_count + m) × detector_height + j) × detector_width + i.
    pub areal_density: *mut f32,
    /// Length through voxels of bone, mm. Only with DRR_EFFECT_BONE_PATH.
    pub bone_path_mm: *mut f32,
    /// Hears how far the call is, and may cancel it; NULL for silence. Default NULL.
    pub progress: DrrProgress,
    /// Handed to `progress`, and otherwise left alone. Default NULL.
    pub progress_data: *mut c_void,
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
    /// As DrrOutputs.
    pub progress: DrrProgress,
    /// As DrrOutputs.
    pub progress_data: *mut c_void,
}

const OUTPUTS_SIZE: usize = size_of::<[usize; 7]>();

/// What a call's outputs struct says, whatever the type of its images.
pub(super) struct Places<T> {
    pub(super) intensity: *mut T,
    pub(super) line_integral: *mut T,
    pub(super) areal_density: *mut T,
    pub(super) bone_path: *mut T,
    pub(super) progress: DrrProgress,
    pub(super) progress_data: *mut c_void,
}

/// What is the same of both structs, for which C has no generics.
macro_rules! outputs {
    ($outputs:ident, $value:ty) => {
        // SAFETY: repr(C), no padding (asserted), starts with its size; raw pointers and an optional function pointer
        // only.
        unsafe impl Options for $outputs {
            const SIZES: &'static [usize] = &[OUTPUTS_SIZE];
            fn defaults() -> Self {
                Self {
                    struct_size: size_of::<Self>(),
                    intensity: std::ptr::null_mut(),
                    line_integral: std::ptr::null_mut(),
                    areal_density: std::ptr::null_mut(),
                    bone_path_mm: std::ptr::null_mut(),
                    progress: None,
                    progress_data: std::ptr::null_mut(),
                }
            }
        }

        const _: () = assert!(size_of::<$outputs>() == OUTPUTS_SIZE);

        impl From<$outputs> for Places<$value> {
            fn from(outputs: $outputs) -> Self {
                Self {
                    intensity: outputs.intensity,
                    line_integral: outputs.line_integral,
                    areal_density: outputs.areal_density,
                    bone_path: outputs.bone_path_mm,
                    progress: outputs.progress,
                    progress_data: outputs.progress_data,
                }
            }
        }
    };
}

outputs!(DrrOutputs, f32);
outputs!(DrrReferenceOutputs, f64);

/// Checks the number of a call's views.
pub(super) fn check_views(views: usize) -> Result<()> {
    if (1..=DRR_MAX_VIEWS).contains(&views) {
        return Ok(());
    }
    Err(Error::invalid("view_count", views, format!("1 … {DRR_MAX_VIEWS}")))
}

impl<T: Copy> Places<T> {
    /// Checks the places for `views` views of a scene and says which layers are wanted.
    pub(super) fn layers(&self, scene: &Scene, views: usize) -> Result<Layers> {
        check_views(views)?;
        let (materials, signals) = (scene.materials.names().len() as u64, scene.layers() as u64);
        // At most 2^16 views of 2^30 pixels and 8 materials: no overflow in 64 bits.
        let pixels = views as u64 * (scene.detector[0] * scene.detector[1]) as u64;
        let wanted = |name: &str, place: *mut T, values: u64| {
            memory::check_optional(name, place, usize::try_from(values).unwrap_or(usize::MAX))?;
            Ok(!place.is_null())
        };
        let layers = Layers {
            intensity: wanted("outputs.intensity", self.intensity, pixels * signals)?,
            line_integral: wanted("outputs.line_integral", self.line_integral, pixels * signals)?,
            areal_density: wanted("outputs.areal_density", self.areal_density, pixels * materials)?,
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

    /// What calls the caller's progress function, for a call that casts so many rays.
    ///
    /// # Safety
    /// While the monitor lives, the function may be called as [`DrrProgress`] says.
    pub(super) unsafe fn monitor(&self, rays: usize) -> Monitor {
        // SAFETY: the caller's promise is the same.
        unsafe { Monitor::new(self.progress, self.progress_data, rays as u64) }
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
