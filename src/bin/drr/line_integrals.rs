//! Line integrals that the commands are given, and the noise of those that they simulate.

use std::path::Path;

use anyhow::{Context as _, Result, bail};
use drr::alignment::PhotonNoise;
use drr::formats::read_raw_f32;

/// So many measured line integrals −ln(I/I₀) of `--measured`, float32.
///
/// # Errors
/// For a file of another size, and values that are not finite.
pub(crate) fn read_line_integrals(path: &Path, count: usize) -> Result<Vec<f32>> {
    let values = read_raw_f32(path, count).context("--measured")?;
    if !values.iter().all(|value| value.is_finite()) {
        bail!("--measured has values that are not finite; valid: line integrals");
    }
    Ok(values)
}

/// The noise of `--photons`; none of 0 photons.
///
/// # Errors
/// For another dose that is not valid.
pub(crate) fn photon_noise(photons: f64, seed: u64) -> Result<Option<PhotonNoise>> {
    if photons == 0.0 {
        return Ok(None);
    }
    let noise = PhotonNoise { photons, seed };
    noise.validate().context("--photons")?;
    Ok(Some(noise))
}
