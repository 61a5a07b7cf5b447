//! The error that a caller can live with.

use serde::Serialize;

use crate::error::{Error, Result};

/// Largest errors of the line integrals of a scene's rays, against the exact integral of the interpolated voxels with
/// every energy. The planner buys the cheapest method that keeps both.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Tolerance {
    /// Root mean square of 1000 (p − `p_ref`)/`p_ref` over the rays above a twentieth of the largest p, HU-equivalents.
    pub hu: f64,
    /// Root mean square of the displacement of edges that would explain the error, mm near the volume's centre; infinite
    /// where it does not matter.
    pub mm: f64,
}

impl Tolerance {
    /// For looking at a scene while it is set up.
    pub const DRAFT: Self = Self { hu: 10.0, mm: 1.0 };
    /// The specification's: 2 HU and 0.2 mm.
    pub const STANDARD: Self = Self { hu: 2.0, mm: 0.2 };
    /// A twentieth of the specification's: what is left is far below the noise of any scan.
    pub const REFERENCE: Self = Self { hu: 0.1, mm: 0.01 };

    /// The presets by name.
    pub const PRESETS: [(&str, Self); 3] =
        [("draft", Self::DRAFT), ("standard", Self::STANDARD), ("reference", Self::REFERENCE)];

    /// A preset by its name.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown one, with all names.
    pub fn preset(name: &str) -> Result<Self> {
        let known = Self::PRESETS.into_iter().find(|(own, _)| *own == name);
        let names = Self::PRESETS.map(|(name, _)| name).join(", ");
        known.map(|(_, tolerance)| tolerance).ok_or_else(|| Error::invalid("preset", name, names))
    }

    /// HU alone.
    pub fn hu(hu: f64) -> Self {
        Self { hu, mm: f64::INFINITY }
    }

    /// Checks the ranges.
    pub fn validate(self) -> Result<()> {
        if !(self.hu > 0.0 && self.hu <= 1000.0) {
            return Err(Error::invalid("scene.tolerance_hu", self.hu, "above 0, at most 1000 HU"));
        }
        if !(self.mm > 0.0) {
            return Err(Error::invalid("scene.tolerance_mm", self.mm, "above 0 mm"));
        }
        Ok(())
    }
}

impl std::fmt::Display for Tolerance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.hu < 1e-3 {
            write!(f, "{:e} HU", self.hu)?;
        } else {
            write!(f, "{} HU", self.hu)?;
        }
        if self.mm.is_finite() { write!(f, ", {} mm", self.mm) } else { Ok(()) }
    }
}
