//! What is to be simulated. Data only: a scene knows no engine.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::physics::{MassAttenuation, SpectralModel, Spectrum};

/// Largest detector side, pixels.
pub const MAX_DETECTOR: usize = 1 << 15;
/// Largest supersampling factor per side.
pub const MAX_SUPERSAMPLING: usize = 16;
/// Smallest and largest march step, voxels along the driving axis.
pub const STEP_RANGE: [f64; 2] = [1.0 / 64.0, 8.0];

/// Images are float32: the signal of a ray that meets nothing must fit.
pub(crate) fn check_i0(i0: f64) -> Result<()> {
    if !(f64::from(f32::MIN_POSITIVE)..=f64::from(f32::MAX)).contains(&i0) {
        let valid = format!("{:e} … {:e}, which float32 images can hold", f32::MIN_POSITIVE, f32::MAX);
        return Err(Error::invalid("spectrum's sum", format!("{i0:e}"), valid));
    }
    Ok(())
}

/// How the line integral through the voxels is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// One bilinear sample per slice of the driving axis (Joseph, IEEE TMI 1(3), 192, 1982).
    Joseph,
    /// Trilinear samples at equal steps, given in voxels along the driving axis.
    March {
        /// Step, voxels; see [`STEP_RANGE`].
        step: f64,
    },
    /// Exact lengths through voxels of constant value (Siddon, Med Phys 12(2), 252, 1985).
    Siddon,
    /// The interpolated field integrated exactly, cell by cell. Reference engine only.
    Exact,
}

impl Algorithm {
    /// Checks the parameters' ranges.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::March { step } if !(STEP_RANGE[0]..=STEP_RANGE[1]).contains(&step) => {
                let valid = format!("{} … {} voxels", STEP_RANGE[0], STEP_RANGE[1]);
                Err(Error::invalid("scene.step_voxels", step, valid))
            }
            _ => Ok(()),
        }
    }

    /// The name on command lines and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Joseph => "joseph",
            Self::March { .. } => "march",
            Self::Siddon => "siddon",
            Self::Exact => "exact",
        }
    }
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
    /// How line integrals are taken.
    pub algorithm: Algorithm,
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
            algorithm: Algorithm::Joseph,
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
        self.algorithm.validate()?;
        let count = self.materials.names().len();
        if let Some(bone) = self.bone.filter(|&bone| usize::from(bone) >= count) {
            return Err(Error::invalid("scene.bone_material", bone, format!("0 … {}", count - 1)));
        }
        check_i0(self.spectral_model()?.i0()).map_err(|error| error.of("scene"))
    }

    /// What turns areal densities into a signal.
    pub fn spectral_model(&self) -> Result<SpectralModel> {
        SpectralModel::new(&self.spectrum, &self.materials)
    }
}
