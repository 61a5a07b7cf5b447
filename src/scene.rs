//! What is to be simulated. Data only: a scene knows no engine.

use crate::effects::Effects;
use crate::engine::Layers;
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::method::{Algorithm, Method};
use crate::physics::{DetectorResponse, MassAttenuation, SpectralModel, Spectrum};
use crate::tolerance::Tolerance;

/// Largest detector side, pixels.
pub const MAX_DETECTOR: usize = 1 << 15;
/// Largest supersampling factor per side.
pub const MAX_SUPERSAMPLING: usize = 16;
/// Most layers of a detector.
pub const MAX_DETECTOR_LAYERS: usize = 2;

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
    /// Relative photons per energy bin that leave the source. One bin: monoenergetic.
    pub spectrum: Spectrum,
    /// What each layer of the detector makes of a photon, on the spectrum's grid: one, or both of a dual-layer detector,
    /// whose images come of one march; none: one layer that counts every photon. A layer's I0, the sum of spectrum times
    /// response, must be a normal float32.
    pub detector_layers: Vec<DetectorResponse>,
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
    /// What happens to the X-rays beside attenuation by the volume. Nothing, unless it says so.
    pub effects: Effects,
}

impl Scene {
    /// The specification's scene for a detector of `size` = width × height: 120 kVp, ideal detector, the four
    /// materials, Joseph, one ray per pixel.
    pub fn new(size: [usize; 2]) -> Result<Self> {
        let spectrum = Spectrum::named(Spectrum::DEFAULT, crate::physics::EnergyGrid::SPECIFICATION)?;
        let materials = MassAttenuation::named(&MassAttenuation::SPECIFICATION, *spectrum.grid())?;
        let scene = Self {
            detector: size,
            detector_layers: Vec::new(),
            spectrum,
            materials,
            method: Algorithm::Joseph.into(),
            tolerance: None,
            expected_views: Vec::new(),
            supersampling: 1,
            bone: Some(3),
            effects: Effects::default(),
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
        let layers = self.detector_layers.len();
        if layers > MAX_DETECTOR_LAYERS {
            let valid = format!("0 … {MAX_DETECTOR_LAYERS}");
            return Err(Error::invalid("scene.detector_layers", format!("{layers} responses"), valid));
        }
        for layer in 0..self.layers() {
            check_i0(self.detected(layer)?.total()).map_err(|error| error.of("scene"))?;
        }
        self.spectral_model()?;
        self.effects.validate(self)
    }

    /// The same scene without effects, computed in another way.
    #[must_use]
    pub(crate) fn with_method(&self, method: Method) -> Self {
        Self { method, tolerance: None, ..self.without_effects() }
    }

    /// What the first detector layer sees where nothing but the volume is in the way.
    #[must_use]
    pub(crate) fn without_effects(&self) -> Self {
        let detector_layers = self.detector_layers.iter().take(1).cloned().collect();
        Self { detector_layers, effects: Effects::default(), ..self.clone() }
    }

    /// One ray per pixel of a detector of another size, without effects.
    #[must_use]
    pub(crate) fn of_rays(&self, detector: [usize; 2]) -> Self {
        Self { detector, supersampling: 1, ..self.without_effects() }
    }

    /// Columns and rows of the rays of all pixels.
    pub(crate) fn ray_grid(&self) -> [usize; 2] {
        self.detector.map(|side| side * self.supersampling)
    }

    /// Whether images need more than one signal per ray.
    pub(crate) fn has_effects(&self) -> bool {
        self.detector_layers.len() > 1 || self.effects != Effects::default()
    }

    /// # Errors
    /// `InvalidArgument` for a layer of images that the scene does not have.
    pub(crate) fn check_layers(&self, layers: Layers) -> Result<()> {
        if layers.bone_path && self.bone.is_none() {
            let valid = "only when the scene says which material is bone";
            return Err(Error::invalid("bone_path", "asked for", valid));
        }
        Ok(())
    }

    /// Number of the detector's layers, at least 1.
    pub fn layers(&self) -> usize {
        self.detector_layers.len().max(1)
    }

    /// The spectrum as a detector layer, one of `layers()`, weights it; its total is the layer's I0.
    ///
    /// # Errors
    /// `InvalidArgument` when the two have other energies, or nothing is left.
    pub fn detected(&self, layer: usize) -> Result<Spectrum> {
        match self.detector_layers.get(layer) {
            Some(response) => self.spectrum.folded(response),
            None => Ok(self.spectrum.clone()),
        }
    }

    /// What turns areal densities into the signal of the first detector layer.
    pub fn spectral_model(&self) -> Result<SpectralModel> {
        SpectralModel::new(&self.detected(0)?, &self.materials)
    }
}
