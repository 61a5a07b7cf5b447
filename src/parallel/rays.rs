//! Which rays count, and how long they are.

use crate::error::{Error, Result};
use crate::parallel::ParallelGeometry;
use crate::values::check_count;

/// Which rays of a view count, and which part of each; all of all, unless it says so.
#[derive(Debug, Clone, Copy, Default)]
pub struct RaySelection<'a> {
    /// One per pixel, `v*nu + u`: those that are `false` give 0 in images and take no part in losses.
    pub mask: Option<&'a [bool]>,
    /// One interval of y per pixel, mm: the part of the ray that counts. Of the step at its ends, the part inside.
    pub lengths: Option<&'a [[f64; 2]]>,
}

impl RaySelection<'_> {
    /// # Errors
    /// `InvalidArgument` for a mask or lengths that are not one per pixel, a mask without a ray, an interval that is not
    /// finite or ends before it starts.
    pub fn validate(&self, geometry: &ParallelGeometry) -> Result<()> {
        let pixels = geometry.pixels();
        if let Some(mask) = self.mask {
            check_count("mask", mask.len(), pixels, "pixel")?;
            if !mask.contains(&true) {
                return Err(Error::invalid("mask", "empty", "at least one ray that counts"));
            }
        }
        if let Some(lengths) = self.lengths {
            check_count("lengths", lengths.len(), pixels, "pixel")?;
            let bad = |[from, to]: &[f64; 2]| !(from.is_finite() && to.is_finite() && from <= to);
            if let Some(pixel) = lengths.iter().position(bad) {
                let [from, to] = lengths[pixel];
                let valid = "finite, from ≤ to, mm";
                return Err(Error::invalid(format!("lengths[{pixel}]"), format!("[{from}, {to}]"), valid));
            }
        }
        Ok(())
    }

    /// Whether a pixel's ray counts.
    pub(super) fn counts(&self, pixel: usize) -> bool {
        self.mask.is_none_or(|mask| mask[pixel])
    }

    /// The interval of y of a pixel's ray.
    pub(super) fn length(&self, pixel: usize) -> [f64; 2] {
        self.lengths.map_or([f64::NEG_INFINITY, f64::INFINITY], |lengths| lengths[pixel])
    }
}
