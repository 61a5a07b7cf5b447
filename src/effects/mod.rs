//! What happens to X-rays beside attenuation by the CT: one file per effect, each with its physics and its source. A scene
//! asks for none unless it says so, and what is not asked for is not computed.
//!
//! A photon meets them in this order, and so does an image: what lies before the volume (fall-off, heel, filters), volume and
//! implants, the focal spot's extent, scatter, detector blur, the pixel's active area, noise.

mod aperture;
mod convolution;
mod detector_blur;
mod fall_off;
mod filter;
mod focal_spot;
mod heel;
mod implant;
mod mtf_curve;
mod noise;
mod plane;
mod scatter;
mod sight;
mod taps;

pub use aperture::FillFactor;
pub use detector_blur::{BlurComponent, DetectorBlur, MAX_BLUR_COMPONENTS};
pub use filter::{Filter, MAX_BOW_TIE_POINTS, Profile};
pub use focal_spot::FocalSpot;
pub use heel::Heel;
pub use implant::{Implant, ImplantShape, MAX_SCREW_SECTIONS, Section};
pub use mtf_curve::MAX_MTF_POINTS;
pub use noise::{Noise, PhotonNoise};
pub use scatter::Scatter;

pub(crate) use convolution::convolved;
pub(crate) use fall_off::fall_off;
pub(crate) use implant::pieces;
pub(crate) use noise::RowRandom;
pub(crate) use plane::Plane;
pub(crate) use scatter::{Beamline, ScatterCache, ScatterKernels};
pub(crate) use sight::{Sight, Sights};
pub(crate) use taps::Taps;

use crate::error::{Error, Result};
use crate::scene::Scene;

/// Most filters, and most implants, of one scene.
pub const MAX_EFFECT_PARTS: usize = 64;

/// What a scene asks for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Effects {
    /// Inverse-square and obliquity fall-off of the intensity towards the detector's edges.
    pub fall_off: bool,
    /// Filtration by the anode itself.
    pub heel: Option<Heel>,
    /// Slabs and bow-ties between source and volume; the spectrum is that before them.
    pub filters: Vec<Filter>,
    /// What counts instead of the volume where it is; the last one where several are.
    pub implants: Vec<Implant>,
    /// The source's extent.
    pub focal_spot: Option<FocalSpot>,
    /// Scattered radiation.
    pub scatter: Option<Scatter>,
    /// The spread of the signal within the detector.
    pub detector_blur: Option<DetectorBlur>,
    /// The part of a pixel that is active; `None`: all of it, around a single ray through its centre.
    pub fill_factor: Option<FillFactor>,
    /// Quantum and electronic noise.
    pub noise: Option<Noise>,
}

impl Effects {
    /// Whether every pixel sees the same source.
    pub(crate) fn is_even_source(&self) -> bool {
        !self.fall_off && self.heel.is_none() && self.filters.is_empty()
    }

    /// Checks every range, and that the parts fit the scene.
    pub(crate) fn validate(&self, scene: &Scene) -> Result<()> {
        for (name, count) in [("filters", self.filters.len()), ("implants", self.implants.len())] {
            if count > MAX_EFFECT_PARTS {
                return Err(Error::invalid(
                    format!("scene.effects.{name}"),
                    format!("{count} parts"),
                    format!("at most {MAX_EFFECT_PARTS}"),
                ));
            }
        }
        let grid = scene.spectrum.grid();
        if let Some(heel) = &self.heel {
            heel.validate()?;
            Heel::anode(*grid)?;
        }
        for (n, filter) in self.filters.iter().enumerate() {
            filter.validate(grid).map_err(|error| error.of(&format!("scene.effects.filters[{n}]")))?;
        }
        for (n, implant) in self.implants.iter().enumerate() {
            implant.validate(scene.materials.names().len(), n)?;
        }
        self.focal_spot.map_or(Ok(()), FocalSpot::validate)?;
        if let Some(scatter) = &self.scatter {
            scatter.validate()?;
            ScatterKernels::check_energies(&scene.spectrum)?;
        }
        self.detector_blur.as_ref().map_or(Ok(()), DetectorBlur::validate)?;
        self.fill_factor.map_or(Ok(()), FillFactor::validate)?;
        let Some(noise) = &self.noise else { return Ok(()) };
        noise.validate()?;
        for (layer, response) in scene.detector_layers.iter().enumerate() {
            crate::exposure::known_efficiency(response, layer)?;
        }
        Ok(())
    }
}
