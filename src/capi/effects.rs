//! What a scene simulates beside attenuation by the volume.

use crate::capi::filter::DrrFilter;
use crate::capi::implant::DrrImplant;
use crate::capi::scene::DrrScene;
use crate::capi::spectra::TableEnergies;
use crate::capi::{memory, names};
use crate::effects::{
    Effects, FillFactor, Filter, FocalSpot, Heel, Implant, MAX_EFFECT_PARTS, Noise, Scatter,
};
use crate::error::{Error, Result};

/// What a scene simulates: DRR_EFFECT bits. Unknown bits are refused. Filters, implants, a second detector layer and
/// blur have no bit: they are there when the scene points to them.
pub type DrrEffects = u32;

/// All energies of the spectrum are summed. Without it everything happens at mono_energy_kev.
pub const DRR_EFFECT_POLYENERGETIC: DrrEffects = 1 << 0;
/// The bone path can be asked for as an output.
pub const DRR_EFFECT_BONE_PATH: DrrEffects = 1 << 1;
/// The intensity falls as cos^3 of the angle to the detector's normal: inverse square and obliquity.
pub const DRR_EFFECT_FALL_OFF: DrrEffects = 1 << 2;
/// The anode, of tungsten, filters its own photons by direction: heel_target_angle_degrees, heel_depth_mm,
/// heel_cathode_degrees. On the detector's normal the spectrum is the scene's.
pub const DRR_EFFECT_HEEL: DrrEffects = 1 << 3;
/// The source is a rectangle: focal_spot_width_mm, focal_spot_height_mm.
pub const DRR_EFFECT_FOCAL_SPOT: DrrEffects = 1 << 4;
/// Only a part of each pixel detects: fill_factor. The intensity is that part of what the pixel gets.
pub const DRR_EFFECT_FILL_FACTOR: DrrEffects = 1 << 5;
/// Photons that the object scatters reach the detector: scatter_photons, scatter_seed.
pub const DRR_EFFECT_SCATTER: DrrEffects = 1 << 6;
/// Photons come in whole numbers: photons_per_pixel, noise_seed.
pub const DRR_EFFECT_QUANTUM_NOISE: DrrEffects = 1 << 7;
/// The read-out adds noise: electronic_noise_photons, photons_per_pixel, noise_seed.
pub const DRR_EFFECT_ELECTRONIC_NOISE: DrrEffects = 1 << 8;

/// All bits that have a meaning.
const KNOWN: DrrEffects = (1 << 9) - 1;

impl DrrScene {
    /// Whether the scene asks for an effect by its bit.
    pub(super) fn has(&self, effect: DrrEffects) -> bool {
        self.effects & effect != 0
    }

    pub(super) fn is_polyenergetic(&self) -> bool {
        self.has(DRR_EFFECT_POLYENERGETIC)
    }

    /// Refuses unknown bits.
    pub(super) fn check_effects(&self) -> Result<()> {
        if self.effects & !KNOWN == 0 {
            return Ok(());
        }
        let value = format!("{:#x}", self.effects);
        Err(Error::invalid("scene.effects", value, format!("DRR_EFFECT bits, {KNOWN:#x}, only")))
    }

    /// The effects of a scene with so many materials, checked but for what they have to fit.
    ///
    /// # Safety
    /// As for [`Self::read`].
    pub(super) unsafe fn simulated_effects(
        &self,
        tables: &TableEnergies,
        materials: usize,
    ) -> Result<Effects> {
        let fill_factor = self.has(DRR_EFFECT_FILL_FACTOR).then(|| FillFactor::new(self.fill_factor));
        let scatter = self.has(DRR_EFFECT_SCATTER).then(|| self.scatter());
        // SAFETY: the caller's promise is the same.
        let (filters, implants, detector_blur) =
            unsafe { (self.filters(tables)?, self.implants(materials)?, self.detector_blur()?) };
        Ok(Effects {
            fall_off: self.has(DRR_EFFECT_FALL_OFF),
            heel: self.has(DRR_EFFECT_HEEL).then(|| self.heel()),
            filters,
            implants,
            focal_spot: self.has(DRR_EFFECT_FOCAL_SPOT).then_some(FocalSpot {
                width_mm: self.focal_spot_width_mm,
                height_mm: self.focal_spot_height_mm,
            }),
            scatter: scatter.transpose()?,
            detector_blur,
            fill_factor: fill_factor.transpose().map_err(names::in_c)?,
            noise: self.noise()?,
        })
    }

    fn heel(&self) -> Heel {
        Heel {
            target_angle_degrees: self.heel_target_angle_degrees,
            depth_mm: self.heel_depth_mm,
            cathode_degrees: self.heel_cathode_degrees,
        }
    }

    fn scatter(&self) -> Result<Scatter> {
        let refused = |_| Error::invalid("scene.scatter_photons", self.scatter_photons, "1000 … 10000000");
        let histories = usize::try_from(self.scatter_photons).map_err(refused)?;
        Ok(Scatter { histories, seed: self.scatter_seed })
    }

    fn noise(&self) -> Result<Option<Noise>> {
        let [quantum, electronic] =
            [DRR_EFFECT_QUANTUM_NOISE, DRR_EFFECT_ELECTRONIC_NOISE].map(|bit| self.has(bit));
        if electronic && self.electronic_noise_photons == 0.0 {
            let valid = "above 0, at most 1e6 photons, with DRR_EFFECT_ELECTRONIC_NOISE";
            return Err(Error::invalid("scene.electronic_noise_photons", 0, valid));
        }
        Ok((quantum || electronic).then_some(Noise {
            photons_per_pixel: self.photons_per_pixel,
            quantum,
            electronic_photons: if electronic { self.electronic_noise_photons } else { 0.0 },
            seed: self.noise_seed,
        }))
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn filters(&self, tables: &TableEnergies) -> Result<Vec<Filter>> {
        // SAFETY: the caller's promise is the same.
        let filters = unsafe { parts("filter", self.filters, self.filter_count)? };
        // SAFETY: the caller's promise is the same.
        let read =
            |(n, filter): (usize, &DrrFilter)| unsafe { filter.read(&format!("scene.filters[{n}]"), tables) };
        filters.iter().enumerate().map(read).collect()
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn implants(&self, materials: usize) -> Result<Vec<Implant>> {
        // SAFETY: the caller's promise is the same.
        let implants = unsafe { parts("implant", self.implants, self.implant_count)? };
        // SAFETY: the caller's promise is the same.
        let read = |(n, implant): (usize, &DrrImplant)| unsafe {
            implant.read(&format!("scene.implants[{n}]"), materials)
        };
        implants.iter().enumerate().map(read).collect()
    }
}

/// An array of a scene; none for null.
///
/// # Safety
/// As for [`DrrScene::read`].
unsafe fn parts<'a, T: Copy>(noun: &str, array: *const T, count: usize) -> Result<&'a [T]> {
    if array.is_null() {
        return Ok(&[]);
    }
    if !(1..=MAX_EFFECT_PARTS).contains(&count) {
        let valid = format!("1 … {MAX_EFFECT_PARTS}, because there are {noun}s");
        return Err(Error::invalid(format!("scene.{noun}_count"), count, valid));
    }
    // SAFETY: by the caller's promise there are as many.
    unsafe { memory::read_array(&format!("scene.{noun}s"), array, count) }
}
