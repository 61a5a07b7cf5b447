//! Where the object and the detector are.

use super::obliquity::Obliquity;
use crate::error::{Error, Result};

/// Distances along the central ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Beamline {
    /// From the source to the centre of the volume, mm.
    pub(crate) source_centre_mm: f64,
    /// From the source to the detector, mm.
    pub(crate) source_detector_mm: f64,
}

impl Beamline {
    /// # Errors
    /// `InvalidArgument` unless both are finite and above 0.
    pub(crate) fn validate(&self) -> Result<()> {
        let distances =
            [("source_centre_mm", self.source_centre_mm), ("source_detector_mm", self.source_detector_mm)];
        for (name, mm) in distances {
            if !(mm > 0.0 && mm.is_finite()) {
                return Err(Error::invalid(
                    format!("scene.effects.scatter.{name}"),
                    mm,
                    "above 0, finite, mm",
                ));
            }
        }
        Ok(())
    }

    /// The same to half a percent: on a grid whose steps are one percent.
    pub(super) fn rounded(self) -> Self {
        let rounded = |mm: f64| (0.01 * (mm.ln() / 0.01).round()).exp();
        Self {
            source_centre_mm: rounded(self.source_centre_mm),
            source_detector_mm: rounded(self.source_detector_mm),
        }
    }

    /// The corrections of a signal with that attenuation, cm²/g.
    pub(super) fn obliquity(&self, attenuation: f64) -> Obliquity {
        Obliquity {
            gap_mm: self.source_detector_mm - self.source_centre_mm,
            magnification: self.source_detector_mm / self.source_centre_mm,
            attenuation,
        }
    }

    /// From the exit of a slab around the volume's centre to the detector, mm; 0, contact, where the slab would reach
    /// through the detector.
    pub(super) fn gap_mm(&self, thickness_mm: f64) -> f64 {
        (self.source_detector_mm - self.source_centre_mm - 0.5 * thickness_mm).max(0.0)
    }
}
