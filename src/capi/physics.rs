//! The built-in tables, for callers who mix them with their own.

use std::ffi::c_char;

use crate::capi::boundary::guard;
use crate::capi::memory;
use crate::capi::status::DrrStatus;
use crate::error::Result;
use crate::physics::{DetectorResponse, EnergyGrid, MassAttenuation, Spectrum};

/// Fills `weights` with `energy_count` relative photons of a built-in X-ray tube, for the energies
/// `first_energy_kev` + k × `energy_step_kev`, whole keV from 15 to 150. Over all 136 energies they sum to 1.
///
/// `name` is anode, kVp and filter, such as "W120_2p5Al", the default of a scene; an unknown name fails with a
/// message that lists all. Writes on success only. Fails with DRR_STATUS_INVALID_ARGUMENT. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_physics_spectrum(
    name: *const c_char,
    first_energy_kev: f64,
    energy_step_kev: f64,
    energy_count: usize,
    weights: *mut f32,
) -> DrrStatus {
    let energies = (first_energy_kev, energy_step_kev, energy_count);
    let values = |name: &str, grid| {
        let spectrum = Spectrum::named(name, grid).map_err(|error| error.called("spectrum's", "weights'"));
        Ok(spectrum.map_err(|error| error.called("spectrum", "name"))?.weights().to_vec())
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { fill(name, energies, "weights", weights, values) })
}

/// Fills `coefficients` with `energy_count` total mass attenuation coefficients, cm²/g, of a built-in material,
/// such as "water", "bone_cortical" or "titanium": one row of DrrScene.mass_attenuation.
///
/// Otherwise as drr_physics_spectrum.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_physics_mass_attenuation(
    name: *const c_char,
    first_energy_kev: f64,
    energy_step_kev: f64,
    energy_count: usize,
    coefficients: *mut f32,
) -> DrrStatus {
    let energies = (first_energy_kev, energy_step_kev, energy_count);
    let values = |name: &str, grid| {
        let material = MassAttenuation::named(&[name], grid);
        Ok(material.map_err(|error| error.called("materials[0]", "name"))?.coefficients(0).to_vec())
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { fill(name, energies, "coefficients", coefficients, values) })
}

/// Fills `factors`, one for each of `energy_count` energies, by which a built-in detector weights photons, for
/// DrrScene.detector_response: "ideal" (1), "transmission", "top_counting", "bottom_counting" (dimensionless),
/// "top_energy", "bottom_energy" (keV).
///
/// Otherwise as drr_physics_spectrum.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_physics_detector(
    name: *const c_char,
    first_energy_kev: f64,
    energy_step_kev: f64,
    energy_count: usize,
    factors: *mut f32,
) -> DrrStatus {
    let energies = (first_energy_kev, energy_step_kev, energy_count);
    let values = |name: &str, grid| {
        let response = DetectorResponse::named(name, grid);
        Ok(response.map_err(|error| error.called("detector_response", "name"))?.factors().to_vec())
    };
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { fill(name, energies, "factors", factors, values) })
}

/// # Safety `name` is null or ends in NUL; `place` is null, misaligned or has room for one value per energy.
unsafe fn fill(
    name: *const c_char,
    (first, step, count): (f64, f64, usize),
    argument: &str,
    place: *mut f32,
    values: impl FnOnce(&str, EnergyGrid) -> Result<Vec<f64>>,
) -> Result<()> {
    let grid = EnergyGrid::new(first, step, count)?;
    memory::check(argument, place, count)?;
    // SAFETY: the caller's promise.
    let name = unsafe { memory::read_text("name", name)? };
    let values: Vec<f32> = values(name, grid)?.into_iter().map(|value| value as f32).collect();
    // SAFETY: `place` is neither null nor misaligned and has room by the caller's promise.
    unsafe { memory::write_array(place, &values) };
    Ok(())
}
