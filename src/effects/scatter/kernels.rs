//! What scatters around each pencil of rays.

use super::excursion::CLASSES;
use super::mixture::Gaussians;
use super::obliquity::Obliquity;
use super::responses::Responses;
use super::rings::Rings;
use super::transport::{Pencil, Slab};
use super::{Beamline, Scatter};
use crate::error::{Error, Result};
use crate::physics::{Interactions, Spectrum};

/// Areal densities of the slabs, g/cm² of water: none, then from a hand to the longest way through a trunk.
const AREAL_DENSITIES: [f64; 13] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0, 40.0, 50.0];

/// Radial kernels: scattered signal per mm² of the detector's plane and per unit of the pencil's own primary signal, for
/// water of some areal densities around the centre of the volume.
///
/// Electrons per gram are nearly as many in all tissues, and they attenuate scatter about as they do the primary: relative to
/// the primary the kernels of water serve for all. They are sums of Gaussians of common widths; an areal density chooses
/// the amplitudes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScatterKernels {
    /// Standard deviations, mm.
    widths: Vec<f64>,
    rows: Vec<Row>,
}

/// The kernels of one row of responses.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    /// Amplitude of width g of excursion class m at areal density j at `(j*CLASSES + m)*widths + g`.
    amplitudes: Vec<f64>,
    /// Per areal density, relative: standard error of the amplitude, and what the Gaussians put into other rings.
    errors: Vec<[f64; 2]>,
    obliquity: Obliquity,
}

impl ScatterKernels {
    /// Follows `scatter.histories` photons of `source` through each slab. `responses` are rows of detected signal per photon
    /// at the spectrum's energies, such as the moments of the layers of a detector; each has its own kernels. The slabs
    /// are around the volume's centre; those that would reach through the detector touch it.
    ///
    /// # Errors
    /// `InvalidArgument` for a value outside its range, energies outside the built-in tables' 15 … 150 keV, or a row that
    /// sees nothing of the source behind the thickest slab.
    pub(crate) fn new(
        scatter: &Scatter,
        source: &Spectrum,
        responses: &[Vec<f64>],
        geometry: Beamline,
    ) -> Result<Self> {
        scatter.validate()?;
        geometry.validate()?;
        Self::check_energies(source)?;
        let responses = Responses::new(*source.grid(), responses)?;
        // Scatter that flies further aside than the source is far away is not followed.
        let (water, rings) = (Interactions::named("water")?, Rings::up_to(geometry.source_detector_mm));
        let gaussians = Gaussians::over(&rings);
        let pencil = Pencil { water: &water, source, responses: &responses, rings: &rings };
        let mut rows: Vec<Row> = pencil
            .attenuation()
            .into_iter()
            .map(|attenuation| Row {
                amplitudes: vec![0.0; CLASSES * gaussians.widths().len()],
                errors: vec![[0.0; 2]],
                obliquity: geometry.obliquity(attenuation),
            })
            .collect();
        for (j, areal) in (0..).zip(AREAL_DENSITIES).skip(1) {
            let slab = Slab { thickness_cm: areal, gap_cm: 0.1 * geometry.gap_mm(10.0 * areal) };
            let primary = pencil.primary(slab);
            let scattered = pencil.scattered(slab, scatter.histories, scatter.seed, j << 16);
            for (i, row) in rows.iter_mut().enumerate() {
                let own = scattered.signal.iter().skip(i).step_by(responses.rows());
                let mut signal: Vec<f64> = own.map(|signal| signal / primary[i]).collect();
                for (ring, [inner, outer]) in signal.chunks_mut(CLASSES).zip(rings.bounds()) {
                    let factor = row.obliquity.kernel(0.5 * (inner + outer), areal);
                    for signal in ring {
                        *signal *= factor;
                    }
                }
                row.push(&gaussians, &signal, scattered.error[i])?;
            }
        }
        Ok(Self { widths: gaussians.widths().to_vec(), rows })
    }

    /// Scatter needs the kinds of interaction, which are tabulated from 15 to 150 keV.
    ///
    /// # Errors
    /// `InvalidArgument` for a photon of another energy.
    pub(crate) fn check_energies(source: &Spectrum) -> Result<()> {
        let tabulated = Interactions::LOWEST_KEV..=Interactions::HIGHEST_KEV;
        let outside =
            source.grid().energies().zip(source.weights()).find(|(e, w)| **w > 0.0 && !tabulated.contains(e));
        match outside {
            Some((kev, _)) => {
                let valid = "15 … 150 keV for the built-in tables of scattering; leave scatter out for other energies";
                Err(Error::invalid("scene.spectrum's energy", format!("{kev} keV"), valid))
            }
            None => Ok(()),
        }
    }

    /// Standard deviations of the Gaussians, mm.
    pub(super) fn widths(&self) -> &[f64] {
        &self.widths
    }

    /// The corrections of a row for oblique rays.
    pub(super) fn obliquity(&self, row: usize) -> &Obliquity {
        &self.rows[row].obliquity
    }

    /// The areal densities of the kernels, g/cm², ascending from 0.
    pub(super) fn areal_densities() -> &'static [f64] {
        &AREAL_DENSITIES
    }

    /// The amplitudes of the Gaussians of a row at the areal density with index j: width g of excursion class m at
    /// `m*widths + g`.
    pub(super) fn amplitudes(&self, row: usize, j: usize) -> &[f64] {
        let count = CLASSES * self.widths.len();
        &self.rows[row].amplitudes[j * count..][..count]
    }

    /// Largest relative standard error of a kernel's amplitude, from the statistics of its histories.
    #[cfg(test)]
    pub(crate) fn amplitude_error(&self) -> f64 {
        self.worst(0)
    }

    /// Largest part of a kernel that its Gaussians put into other rings than the histories did, noise included.
    #[cfg(test)]
    pub(crate) fn fit_error(&self) -> f64 {
        self.worst(1)
    }

    #[cfg(test)]
    fn worst(&self, which: usize) -> f64 {
        self.rows.iter().flat_map(|row| &row.errors).map(|errors| errors[which]).fold(0.0, f64::max)
    }
}

impl Row {
    /// Adds the kernel of the next areal density: its signal relative to the primary, class m of ring k at `k*CLASSES + m`.
    fn push(&mut self, gaussians: &Gaussians, signal: &[f64], error: f64) -> Result<()> {
        let total: f64 = signal.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            let valid = "a response and a spectrum whose photons get through 50 g/cm² of water";
            return Err(Error::invalid("responses' scatter-to-primary ratio", total, valid));
        }
        let mut differences: Vec<f64> = signal.chunks(CLASSES).map(|ring| ring.iter().sum()).collect();
        for m in 0..CLASSES {
            let amplitudes =
                gaussians.fit(&signal.iter().skip(m).step_by(CLASSES).copied().collect::<Vec<_>>());
            differences
                .iter_mut()
                .zip(gaussians.rings_of(&amplitudes))
                .for_each(|(ring, model)| *ring -= model);
            self.amplitudes.extend(amplitudes);
        }
        let wrong = 0.5 * differences.iter().map(|ring| ring.abs()).sum::<f64>();
        self.errors.push([error, wrong / total]);
        Ok(())
    }
}
