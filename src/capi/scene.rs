//! Scenes: what is to be simulated.

use std::ffi::c_char;

use crate::allocation::collected;
use crate::capi::blur::DrrBlurComponent;
use crate::capi::boundary::guard;
use crate::capi::effects::{DRR_EFFECT_BONE_PATH, DRR_EFFECT_POLYENERGETIC, DrrEffects};
use crate::capi::filter::DrrFilter;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::implant::DrrImplant;
use crate::capi::options::{self, Options};
use crate::capi::outputs::check_views;
use crate::capi::status::DrrStatus;
use crate::capi::{memory, names};
use crate::effects::{Heel, Scatter};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::method::{Algorithm, Energies, Method};
use crate::physics::{EnergyGrid, MassAttenuation};
use crate::scene::Scene;
use crate::tolerance::Tolerance;

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
/// Mean of the voxels of each slice of the driving axis that the pixel covers (De Man and Basu 2004). DRR_BACKEND_REFERENCE,
/// DRR_BACKEND_CPU and drr_reference_project only.
pub const DRR_ALGORITHM_DISTANCE_DRIVEN: DrrAlgorithm = 4;

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
    /// Default NULL: 1. Of a detector of two layers that of the first one.
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
    /// Probability that the detector detects a photon of each energy at all: energy_count values, 0 to 1, above 0 where
    /// detector_response is. A photon that is detected adds detector_response / detector_efficiency to the signal; both
    /// the same is a detector that counts photons. Must be NULL when detector_response is: each photon counts. Default
    /// NULL: not known, which noise refuses beside a detector_response.
    pub detector_efficiency: *const f32,
    /// As detector_response, of a second layer of the detector: there are two images then, of one march. Not read without
    /// DRR_EFFECT_POLYENERGETIC. Default NULL: one layer.
    pub second_detector_response: *const f32,
    /// As detector_efficiency, of the second layer. Default NULL.
    pub second_detector_efficiency: *const f32,
    /// What the photons pass between tube and volume; the spectrum is that before. Default NULL: nothing.
    pub filters: *const DrrFilter,
    /// Number of filters, 1 to 64. Not read when they are NULL. Default 0.
    pub filter_count: usize,
    /// Solids that are there instead of the volume; where several are the last one counts. Default NULL: none.
    pub implants: *const DrrImplant,
    /// Number of implants, 1 to 64. Not read when they are NULL. Default 0.
    pub implant_count: usize,
    /// The spread of the signal within the detector, a mixture of Gaussians whose weights sum to 1, to 1e-6. Not in views
    /// given by matrices, as the focal spot and scatter. Default NULL: none.
    pub blur: *const DrrBlurComponent,
    /// Number of Gaussians, 1 to 8. Not read when blur is NULL. Default 0.
    pub blur_count: usize,
    /// A measured modulation transfer function instead of blur, for which the nearest mixture of Gaussians is taken:
    /// mtf_count frequencies, line pairs per mm, at least 0, ascending. Must be NULL when blur is not. Default NULL:
    /// none.
    pub mtf_frequencies_per_mm: *const f64,
    /// Its value at each of the mtf_frequencies_per_mm, 0 to 1; 1 at frequency 0, with or without a point there. Gaussians stand
    /// for it, which must follow it to 0.05. Not read
    /// when they are NULL. Default NULL.
    pub mtf: *const f64,
    /// Number of mtf_frequencies_per_mm, 2 to 256. Not read when they are NULL. Default 0.
    pub mtf_count: usize,
    /// Angle between the anode's surface and the detector's normal, degrees, above 0 to 45. Only read with
    /// DRR_EFFECT_HEEL, as all heel_ fields. Default 12.
    pub heel_target_angle_degrees: f64,
    /// How deep in the anode photons are made, mm along the electrons' way, above 0 to 1. The spectrum holds behind the anode's
    /// own filtration on the detector's normal, and may grow at most twofold towards the cathode. Default 0.005.
    pub heel_depth_mm: f64,
    /// Where the cathode is, in the detector's plane, degrees, -360 to 360: 0 where i grows, 90 across on the side where
    /// j grows. Default 0.
    pub heel_cathode_degrees: f64,
    /// The focal spot's side along the detector's rows, where i grows, mm, 0 to 10; one side must be above 0. Rays are cast
    /// from points half a pixel apart on the detector, whose areal densities a call holds all at once. Only read with
    /// DRR_EFFECT_FOCAL_SPOT. Default 0.
    pub focal_spot_width_mm: f64,
    /// Its side along the detector's columns, where j grows, mm, 0 to 10. Only read with DRR_EFFECT_FOCAL_SPOT. Default
    /// 0.
    pub focal_spot_height_mm: f64,
    /// The part of a pixel's area that detects, 0.01 to 1: a centred square. Only read with DRR_EFFECT_FILL_FACTOR.
    /// Default 1.
    pub fill_factor: f64,
    /// The dose: photons of the source's spectrum that reach the pixel nearest to the source where nothing is in the way,
    /// above 0 to 1e12. Only read with DRR_EFFECT_QUANTUM_NOISE or DRR_EFFECT_ELECTRONIC_NOISE. Default 0, which these
    /// refuse.
    pub photons_per_pixel: f64,
    /// Standard deviation of the electronic noise, in mean signals of one photon, above 0 to 1e6. Only read with
    /// DRR_EFFECT_ELECTRONIC_NOISE. Default 0, which it refuses.
    pub electronic_noise_photons: f64,
    /// Other seeds give other noise; the same one gives the same. Only read with DRR_EFFECT_QUANTUM_NOISE or
    /// DRR_EFFECT_ELECTRONIC_NOISE. Default 0.
    pub noise_seed: u64,
    /// Photons followed through each of the slabs of water of which the scatter is estimated, 1000 to 10000000, down to 15 keV;
    /// below the first energy the detector's response is that of the first: a second
    /// for the default of 40000, once per spectrum, detector and distances of a context. Only read with
    /// DRR_EFFECT_SCATTER.
    pub scatter_photons: u64,
    /// Another seed gives another estimate of the scatter. Only read with DRR_EFFECT_SCATTER. Default 0.
    pub scatter_seed: u64,
}

