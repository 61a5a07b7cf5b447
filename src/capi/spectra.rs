//! A scene's tables by energy: spectrum, detector, materials.

use crate::allocation::collected;
use crate::capi::effects::{DRR_EFFECT_ELECTRONIC_NOISE, DRR_EFFECT_QUANTUM_NOISE};
use crate::capi::memory;
use crate::capi::scene::DrrScene;
use crate::error::{Error, Result};
use crate::physics::{DetectorResponse, EnergyGrid, MAX_MATERIALS, MassAttenuation, Spectrum};
use crate::scene::check_i0;

/// `values` as float64.
pub(super) fn widened(values: &[f32]) -> Result<Vec<f64>> {
    collected(values.iter().copied().map(f64::from), "a spectral table")
}

/// Names for the materials of a caller's table.
pub(super) fn material_names(count: usize) -> Vec<String> {
    (0..count).map(|m| format!("material {m}")).collect()
}

/// The energies of a scene's tables, and those of them that are simulated: all, or one.
pub(super) struct TableEnergies {
    all: EnergyGrid,
    pub(super) simulated: EnergyGrid,
    first: usize,
}

impl TableEnergies {
    /// What a built-in table says of the energies simulated.
    pub(super) fn built_in<T>(&self, table: impl FnOnce(EnergyGrid) -> Result<T>) -> Result<T> {
        table(self.simulated).map_err(|error| {
            if self.simulated == self.all {
                return error.called("first_energy_kev", "scene.first_energy_kev");
            }
            error.called(&EnergyGrid::argument(0), "scene.mono_energy_kev")
        })
    }

    /// Of a caller's table with `all` energies, within a range that words say, what is simulated.
    ///
    /// # Safety
    /// `table` is null, misaligned, or has one value per energy.
    pub(super) unsafe fn read(
        &self,
        argument: &str,
        table: *const f32,
        range: (std::ops::RangeInclusive<f64>, &str),
    ) -> Result<Vec<f64>> {
        // SAFETY: the caller's promise is the same.
        let values = widened(unsafe { memory::read_array(argument, table, self.all.count())? })?;
        self.all.check_values(argument, &values, range)?;
        Ok(values[self.first..][..self.simulated.count()].to_vec())
    }
}

impl DrrScene {
    /// The energies of the tables, of which the spectrum has all or one.
    pub(super) fn table_energies(&self, all: EnergyGrid, spectrum: &Spectrum) -> Result<TableEnergies> {
        let first = if self.is_polyenergetic() { 0 } else { self.mono_energy(all)? };
        Ok(TableEnergies { all, simulated: *spectrum.grid(), first })
    }

    /// The energies of the tables.
    pub(super) fn energies(&self) -> Result<EnergyGrid> {
        EnergyGrid::new(self.first_energy_kev, self.energy_step_kev, self.energy_count)
            .map_err(|error| error.of("scene"))
    }

    /// # Safety
    /// As for [`Self::read`].
    pub(super) unsafe fn spectrum(&self, energies: EnergyGrid) -> Result<Spectrum> {
        if !self.is_polyenergetic() {
            self.mono_energy(energies)?;
            return Spectrum::monoenergetic(self.mono_energy_kev);
        }
        // SAFETY: by the caller's promise this is null or has one value per energy.
        let weights = unsafe { memory::read_optional("scene.spectrum", self.spectrum, self.energy_count)? };
        let spectrum = match weights {
            Some(weights) => Spectrum::new("the caller's spectrum", energies, widened(weights)?),
            None => Spectrum::named(Spectrum::DEFAULT, energies),
        };
        spectrum.map_err(|error| error.of("scene"))
    }

    /// The detector's layers, which see this spectrum.
    ///
    /// # Safety
    /// As for [`Self::read`].
    pub(super) unsafe fn detector_layers(&self, spectrum: &Spectrum) -> Result<Vec<DetectorResponse>> {
        if !self.is_polyenergetic() {
            return Ok(Vec::new());
        }
        let second = (self.second_detector_response, self.second_detector_efficiency);
        // SAFETY: the caller's promise is the same.
        let (first, second) = unsafe {
            (
                self.response(spectrum, "", (self.detector_response, self.detector_efficiency))?,
                self.response(spectrum, "second_", second)?,
            )
        };
        let ideal = || DetectorResponse::ideal(*spectrum.grid());
        Ok(match (first, second) {
            (None, None) => Vec::new(),
            (Some(first), None) => vec![first],
            (first, Some(second)) => vec![first.unwrap_or_else(ideal), second],
        })
    }

    /// One layer of the detector, whose fields' names begin so.
    ///
    /// # Safety
    /// As for [`Self::read`].
    unsafe fn response(
        &self,
        spectrum: &Spectrum,
        which: &str,
        (factors, efficiency): (*const f32, *const f32),
    ) -> Result<Option<DetectorResponse>> {
        let names = ["response", "efficiency"].map(|field| format!("scene.{which}detector_{field}"));
        let called = |error: Error| {
            let error = error.called("detector_response", &names[0]).called("detector_efficiency", &names[1]);
            // Without the name of a field: of what float32 images can hold.
            error.called("spectrum's", &format!("{} × spectrum's", names[0]))
        };
        // SAFETY: by the caller's promise these are null or have one value per energy.
        let [factors, efficiency] = unsafe {
            [
                memory::read_optional(&names[0], factors, self.energy_count)?,
                memory::read_optional(&names[1], efficiency, self.energy_count)?,
            ]
        };
        let Some(factors) = factors else {
            if efficiency.is_some() {
                let valid = format!("NULL, because {} is", names[0]);
                return Err(Error::invalid(&names[1], "not NULL", valid));
            }
            return Ok(None);
        };
        let mut response =
            DetectorResponse::new("the caller's detector", *spectrum.grid(), widened(factors)?)
                .map_err(called)?;
        if let Some(efficiency) = efficiency {
            response = response.with_efficiency(widened(efficiency)?).map_err(called)?;
        } else if self.has(DRR_EFFECT_QUANTUM_NOISE | DRR_EFFECT_ELECTRONIC_NOISE) {
            let valid = format!(
                "the probability that a photon is detected, because noise depends on how many are; equal to {} \
                 for a detector that counts photons",
                names[0]
            );
            return Err(Error::invalid(&names[1], "NULL", valid));
        }
        let detected = spectrum.folded(&response).map_err(called)?;
        check_i0(detected.total()).map_err(called)?;
        Ok(Some(response))
    }

    /// # Safety
    /// As for [`Self::read`].
    pub(super) unsafe fn materials(&self, energies: EnergyGrid) -> Result<MassAttenuation> {
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
    pub(super) fn mono_energy(&self, energies: EnergyGrid) -> Result<usize> {
        energies.index_of(self.mono_energy_kev).ok_or_else(|| {
            Error::invalid("scene.mono_energy_kev", self.mono_energy_kev, format!("one of {energies}"))
        })
    }
}
