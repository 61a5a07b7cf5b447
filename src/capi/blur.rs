//! The spread of the signal within the detector.

use crate::capi::memory;
use crate::capi::names;
use crate::capi::scene::DrrScene;
use crate::effects::{DetectorBlur, MAX_BLUR_COMPONENTS, MAX_MTF_POINTS};
use crate::error::{Error, Result};

/// Largest difference of a measured MTF from the Gaussians that stand for it.
const MOST_OFF: f64 = 0.05;

/// A Gaussian of a detector's point spread. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrBlurComponent {
    /// Its share, above 0 to 1; all sum to 1, to 1e-6.
    pub weight: f64,
    /// Its standard deviation along each axis, mm on the detector, 0 to 100; 0: what is not blurred.
    pub sigma_mm: f64,
}

impl DrrScene {
    /// By Gaussians or by a curve.
    ///
    /// # Safety
    /// As for [`Self::read`].
    pub(super) unsafe fn detector_blur(&self) -> Result<Option<DetectorBlur>> {
        if !self.mtf_frequencies_per_mm.is_null() {
            // SAFETY: the caller's promise is the same.
            return unsafe { self.blur_of_curve() }.map(Some);
        }
        if self.blur.is_null() {
            return Ok(None);
        }
        check_count("scene.blur_count", self.blur_count, 1, MAX_BLUR_COMPONENTS)?;
        // SAFETY: by the caller's promise there are as many.
        let parts = unsafe { memory::read_array("scene.blur", self.blur, self.blur_count)? };
        let parts: Vec<_> = parts.iter().map(|part| (part.weight, part.sigma_mm)).collect();
        DetectorBlur::gaussians(&parts).map(Some).map_err(names::in_c)
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn blur_of_curve(&self) -> Result<DetectorBlur> {
        if !self.blur.is_null() {
            let valid = "NULL, because blur is given: by Gaussians or by a curve";
            return Err(Error::invalid("scene.mtf_frequencies_per_mm", "not NULL", valid));
        }
        check_count("scene.mtf_count", self.mtf_count, 2, MAX_MTF_POINTS)?;
        // SAFETY: by the caller's promise there are as many points.
        let (frequencies, mtf) = unsafe {
            (
                memory::read_array(
                    "scene.mtf_frequencies_per_mm",
                    self.mtf_frequencies_per_mm,
                    self.mtf_count,
                )?,
                memory::read_array("scene.mtf", self.mtf, self.mtf_count)?,
            )
        };
        let (blur, off) = DetectorBlur::curve(frequencies, mtf).map_err(names::in_c)?;
        if off > MOST_OFF {
            let valid = format!("a curve that Gaussians follow to {MOST_OFF}; or Gaussians, as blur");
            return Err(Error::invalid("scene.mtf's distance from Gaussians", off, valid));
        }
        Ok(blur)
    }
}

/// Checks the length of an array before it is read.
fn check_count(argument: &str, count: usize, least: usize, most: usize) -> Result<()> {
    if (least..=most).contains(&count) {
        return Ok(());
    }
    Err(Error::invalid(argument, count, format!("{least} … {most}")))
}