/// Largest tolerance_mm.
const MOST_MM: f64 = 1e6;

const SCENE_SIZE: usize = size_of::<[usize; 22]>() + 160;

// SAFETY: repr(C), no padding (asserted), starts with its size; numbers and raw pointers only.
unsafe impl Options for DrrScene {
    const SIZES: &'static [usize] = &[SCENE_SIZE];
    fn defaults() -> Self {
        let (grid, heel, scatter) = (EnergyGrid::SPECIFICATION, Heel::TYPICAL, Scatter::default());
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
            detector_efficiency: std::ptr::null(),
            second_detector_response: std::ptr::null(),
            second_detector_efficiency: std::ptr::null(),
            filters: std::ptr::null(),
            filter_count: 0,
            implants: std::ptr::null(),
            implant_count: 0,
            blur: std::ptr::null(),
            blur_count: 0,
            mtf_frequencies_per_mm: std::ptr::null(),
            mtf: std::ptr::null(),
            mtf_count: 0,
            heel_target_angle_degrees: heel.target_angle_degrees,
            heel_depth_mm: heel.depth_mm,
            heel_cathode_degrees: heel.cathode_degrees,
            focal_spot_width_mm: 0.0,
            focal_spot_height_mm: 0.0,
            fill_factor: 1.0,
            photons_per_pixel: 0.0,
            electronic_noise_photons: 0.0,
            noise_seed: 0,
            scatter_photons: scatter.histories as u64,
            scatter_seed: scatter.seed,
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
        DRR_ALGORITHM_DISTANCE_DRIVEN => Ok(Algorithm::DistanceDriven),
        _ => Err(Error::invalid("algorithm", code, "one of the DRR_ALGORITHM constants, 0 … 4")),
    }
}

impl DrrScene {
    /// The scene, with copies of the caller's tables.
    ///
    /// # Safety
    /// The pointers are null or as the fields' descriptions say.
    pub(super) unsafe fn read(&self) -> Result<Scene> {
        self.check_effects()?;
        let energies = self.energies()?;
        // SAFETY: the caller's promise is the same.
        let (spectrum, materials) = unsafe { (self.spectrum(energies)?, self.materials(energies)?) };
        // SAFETY: the caller's promise is the same.
        let (detector_layers, effects) = unsafe {
            let layers = self.detector_layers(&spectrum)?;
            let tables = self.table_energies(energies, &spectrum)?;
            (layers, self.simulated_effects(&tables, materials.names().len())?)
        };
        let scene = Scene {
            detector: [self.detector_width, self.detector_height],
            bone: self.bone(materials.names().len())?,
            spectrum,
            materials,
            method: self.method()?,
            tolerance: self.tolerance()?,
            // SAFETY: the caller's promise is the same.
            expected_views: unsafe { self.expected_views()? },
            supersampling: self.supersampling as usize,
            detector_layers,
            effects,
        };
        scene.validate().map_err(names::in_c).map(|()| scene)
    }

    /// The label of bone, where its path can be asked for.
    fn bone(&self, materials: usize) -> Result<Option<u8>> {
        if !self.has(DRR_EFFECT_BONE_PATH) {
            return Ok(None);
        }
        let refused =
            |_| Error::invalid("scene.bone_material", self.bone_material, format!("0 … {}", materials - 1));
        u8::try_from(self.bone_material).map(Some).map_err(refused)
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
}

/// Fills `*scene` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_scene_init(scene: *mut DrrScene) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("scene", scene) })
}

/// States a tolerance by its `name`: "draft", 10 HU and 1 mm; "standard", the specification's 2 HU and 0.2 mm; "reference",
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
