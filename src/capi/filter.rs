//! Filters between tube and volume.

use std::ffi::c_char;

use crate::capi::memory;
use crate::capi::spectra::TableEnergies;
use crate::effects::{Filter, MAX_BOW_TIE_POINTS, Profile};
use crate::error::{Error, Result};
use crate::physics::{MAX_ATTENUATION, MassAttenuation, Material};

/// A homogeneous body between tube and volume, which stays where it is relative to source and detector: a flat slab
/// across the detector's normal, or a bow-tie. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrFilter {
    /// A built-in material, such as "aluminium", for energies that are tabulated; NULL: mass_attenuation says what it is.
    pub material: *const c_char,
    /// Mass attenuation coefficients, cm²/g: energy_count values, 0 to 1e9. Must be NULL when material is not.
    pub mass_attenuation: *const f32,
    /// Mass density, g/cm³, 1e-6 to 30; 0 for a built-in material: its usual one.
    pub density: f64,
    /// Thickness of a flat slab, mm, 0 to 1000. Only read when point_count is 0.
    pub thickness_mm: f64,
    /// Of a bow-tie, the same at every height j: angles between the detector's normal and a ray, seen from above the fan,
    /// degrees, above -90 and below 90, ascending, positive where i grows. Not read when point_count is 0.
    pub angles_degrees: *const f64,
    /// What a ray in the fan's plane crosses at each angle, mm, 0 to 1000; linear in between, beyond the ends as there.
    /// Not read when point_count is 0.
    pub thicknesses_mm: *const f64,
    /// Number of angles and thicknesses of a bow-tie, 2 to 1024; 0: a flat slab.
    pub point_count: usize,
}

impl DrrFilter {
    /// The filter, which is called `name`.
    ///
    /// # Safety
    /// The pointers are null or misaligned, or as the fields' descriptions say.
    pub(super) unsafe fn read(&self, name: &str, tables: &TableEnergies) -> Result<Filter> {
        // SAFETY: the caller's promise is the same.
        let profile = unsafe { self.profile(name)? };
        // SAFETY: the caller's promise is the same.
        let filter = unsafe {
            if self.material.is_null() {
                self.own(name, tables, profile)?
            } else {
                self.built_in(name, tables, profile)?
            }
        };
        let called = |error: Error| {
            let fields = [
                ("profile.degrees", "angles_degrees"),
                ("profile.mm[", "thicknesses_mm["),
                ("profile.mm", "thickness_mm"),
                ("coefficients", "mass_attenuation"),
            ];
            fields.into_iter().fold(error, |error, (from, to)| error.called(from, to)).of(name)
        };
        filter.validate(&tables.simulated).map_err(called).map(|()| filter)
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn built_in(&self, name: &str, tables: &TableEnergies, profile: Profile) -> Result<Filter> {
        if !self.mass_attenuation.is_null() {
            let valid = "NULL, because material says what the filter is made of";
            return Err(Error::invalid(format!("{name}.mass_attenuation"), "not NULL", valid));
        }
        let argument = format!("{name}.material");
        // SAFETY: by the caller's promise the text ends in NUL.
        let material = unsafe { memory::read_text(&argument, self.material)? };
        let usual = Material::named(material).map_err(|error| error.called("material", &argument))?;
        let density = if self.density == 0.0 { usual.reference_density() } else { self.density };
        let coefficients = tables.built_in(|grid| MassAttenuation::named(&[material], grid))?;
        Ok(Filter::new(material, density, coefficients.coefficients(0).to_vec(), profile))
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn own(&self, name: &str, tables: &TableEnergies, profile: Profile) -> Result<Filter> {
        if self.mass_attenuation.is_null() {
            let valid = "a built-in material's name, unless there is mass_attenuation";
            return Err(Error::invalid(format!("{name}.material"), "NULL", valid));
        }
        let valid = format!("0 … {MAX_ATTENUATION:e} cm²/g");
        let range = (0.0..=MAX_ATTENUATION, &*valid);
        // SAFETY: by the caller's promise there is one value per energy.
        let coefficients =
            unsafe { tables.read(&format!("{name}.mass_attenuation"), self.mass_attenuation, range)? };
        Ok(Filter::new("the caller's filter", self.density, coefficients, profile))
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn profile(&self, name: &str) -> Result<Profile> {
        if self.point_count == 0 {
            return Ok(Profile::Flat { mm: self.thickness_mm });
        }
        if !(2..=MAX_BOW_TIE_POINTS).contains(&self.point_count) {
            let valid = format!("2 … {MAX_BOW_TIE_POINTS}, or 0 for a flat slab");
            return Err(Error::invalid(format!("{name}.point_count"), self.point_count, valid));
        }
        let argument = |field: &str| format!("{name}.{field}");
        // SAFETY: by the caller's promise there are as many points.
        let (degrees, mm) = unsafe {
            (
                memory::read_array(&argument("angles_degrees"), self.angles_degrees, self.point_count)?,
                memory::read_array(&argument("thicknesses_mm"), self.thicknesses_mm, self.point_count)?,
            )
        };
        Ok(Profile::BowTie { degrees: degrees.to_vec(), mm: mm.to_vec() })
    }
}
