//! The noise of a detector: of the number of photons, and of the electronics that read it out.

mod detected;
mod normal;
mod photons;
mod poisson;
mod random;
#[cfg(test)]
mod sample;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use crate::effects::Plane;
use crate::effects::noise::detected::Photons;
use crate::error::{Error, Result};

pub use photons::PhotonNoise;

pub(crate) use random::RowRandom;

/// Largest dose, photons per pixel.
const MOST_PHOTONS: f64 = 1e12;
/// Largest standard deviation of the electronic noise, in photons.
const MOST_ELECTRONIC_PHOTONS: f64 = 1e6;

/// What makes two images of one scene differ.
///
/// **Quantum noise**: detected photons of each energy are Poisson numbers, each of which adds its gain to the signal: 1
/// where photons are counted, the energy it leaves where energy is integrated. Mean, variance and skewness of a pixel
/// and the probability that it detects nothing are those of the sum over all energies (R. K. Swank, J. Appl. Phys. 44
/// (1973) 4199; B. R. Whiting, Proc. SPIE 4682 (2002) 53). Pixels do not depend on each other.
///
/// **Electronic noise**: a normal number per pixel is added to the signal, which may lead below 0.
///
/// The uniform numbers behind it follow from the seed, the view, the layer and the pixel alone, on every machine and for
/// any number of threads; on one machine so do all bytes. Machines whose logarithm differs in the last digit may count a
/// photon more or less in a rare pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// The dose: photons of the source's spectrum, before the detector, that reach the pixel at the foot of the
    /// perpendicular from the source where nothing is in the way; above 0, at most 1e12.
    ///
    /// It is the photon fluence times the pixel's area. At 1 µGy of air kerma the radiation quality RQA5 (70 kV, 21 mm
    /// of aluminium) has 30174 photons per mm² (IEC 62220-1:2003, table 2).
    pub photons_per_pixel: f64,
    /// Whether there is quantum noise.
    pub quantum: bool,
    /// Standard deviation of the electronic noise, in photons of mean signal; 0 (none) … 1e6.
    pub electronic_photons: f64,
    /// Other seeds give other noise.
    pub seed: u64,
}

impl Noise {
    /// Checks that there is a dose, that the numbers are in their ranges, and that there is noise of one kind or the
    /// other.
    ///
    /// # Errors
    /// `InvalidArgument` with the field's name.
    pub fn validate(&self) -> Result<()> {
        let photons = self.photons_per_pixel;
        if !(photons > 0.0 && photons <= MOST_PHOTONS) {
            let valid = "above 0, at most 1e12 photons: noise needs a dose; without one, leave the noise out";
            return Err(Error::invalid("scene.effects.noise.photons_per_pixel", photons, valid));
        }
        let electronic = self.electronic_photons;
        if !(0.0..=MOST_ELECTRONIC_PHOTONS).contains(&electronic) {
            let valid = "0 … 1e6 photons";
            return Err(Error::invalid("scene.effects.noise.electronic_photons", electronic, valid));
        }
        if !self.quantum && electronic == 0.0 {
            let valid = "true, unless electronic_photons is above 0; without either, leave the noise out";
            return Err(Error::invalid("scene.effects.noise.quantum", false, valid));
        }
        Ok(())
    }

    /// One noisy image of the layer `layer` of the view `view`, in the units of the first moment.
    ///
    /// `moments[r]` is `Σ λₖ gₖʳ` of every pixel for r = 0 … 3, the photons of bin k being those that the pixel detects
    /// of one photon of dose and gₖ ≥ 0 the gain of each: where photons are counted, four times the same. `mean_gain`
    /// is the signal of a photon in whose units the electronic noise is given, in the units of the gains.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn applied(
        &self,
        moments: [&Plane; 4],
        mean_gain: f64,
        view: usize,
        layer: usize,
    ) -> Result<Plane> {
        let size = moments[1].size();
        debug_assert!(moments.iter().all(|plane| plane.size() == size), "planes of one image");
        let mut noisy = Plane::filled(size, 0.0)?;
        // Chunks may not be empty; without columns there are none.
        let width = size[0].max(1);
        noisy.values_mut().par_chunks_mut(width).enumerate().for_each(|(row, signals)| {
            let mut random = RowRandom::new(self.seed, view, layer, row);
            for (column, signal) in signals.iter_mut().enumerate() {
                let pixel = row * width + column;
                let per_photon = moments.map(|plane| plane.values()[pixel]);
                *signal = self.signal(per_photon, mean_gain, random.draws());
            }
        });
        Ok(noisy)
    }

    /// A pixel's signal per photon of dose.
    fn signal(&self, per_photon: [f64; 4], mean_gain: f64, draws: [f64; 3]) -> f64 {
        let electronic_sigma = self.electronic_photons * mean_gain;
        let photons = Photons { moments: per_photon.map(|moment| moment * self.photons_per_pixel) };
        let signal = if self.quantum {
            photons.signal(draws, electronic_sigma)
        } else {
            photons.mean_signal(draws, electronic_sigma)
        };
        signal / self.photons_per_pixel
    }
}
