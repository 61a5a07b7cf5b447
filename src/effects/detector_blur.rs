//! The spread of light and charge in the detector.

use crate::effects::taps::{gaussian_response, worst_error};
use crate::effects::{Plane, Taps, convolved, mtf_curve};
use crate::error::{Error, Result};

/// Most Gaussians of a point spread.
pub const MAX_BLUR_COMPONENTS: usize = 8;
/// Largest standard deviation of one of them, mm.
const MAX_SIGMA_MM: f64 = 100.0;
/// How far the sum of the weights given may be from 1.
const SUM_TOLERANCE: f64 = 1e-6;
/// What errors call it.
const NAME: &str = "scene.effects.detector_blur";

/// A part of a point spread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlurComponent {
    /// Its share, above 0; all sum to 1.
    pub weight: f64,
    /// Standard deviation along each axis, mm; 0: what is not blurred.
    pub sigma_mm: f64,
}

/// The point spread of a detector, the same in all directions and at all places: a mixture of Gaussians. A wide one of
/// little weight is the veiling glare, narrow ones are the scintillator.
///
/// The modulation transfer function (MTF), its Fourier transform, is `Σ_n w_n exp(−2π²σ_n²f²)` (Barrett & Swindell,
/// Radiological Imaging, 1981, ch. 2 and 4). The pixel's own aperture is not in it: IEC 62220-1-1 measures both
/// together, so that a measured presampled MTF has to be divided by the aperture's where pixels are sampled by many rays.
#[derive(Debug, Clone, PartialEq)]
pub struct DetectorBlur {
    components: Vec<BlurComponent>,
}

impl DetectorBlur {
    /// Of (weight, standard deviation in mm), 1 to 8 of them. Weights are divided by their sum, which must be 1 to 1e-6.
    ///
    /// # Errors
    /// `InvalidArgument` for another number of them, weights that are not above 0 or do not sum to 1, and standard
    /// deviations outside 0 … 100 mm.
    pub fn gaussians(parts: &[(f64, f64)]) -> Result<Self> {
        let part = |&(weight, sigma_mm): &(f64, f64)| BlurComponent { weight, sigma_mm };
        // One too many tells as much as a million.
        let components = parts.iter().take(MAX_BLUR_COMPONENTS + 1).map(part).collect();
        let blur = Self { components };
        blur.validate()?;
        Ok(blur.normalised())
    }

    /// The mixture of Gaussians that is nearest to a measured MTF, with the largest difference from it over the points
    /// given. `frequencies_per_mm`, in line pairs per mm, ascend from at least 0; `mtf` has as many values from 0 to 1. At
    /// frequency 0 it is 1 (to 1e-9), with or without a point there.
    ///
    /// Exactly the MTFs that are completely monotone functions of f² are mixtures of Gaussians (Bernstein's theorem). One
    /// that falls to 0 faster than a Gaussian, or rises, is not, and the difference tells.
    ///
    /// # Errors
    /// `InvalidArgument` for less than 2 or more than 256 points, and for those that are not as said above.
    pub fn curve(frequencies_per_mm: &[f64], mtf: &[f64]) -> Result<(Self, f64)> {
        mtf_curve::validate(frequencies_per_mm, mtf).map_err(|error| error.of(NAME))?;
        let components = mtf_curve::mixture(frequencies_per_mm, mtf, MAX_SIGMA_MM, MAX_BLUR_COMPONENTS);
        let blur = Self { components }.normalised();
        blur.validate()?;
        let differences = frequencies_per_mm.iter().zip(mtf).map(|(f, value)| (blur.mtf(*f) - value).abs());
        let largest = differences.fold(0.0, f64::max);
        Ok((blur, largest))
    }

