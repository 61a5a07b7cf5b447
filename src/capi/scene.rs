//! Scenes: what is to be simulated.

use crate::allocation::collected;
use crate::capi::boundary::guard;
use crate::capi::memory;
use crate::capi::options::{self, Options};
use crate::capi::status::DrrStatus;
use crate::error::{Error, Result};
use crate::method::Algorithm;
use crate::physics::{DetectorResponse, EnergyGrid, MAX_MATERIALS, MassAttenuation, Spectrum};
use crate::scene::Scene;

/// What a scene simulates: DRR_EFFECT bits. Unknown bits are refused.
pub type DrrEffects = u32;

/// All energies of the spectrum are summed. Without it everything happens at mono_energy_kev.
pub const DRR_EFFECT_POLYENERGETIC: DrrEffects = 1 << 0;
/// The bone path can be asked for as an output.
pub const DRR_EFFECT_BONE_PATH: DrrEffects = 1 << 1;

/// How line integrals through the voxels are taken: one of the DRR_ALGORITHM constants. Other values are refused.
pub type DrrAlgorithm = u32;

/// One bilinear sample per slice of the driving axis (Joseph 1982).
pub const DRR_ALGORITHM_JOSEPH: DrrAlgorithm = 0;
/// Trilinear samples, step_voxels apart.
pub const DRR_ALGORITHM_MARCH: DrrAlgorithm = 1;
/// Exact lengths through voxels of constant value (Siddon 1985).
pub const DRR_ALGORITHM_SIDDON: DrrAlgorithm = 2;
/// The trilinear field integrated exactly. DRR_BACKEND_REFERENCE and drr_reference_project only.
pub const DRR_ALGORITHM_EXACT: DrrAlgorithm = 3;

/// What is to be simulated. Fill it with drr_scene_init, then set the detector's size and what else should differ.
/// The tables are only read during drr_projector_create.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrScene {
    /// Set by drr_scene_init.
    pub struct_size: usize,
    /// Pixels per row, 1 to 32768. Default 0, which is refused.
    pub detector_width: usize,
    /// Rows, 1 to 32768. Default 0, which is refused.
    pub detector_height: usize,
    /// Relative photons per energy: energy_count values, finite, at least 0. Their sum, after the detector's response,
    /// is the intensity of a ray that meets nothing, 1.2e-38 to 3.4e38. Default NULL: tungsten at 120 kVp, sum 1.
    pub spectrum: *const f32,
    /// Factor by which the detector weights a photon of each energy: energy_count values, finite, at least 0.
    /// Default NULL: 1.
    pub detector_response: *const f32,
    /// Mass attenuation coefficients, cm²/g: that of material m at energy k is at m × energy_count + k. 0 to 1e9.
    /// Material m is what has label m in the volume. Default NULL: air, lung, soft tissue, cortical bone.
    pub mass_attenuation: *const f32,
    /// Materials of mass_attenuation, 1 to 8. Default 4, which it must be when mass_attenuation is NULL.
    pub material_count: usize,
    /// Energies, 1 to 4096. Default 136.
    pub energy_count: usize,
    /// The first energy, keV, above 0; the last is at most 1e6. Default 15. Built-in tables hold whole energies from
    /// 15 to 150 keV and are not interpolated.
    pub first_energy_kev: f64,
    /// From one energy to the next, keV, 1e-6 to 1e6. Default 1.
    pub energy_step_kev: f64,
    /// The energy of every photon, keV, when DRR_EFFECT_POLYENERGETIC is not set; must be one of the energies.
    /// Spectrum and detector response are then not read, and a ray that meets nothing has intensity 1. Default 70.
    pub mono_energy_kev: f64,
    /// Distance of samples for DRR_ALGORITHM_MARCH, voxels along the driving axis, 1/64 to 8. Not read for other
    /// algorithms. Default 0.5.
    pub step_voxels: f64,
    /// DRR_EFFECT bits. Default DRR_EFFECT_POLYENERGETIC.
    pub effects: DrrEffects,
    /// Default DRR_ALGORITHM_JOSEPH.
    pub algorithm: DrrAlgorithm,
    /// n × n rays per pixel, 1 to 16, whose intensities are averaged. Default 1.
    pub supersampling: u32,
    /// The label of bone, below material_count. Only read with DRR_EFFECT_BONE_PATH. Default 3.
    pub bone_material: u32,
}

const SCENE_SIZE: usize = size_of::<[usize; 8]>() + 48;

// SAFETY: repr(C), no padding (asserted), starts with its size; numbers and raw pointers only.
unsafe impl Options for DrrScene {
    const SIZES: &'static [usize] = &[SCENE_SIZE];
    fn defaults() -> Self {
        let grid = EnergyGrid::SPECIFICATION;
        Self {
            struct_size: size_of::<Self>(),
            detector_width: 0,
            detector_height: 0,
            spectrum: std::ptr::null(),
            detector_response: std::ptr::null(),
            mass_attenuation: std::ptr::null(),
            material_count: MassAttenuation::SPECIFICATION.len(),
            energy_count: grid.count(),
            first_energy_kev: grid.first_kev(),
            energy_step_kev: grid.step_kev(),
            mono_energy_kev: 70.0,
            step_voxels: 0.5,
            effects: DRR_EFFECT_POLYENERGETIC,
            algorithm: DRR_ALGORITHM_JOSEPH,
            supersampling: 1,
            bone_material: 3,
        }
    }
}

const _: () = assert!(size_of::<DrrScene>() == SCENE_SIZE);

