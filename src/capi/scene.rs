//! Scenes: what is to be simulated.

use std::ffi::c_char;

use crate::allocation::collected;
use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::memory;
use crate::capi::options::{self, Options};
use crate::capi::outputs::check_views;
use crate::capi::status::DrrStatus;
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::method::{Algorithm, Energies, Method};
use crate::physics::{DetectorResponse, EnergyGrid, MAX_MATERIALS, MassAttenuation, Spectrum};
use crate::scene::Scene;
use crate::tolerance::Tolerance;

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
    /// The error that is allowed: the root mean square of 1000 (p - p_exact) / p_exact over the rays with p above a
    /// twentieth of the largest, HU-equivalents, above 0 to 1000. The projector then takes the cheapest method that is
    /// measured to keep it, aiming at a confidence of 99 %, on rays of the expected views; algorithm, step_voxels and
    /// few_energies_hu are not read. drr_projector_describe says what was chosen and why. A volume in a texture cannot be
    /// measured: DRR_STATUS_UNSUPPORTED. Default 0: no such choice.
    pub tolerance_hu: f64,
    /// The displacement of edges that is allowed as well, root mean square, mm near the volume's centre. Only read with
    /// tolerance_hu. Default 0: it does not matter.
    pub tolerance_mm: f64,
    /// Instead of every energy, as few are summed as keep p within this error, HU-equivalents, 1e-6 to 100: a bound
    /// that is computed, not measured. DRR_STATUS_UNSUPPORTED for a volume in a texture. Default 0: every energy.
    pub few_energies_hu: f64,
    /// The views that methods are measured on, and of which areal densities are expected; others are projected as well,
    /// with an error that has not been measured. Default NULL: C-arm views all around that see the whole volume.
    pub expected_poses: *const DrrDetectorPose,
    /// Number of expected_poses, 1 to DRR_MAX_VIEWS. Not read when they are NULL. Default 0.
    pub expected_pose_count: usize,
}

/// Largest tolerance_mm.
const MOST_MM: f64 = 1e6;

const SCENE_SIZE: usize = size_of::<[usize; 10]>() + 72;

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
            tolerance_hu: 0.0,
            tolerance_mm: 0.0,
            few_energies_hu: 0.0,
            expected_poses: std::ptr::null(),
            expected_pose_count: 0,
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
            method: self.method()?,
            tolerance: self.tolerance()?,
            // SAFETY: the caller's promise is the same.
            expected_views: unsafe { self.expected_views()? },
            supersampling: self.supersampling as usize,
            bone,
        };
        let checked = scene.validate();
        checked.map_err(|error| error.called("scene.expected_views", "scene.expected_poses")).map(|()| scene)
    }

    /// Not read where a tolerance is stated.
    fn method(&self) -> Result<Method> {
        if self.tolerance_hu != 0.0 {
            return Ok(Algorithm::Joseph.into());
        }
        let algorithm = algorithm(self.algorithm, self.step_voxels).map_err(|error| error.of("scene"))?;
        let energies = match self.few_energies_hu {
            0.0 => Energies::All,
            hu => Energies::Few { hu },
        };
        Ok(Method { energies, ..algorithm.into() })
    }

    fn tolerance(&self) -> Result<Option<Tolerance>> {
        if self.tolerance_hu == 0.0 {
            return Ok(None);
        }
        let mm = match self.tolerance_mm {
            0.0 => f64::INFINITY,
            mm if mm > 0.0 && mm <= MOST_MM => mm,
            mm => {
                let valid = format!("0 (does not matter) … {MOST_MM:e} mm");
                return Err(Error::invalid("scene.tolerance_mm", mm, valid));
            }
        };
        Ok(Some(Tolerance { hu: self.tolerance_hu, mm }))
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn expected_views(&self) -> Result<Vec<View>> {
        if self.expected_poses.is_null() {
            return Ok(Vec::new());
        }
        let count = self.expected_pose_count;
        check_views(count).map_err(|error| error.called("view_count", "scene.expected_pose_count"))?;
        // SAFETY: by the caller's promise there are as many poses.
        let poses = unsafe { memory::read_array("scene.expected_poses", self.expected_poses, count)? };
        collected(poses.iter().map(|pose| View::Pose(pose.into())), "the expected views")
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

/// States a tolerance by its name: "draft", 10 HU and 1 mm; "standard", the specification's 2 HU and 0.2 mm; "reference",
/// 0.1 HU and 0.01 mm. Writes tolerance_hu and tolerance_mm of `*scene`, which drr_scene_init has filled, on success
/// only. Fails with DRR_STATUS_INVALID_ARGUMENT. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_scene_set_preset(scene: *mut DrrScene, name: *const c_char) -> DrrStatus {
    guard(|| {
        // SAFETY: the C caller passes a struct of the size that it says.
        let mut changed = unsafe { options::read("scene", scene)? };
        // SAFETY: the C caller passes a string.
        let name = unsafe { memory::read_text("name", name)? };
        let Tolerance { hu, mm } = Tolerance::preset(name).map_err(|error| error.called("preset", "name"))?;
        (changed.tolerance_hu, changed.tolerance_mm) = (hu, mm);
        // SAFETY: `read` has seen that there is a struct of today's size.
        unsafe { scene.write(changed) };
        Ok(())
    })
}