    /// Checks the ranges.
    pub fn validate(&self) -> Result<()> {
        let count = self.components.len();
        if !(1..=MAX_BLUR_COMPONENTS).contains(&count) {
            let valid = format!("1 … {MAX_BLUR_COMPONENTS}");
            return Err(Error::invalid(format!("{NAME}: number of Gaussians"), count, valid));
        }
        for (n, BlurComponent { weight, sigma_mm }) in self.components.iter().enumerate() {
            if !(*weight > 0.0 && *weight <= 1.0 + SUM_TOLERANCE) {
                return Err(Error::invalid(format!("{NAME}[{n}].weight"), weight, "above 0, at most 1"));
            }
            if !(0.0..=MAX_SIGMA_MM).contains(sigma_mm) {
                return Err(Error::invalid(format!("{NAME}[{n}].sigma_mm"), sigma_mm, "0 … 100 mm"));
            }
        }
        let sum: f64 = self.components.iter().map(|part| part.weight).sum();
        if !((sum - 1.0).abs() <= SUM_TOLERANCE) {
            return Err(Error::invalid(format!("{NAME}: sum of the weights"), sum, "1, to 1e-6"));
        }
        Ok(())
    }

    fn normalised(mut self) -> Self {
        let sum: f64 = self.components.iter().map(|part| part.weight).sum();
        for part in &mut self.components {
            part.weight /= sum;
        }
        self
    }

    /// Its Gaussians.
    pub fn components(&self) -> &[BlurComponent] {
        &self.components
    }

    /// The modulation transfer function at a frequency in line pairs per mm.
    pub fn mtf(&self, per_mm: f64) -> f64 {
        self.components.iter().map(|part| part.weight * gaussian_response(part.sigma_mm, per_mm)).sum()
    }

    /// The standard deviation of its widest Gaussian, mm.
    pub(crate) fn largest_sigma_mm(&self) -> f64 {
        self.components.iter().map(|part| part.sigma_mm).fold(0.0, f64::max)
    }

    /// `plane` as the detector blurs it; `pitch_mm` are the distances of its samples along columns and rows, that is from
    /// one column to the next and from one row to the next. Outside, the value at its edge holds.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn applied(&self, plane: &Plane, pitch_mm: [f64; 2]) -> Result<Plane> {
        let mut sum = plane.copied()?;
        for part in &self.components {
            let [columns, rows] = part.taps(pitch_mm)?;
            if columns.is_identity() && rows.is_identity() {
                continue;
            }
            let blurred = convolved(plane, &columns, &rows)?;
            // Differences, which leave what is the same everywhere as it is to the last bit.
            let both = blurred.values().iter().zip(plane.values());
            for (sum, (blurred, sharp)) in sum.values_mut().iter_mut().zip(both) {
                *sum += part.weight * (blurred - sharp);
            }
        }
        Ok(sum)
    }

    /// The parts and kernels, along columns and rows, of what `applied` does.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn kernels(&self, pitch_mm: [f64; 2]) -> Result<Vec<(f64, [Taps; 2])>> {
        self.components.iter().map(|part| Ok((part.weight, part.taps(pitch_mm)?))).collect()
    }

    /// The largest difference between what `applied` does to sines along columns or rows, up to the highest frequency that
    /// samples `pitch_mm` apart have, and the MTF.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn worst_response_error(&self, pitch_mm: [f64; 2]) -> Result<f64> {
        let parts: Vec<_> =
            self.components.iter().map(|part| Ok((part, part.taps(pitch_mm)?))).collect::<Result<_>>()?;
        let error = |axis: usize| {
            worst_error(|frequency| {
                let difference = |(part, taps): &(&BlurComponent, [Taps; 2])| {
                    let wanted = gaussian_response(part.sigma_mm / pitch_mm[axis], frequency);
                    part.weight * (taps[axis].response(frequency) - wanted)
                };
                parts.iter().map(difference).sum()
            })
        };
        Ok(error(0).max(error(1)))
    }
}

impl BlurComponent {
    fn taps(&self, pitch_mm: [f64; 2]) -> Result<[Taps; 2]> {
        let taps = |axis: usize| Taps::gaussian(self.sigma_mm / pitch_mm[axis]);
        Ok([taps(0)?, taps(1)?])
    }
}

#[cfg(test)]
mod tests;