/// An algorithm by its constant; `step` is for the march, and not checked here.
pub(super) fn algorithm(code: DrrAlgorithm, step: f64) -> Result<Algorithm> {
    match code {
        DRR_ALGORITHM_JOSEPH => Ok(Algorithm::Joseph),
        DRR_ALGORITHM_MARCH => Ok(Algorithm::March { step }),
        DRR_ALGORITHM_SIDDON => Ok(Algorithm::Siddon),
        DRR_ALGORITHM_EXACT => Ok(Algorithm::Exact),
        _ => Err(Error::invalid("algorithm", code, "one of the DRR_ALGORITHM constants, 0 … 3")),
    }
}

/// `values` as float64.
pub(super) fn widened(values: &[f32]) -> Result<Vec<f64>> {
    collected(values.iter().copied().map(f64::from), "a spectral table")
}

/// Names for the materials of a caller's table.
pub(super) fn material_names(count: usize) -> Vec<String> {
    (0..count).map(|m| format!("material {m}")).collect()
}

impl DrrScene {
    pub(super) fn is_polyenergetic(&self) -> bool {
        self.effects & DRR_EFFECT_POLYENERGETIC != 0
    }

    /// The energies of the tables.
    pub(super) fn energies(&self) -> Result<EnergyGrid> {
        EnergyGrid::new(self.first_energy_kev, self.energy_step_kev, self.energy_count)
            .map_err(|error| error.of("scene"))
    }

    /// The scene, with copies of the caller's tables.
    ///
    /// # Safety
    /// The pointers are null or as the fields' descriptions say.
    pub(super) unsafe fn read(&self) -> Result<Scene> {
        let known = DRR_EFFECT_POLYENERGETIC | DRR_EFFECT_BONE_PATH;
        if self.effects & !known != 0 {
            let value = format!("{:#x}", self.effects);
            return Err(Error::invalid("scene.effects", value, format!("DRR_EFFECT bits, {known:#x}, only")));
        }
        let energies = self.energies()?;
        // SAFETY: the caller's promise is the same.
        let (spectrum, materials) = unsafe { (self.spectrum(energies)?, self.materials(energies)?) };
        let bone = if self.effects & DRR_EFFECT_BONE_PATH == 0 {
            None
        } else {
            let last = materials.names().len() - 1;
            let refused =
                |_| Error::invalid("scene.bone_material", self.bone_material, format!("0 … {last}"));
            Some(u8::try_from(self.bone_material).map_err(refused)?)
        };
        let scene = Scene {
            detector: [self.detector_width, self.detector_height],
            spectrum,
            materials,
            method: algorithm(self.algorithm, self.step_voxels).map_err(|error| error.of("scene"))?.into(),
            tolerance: None,
            expected_views: Vec::new(),
            supersampling: self.supersampling as usize,
            bone,
        };
        scene.validate().map(|()| scene)
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn spectrum(&self, energies: EnergyGrid) -> Result<Spectrum> {
        if !self.is_polyenergetic() {
            self.mono_energy(energies)?;
            return Spectrum::monoenergetic(self.mono_energy_kev);
        }
        // SAFETY: by the caller's promise these are null or have one value per energy.
        let (spectrum, response) = unsafe {
            (
                memory::read_optional("scene.spectrum", self.spectrum, self.energy_count)?,
                memory::read_optional("scene.detector_response", self.detector_response, self.energy_count)?,
            )
        };
        let spectrum = match spectrum {
            Some(weights) => Spectrum::new("the caller's spectrum", energies, widened(weights)?),
            None => Spectrum::named(Spectrum::DEFAULT, energies),
        };
        let folded = |spectrum: Spectrum| match response {
            Some(factors) => {
                let response = DetectorResponse::new("the caller's detector", energies, widened(factors)?)?;
                spectrum.folded(&response)
            }
            None => Ok(spectrum),
        };
        spectrum.and_then(folded).map_err(|error| error.of("scene"))
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn materials(&self, energies: EnergyGrid) -> Result<MassAttenuation> {
        let count = self.material_count;
        let built_in = MassAttenuation::SPECIFICATION;
        if self.mass_attenuation.is_null() {
            if count != built_in.len() {
                let valid = format!("{} when mass_attenuation is NULL", built_in.len());
                return Err(Error::invalid("scene.material_count", count, valid));
            }
            if self.is_polyenergetic() {
                return MassAttenuation::named(&built_in, energies).map_err(|error| error.of("scene"));
            }
            return MassAttenuation::named(&built_in, EnergyGrid::single(self.mono_energy_kev)?)
                .map_err(|error| error.called(&EnergyGrid::argument(0), "scene.mono_energy_kev"));
        }
        if !(1..=MAX_MATERIALS).contains(&count) {
            return Err(Error::invalid("scene.material_count", count, format!("1 … {MAX_MATERIALS}")));
        }
        // SAFETY: by the caller's promise there is one value per material and energy.
        let values = unsafe {
            memory::read_array("scene.mass_attenuation", self.mass_attenuation, count * energies.count())?
        };
        let table = MassAttenuation::new(energies, material_names(count), widened(values)?)
            .map_err(|error| error.of("scene"))?;
        if self.is_polyenergetic() {
            return Ok(table);
        }
        let bin = self.mono_energy(energies)?;
        let column = (0..count).map(|m| table.coefficients(m)[bin]).collect();
        MassAttenuation::new(EnergyGrid::single(self.mono_energy_kev)?, material_names(count), column)
    }

    /// The bin of `mono_energy_kev`.
    fn mono_energy(&self, energies: EnergyGrid) -> Result<usize> {
        energies.index_of(self.mono_energy_kev).ok_or_else(|| {
            Error::invalid("scene.mono_energy_kev", self.mono_energy_kev, format!("one of {energies}"))
        })
    }
}

/// Fills `*scene` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_scene_init(scene: *mut DrrScene) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("scene", scene) })
}
