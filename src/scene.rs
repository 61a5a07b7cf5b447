//! What is to be simulated. Data only: a scene knows no engine.

use crate::error::{Error, Result};
use crate::geometry::View;
use crate::method::{Algorithm, Method};
use crate::physics::{MassAttenuation, SpectralModel, Spectrum};
use crate::tolerance::Tolerance;

/// Largest detector side, pixels.
pub const MAX_DETECTOR: usize = 1 << 15;
/// Largest supersampling factor per side.
pub const MAX_SUPERSAMPLING: usize = 16;

/// Images are float32: the signal of a ray that meets nothing must fit.
pub(crate) fn check_i0(i0: f64) -> Result<()> {
    if !(f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&i0) {
        let valid = format!("{:e} … {:e}, which float32 images can hold", f32::MIN_POSITIVE, f32::MAX);
        return Err(Error::invalid("spectrum's sum", format!("{i0:e}"), valid));
    }
    Ok(())
}

/// What is to be simulated, and how exactly rays are cast.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Width and height, pixels.
    pub detector: [usize; 2],
    /// Relative photons per energy bin, with the detector's response already folded in; their sum, I0, must be a normal
    /// float32. One bin: monoenergetic.
    pub spectrum: Spectrum,
    /// Mass attenuation coefficients; the material at index m has label m. On the spectrum's grid.
    pub materials: MassAttenuation,
    /// How it is computed, unless a tolerance is stated.
    pub method: Method,
    /// The error that is allowed: the planner chooses the method. `None`: `method` is what runs.
    pub tolerance: Option<Tolerance>,
    /// The views on which methods are measured; none: C-arm views all around the volume that see all of it.
    pub expected_views: Vec<View>,
    /// n×n rays per pixel, their intensities averaged; 1 is one ray through the pixel's centre.
    pub supersampling: usize,
    /// The label whose path length the `bone_path` layer measures; `None`: the layer cannot be asked for.
    pub bone: Option<u8>,
}

impl Scene {
    /// The specification's scene for a detector of `size` = width × height: 120 kVp, ideal detector, the four
    /// materials, Joseph, one ray per pixel.
    pub fn new(size: [usize; 2]) -> Result<Self> {
        let spectrum = Spectrum::named(Spectrum::DEFAULT, crate::physics::EnergyGrid::SPECIFICATION)?;
        let materials = MassAttenuation::named(&MassAttenuation::SPECIFICATION, *spectrum.grid())?;
        let scene = Self {
            detector: size,
            spectrum,
            materials,
            method: Algorithm::Joseph.into(),
            tolerance: None,
            expected_views: Vec::new(),
            supersampling: 1,
            bone: Some(3),
        };
        scene.validate().map(|()| scene)
    }

    /// Checks every range and that the parts fit together.
    pub fn validate(&self) -> Result<()> {
        for (name, n) in ["scene.detector_width", "scene.detector_height"].into_iter().zip(self.detector) {
            if n == 0 || n > MAX_DETECTOR {
                return Err(Error::invalid(name, n, format!("1 … {MAX_DETECTOR} pixels")));
            }
        }
        if self.supersampling == 0 || self.supersampling > MAX_SUPERSAMPLING {
            return Err(Error::invalid(
                "scene.supersampling",
                self.supersampling,
                format!("1 … {MAX_SUPERSAMPLING}"),
            ));
        }
        self.method.validate()?;
        self.tolerance.map_or(Ok(()), Tolerance::validate)?;
        for (v, view) in self.expected_views.iter().enumerate() {
            view.validate().map_err(|error| error.of(&format!("scene.expected_views[{v}]")))?;
        }
        let count = self.materials.names().len();
        if let Some(bone) = self.bone.filter(|&bone| usize::from(bone) >= count) {
            return Err(Error::invalid("scene.bone_material", bone, format!("0 … {}", count - 1)));
        }
        check_i0(self.spectral_model()?.i0()).map_err(|error| error.of("scene"))
    }

    /// The same scene, computed in another way.
    #[must_use]
    pub(crate) fn with_method(&self, method: Method) -> Self {
        Self { method, tolerance: None, ..self.clone() }
    }

    /// What turns areal densities into a signal.
    pub fn spectral_model(&self) -> Result<SpectralModel> {
        SpectralModel::new(&self.spectrum, &self.materials)
    }
}
