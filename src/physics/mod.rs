//! Photons and matter: energies, tube spectra, attenuation, detector response, HU curves. Tables with their sources
//! are in `tables/`; coefficients are cm²/g, densities g/cm³, areal densities g/cm², energies keV.
//!
//! The march through a volume gives one areal density per material; [`SpectralModel`] turns them into a signal:
//!
//! ```
//! use drr::physics::{DetectorResponse, EnergyGrid, MassAttenuation, SpectralModel, Spectrum};
//!
//! let grid = EnergyGrid::SPECIFICATION;
//! let tube = Spectrum::named(Spectrum::DEFAULT, grid)?;
//! let detected = tube.folded(&DetectorResponse::named("top_energy", grid)?)?;
//! let attenuation = MassAttenuation::named(&MassAttenuation::SPECIFICATION, grid)?;
//! let model = SpectralModel::new(&detected, &attenuation)?;
//! // 200 mm of soft tissue (ρ 1.06 g/cm³): 20 cm × 1.06 g/cm³.
//! let line_integral = model.line_integral(&[0.0, 0.0, 21.2, 0.0]);
//! assert!(line_integral > 3.0 && line_integral < 6.0);
//! # Ok::<(), drr::Error>(())
//! ```

mod attenuation;
mod calibration;
mod detector;
mod energy;
mod material;
mod model;
mod quadrature;
mod scattering;
mod spectrum;
mod tables;
mod thresholds;

pub(crate) use attenuation::MAX_ATTENUATION;
pub use attenuation::{MAX_MATERIALS, MassAttenuation};
pub use calibration::{Calibration, DensitySegment, MAX_HU, MIN_HU};
pub use detector::DetectorResponse;
pub use energy::{EnergyGrid, MAX_ENERGIES};
pub use material::Material;
pub use model::SpectralModel;
pub use quadrature::{Node, Quadrature};
pub(crate) use scattering::{Coefficients, Incoherent, Interactions};
pub use spectrum::Spectrum;
pub use thresholds::Thresholds;
