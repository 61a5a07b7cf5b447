//! The tables of one view, behind the addresses in its uniforms.

use std::collections::HashMap;
use std::sync::Arc;

use crate::allocation::refused;
use crate::capi::memory;
use crate::capi::projector::ProjectorValue;
use crate::capi::spectra::{material_names, widened};
use crate::engine::Device;
use crate::error::{Error, Result};
use crate::physics::{EnergyGrid, MassAttenuation, SpectralModel, Spectrum};
use crate::scene::check_i0;
use crate::shared::{DrrAddress, ProjectionUniforms};

/// The spectral models of one call's views. Views with the same addresses share one.
#[derive(Default)]
pub(super) struct Tables(HashMap<[DrrAddress; 2], Arc<SpectralModel>>);

impl Tables {
    /// The view's own spectral model; `None` when both addresses are 0.
    ///
    /// # Safety
    /// An address that is not 0 is one of the engine's, of as many floats as the uniforms' description says, which nobody
    /// writes as long as `self` lives.
    pub(super) unsafe fn model(
        &mut self,
        projector: &ProjectorValue,
        view: &ProjectionUniforms,
    ) -> Result<Option<Arc<SpectralModel>>> {
        let addresses = [view.spectrumLutAddress, view.muLutAddress];
        if addresses == [0, 0] {
            return Ok(None);
        }
        if let Some(model) = self.0.get(&addresses) {
            return Ok(Some(model.clone()));
        }
        // SAFETY: the caller's promise is the same.
        let model = Arc::new(unsafe { read(projector, addresses)? });
        let refused = refused::<([DrrAddress; 2], Arc<SpectralModel>)>(self.0.len() + 1, "the views' tables");
        self.0.try_reserve(1).map_err(refused)?;
        self.0.insert(addresses, model.clone());
        Ok(Some(model))
    }
}

/// The spectral model behind two addresses, of which at least one is not 0.
///
/// # Safety
/// As for [`Tables::model`].
unsafe fn read(projector: &ProjectorValue, [spectrum, mu]: [DrrAddress; 2]) -> Result<SpectralModel> {
    check_polyenergetic(projector, [spectrum, mu])?;
    let scene = projector.projector.scene();
    let energies = *scene.spectrum.grid();
    let materials = scene.materials.names().len();
    let device = projector.projector.context().device();
    // SAFETY: the caller's promise.
    let (weights, coefficients) = unsafe {
        (
            table(device, "spectrumLutAddress", spectrum, energies.count())?,
            table(device, "muLutAddress", mu, materials * energies.count())?,
        )
    };
    let own_spectrum = weights.map(|w| own_spectrum(energies, w)).transpose()?;
    let own_materials = coefficients
        .map(|c| MassAttenuation::new(energies, material_names(materials), c))
        .transpose()
        .map_err(|error| error.called("mass_attenuation", "muLutAddress"))?;
    let spectrum = own_spectrum.map_or_else(|| scene.detected(0), Ok)?;
    SpectralModel::new(&spectrum, own_materials.as_ref().unwrap_or(&scene.materials))
}

/// A view's addresses, for a GPU that reads them itself.
pub(super) fn addresses(projector: &ProjectorValue, view: &ProjectionUniforms) -> Result<[DrrAddress; 2]> {
    let addresses = [view.spectrumLutAddress, view.muLutAddress];
    check_polyenergetic(projector, addresses).map(|()| addresses)
}

fn check_polyenergetic(projector: &ProjectorValue, [spectrum, mu]: [DrrAddress; 2]) -> Result<()> {
    if projector.polyenergetic || [spectrum, mu] == [0, 0] {
        return Ok(());
    }
    let argument = if spectrum == 0 { "muLutAddress" } else { "spectrumLutAddress" };
    let value = format!("{:#x}", spectrum.max(mu));
    Err(Error::invalid(argument, value, "0, because the scene is without DRR_EFFECT_POLYENERGETIC"))
}

fn own_spectrum(energies: EnergyGrid, weights: Vec<f64>) -> Result<Spectrum> {
    let spectrum = Spectrum::new("the view's spectrum", energies, weights);
    spectrum
        .and_then(|spectrum| check_i0(spectrum.total()).map(|()| spectrum))
        .map_err(|error| error.called("spectrum", "spectrumLutAddress"))
}

/// The floats at an address; `None` for 0.
///
/// # Safety
/// As for [`Tables::model`].
unsafe fn table(
    device: &Device,
    argument: &str,
    address: DrrAddress,
    count: usize,
) -> Result<Option<Vec<f64>>> {
    if address == 0 {
        return Ok(None);
    }
    // SAFETY: the caller's promise.
    if let Some(values) = unsafe { device.floats(argument, address, count) } {
        return widened(&values?).map(Some);
    }
    let fits = usize::try_from(address);
    let address = fits.map_err(|_| Error::invalid(argument, format!("{address:#x}"), "a host address"))?;
    let pointer = std::ptr::with_exposed_provenance(address);
    // SAFETY: the caller's promise.
    unsafe { memory::read_optional(argument, pointer, count)? }.map(widened).transpose()
}
