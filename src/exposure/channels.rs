//! Several signals of one ray: sums over the same energies by other weights.

use crate::engine::cpu::bins::{Bins, Wide};
use crate::engine::cpu::signal::FAINT;
use crate::error::Result;
use crate::physics::DetectorResponse;
use crate::scene::Scene;

/// The moments of the photons' gains that noise needs: the number of photons, and the mean signal, its variance and its third
/// central moment.
pub(crate) const MOMENTS: usize = 4;

/// A material that is not one of the scene's and lies between source and volume.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Before<'a> {
    /// cm²/g at each energy of the spectrum.
    pub(crate) coefficients: &'a [f64],
    /// g/cm² of it that the spectrum already passed.
    pub(crate) passed: f64,
}

/// The signals of all detector layers: `Σ_k W_rk exp(−τ_k)` for each row r of weights, with the spectrum's photons in W.
#[derive(Debug)]
pub(crate) struct Channels {
    /// Absolute weights over the bins that any row has.
    rows: Vec<Vec<f64>>,
    totals: Vec<f64>,
    /// cm²/g, by material: the scene's, then those before the volume.
    coefficients: Vec<Vec<f64>>,
    bins: Bins,
    /// What one photon adds on average to each row, at each energy of the spectrum.
    responses: Vec<Vec<f64>>,
    /// The row of each moment of each layer.
    row_of: Vec<[usize; MOMENTS]>,
}

/// What a sum works with, to be used again for the next ray.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    depth: Vec<Wide>,
    passing: Vec<f64>,
}

impl Channels {
    /// Of a scene's spectrum and detector layers; `noisy`: with all moments, else only the mean signal.
    ///
    /// # Errors
    /// `InvalidArgument` for moments of a layer whose efficiency is not known.
    pub(crate) fn new(scene: &Scene, before: &[Before<'_>], noisy: bool) -> Result<Self> {
        let (mut responses, mut row_of) = (Vec::<Vec<f64>>::new(), Vec::new());
        for layer in 0..scene.layers() {
            row_of.push(moments(scene, layer, noisy)?.map(|response| {
                responses.iter().position(|known| *known == response).unwrap_or_else(|| {
                    responses.push(response);
                    responses.len() - 1
                })
            }));
        }
        // The spectrum is what it is where it has passed as much as on the central ray: undo that.
        let undone = |k: usize| before.iter().map(|b| b.coefficients[k] * b.passed).sum::<f64>().exp();
        let photons: Vec<f64> =
            scene.spectrum.weights().iter().enumerate().map(|(k, w)| w * undone(k)).collect();
        let weighted = |response: &Vec<f64>| photons.iter().zip(response).map(|(n, r)| n * r).collect();
        let rows: Vec<Vec<f64>> = responses.iter().map(weighted).collect();
        let kept: Vec<usize> =
            (0..scene.spectrum.grid().count()).filter(|&k| rows.iter().any(|row| row[k] > 0.0)).collect();
        let pick = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&k| values[k]).collect() };
        let rows: Vec<Vec<f64>> = rows.iter().map(|row| pick(row)).collect();
        let totals: Vec<f64> = rows.iter().map(|row| row.iter().sum()).collect();
        let materials = 0..scene.materials.names().len();
        let coefficients: Vec<Vec<f64>> = materials
            .map(|m| scene.materials.coefficients(m))
            .chain(before.iter().map(|b| b.coefficients))
            .map(pick)
            .collect();
        let relative: Vec<Vec<f64>> =
            rows.iter().zip(&totals).map(|(row, total)| row.iter().map(|w| w / total).collect()).collect();
        let slices: Vec<&[f64]> = relative.iter().map(Vec::as_slice).collect();
        let bins = Bins::new(&slices, coefficients.iter().map(Vec::as_slice));
        Ok(Self { rows, totals, coefficients, bins, responses, row_of })
    }

    /// Absolute weights of each sum, by energy.
    pub(crate) fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// Mass attenuation, cm²/g, by material, of which the scene's come first, and energy.
    pub(crate) fn coefficients(&self) -> &[Vec<f64>] {
        &self.coefficients
    }

    /// Number of sums.
    pub(crate) fn count(&self) -> usize {
        self.rows.len()
    }

    /// Number of energies.
    pub(crate) fn energies(&self) -> usize {
        self.rows[0].len()
    }

    /// Number of areal densities that a sum takes.
    pub(crate) fn materials(&self) -> usize {
        self.coefficients.len()
    }

    /// Which sum is each moment of a detector layer's signal.
    pub(crate) fn of_layer(&self, layer: usize) -> [usize; MOMENTS] {
        self.row_of[layer]
    }

    /// What one photon adds on average to each sum, at each energy of the spectrum.
    pub(crate) fn responses(&self) -> &[Vec<f64>] {
        &self.responses
    }

    /// The sums of a ray that meets nothing.
    pub(crate) fn totals(&self) -> &[f64] {
        &self.totals
    }

    /// All sums behind areal densities (g/cm², by material), in float64.
    pub(crate) fn exact(&self, areal_density: &[f64], signals: &mut [f64]) {
        signals.fill(0.0);
        for k in 0..self.energies() {
            let depth: f64 =
                self.coefficients.iter().zip(areal_density).map(|(row, areal)| row[k] * areal).sum();
            let passed = (-depth).exp();
            signals.iter_mut().zip(&self.rows).for_each(|(signal, row)| *signal += row[k] * passed);
        }
    }

    /// The same in float32, to 2e-6 of each and the depth's rounding.
    pub(crate) fn fast(&self, areal_density: &[f64], scratch: &mut Scratch, signals: &mut [f64]) {
        scratch.passing.resize(self.count(), 0.0);
        let Scratch { depth, passing } = scratch;
        let least = self.bins.pass(areal_density.iter().copied(), depth, passing);
        if passing.iter().any(|&passing| passing < FAINT) {
            return self.exact(areal_density, signals);
        }
        let reached = (-least).exp();
        for ((signal, passing), total) in signals.iter_mut().zip(passing).zip(&self.totals) {
            *signal = total * reached * *passing;
        }
    }
}

/// `η g^r` at each energy, for r = 0 … 3, with η the probability of detection and g the gain; without noise the mean signal
/// four times.
fn moments(scene: &Scene, layer: usize, noisy: bool) -> Result<[Vec<f64>; MOMENTS]> {
    let Some(response) = scene.detector_layers.get(layer) else {
        return Ok(std::array::from_fn(|_| vec![1.0; scene.spectrum.grid().count()]));
    };
    let mean = response.factors();
    if !noisy || response.counts_photons() {
        return Ok(std::array::from_fn(|_| mean.to_vec()));
    }
    let efficiency = known_efficiency(response, layer)?;
    let moment = |power: i32| {
        let gained = |(&detected, &mean): (&f64, &f64)| match detected {
            0.0 => 0.0,
            detected => detected * (mean / detected).powi(power),
        };
        efficiency.iter().zip(mean).map(gained).collect()
    };
    Ok([efficiency.to_vec(), mean.to_vec(), moment(2), moment(3)])
}

/// The mean signal of a photon that a layer detects of the open field.
///
/// # Errors
/// `InvalidArgument` where only a layer's mean signal is known.
pub(crate) fn mean_gain(scene: &Scene, layer: usize) -> Result<f64> {
    let Some(response) = scene.detector_layers.get(layer) else { return Ok(1.0) };
    let efficiency = known_efficiency(response, layer)?;
    let sum = |factors: &[f64]| -> f64 {
        scene.spectrum.weights().iter().zip(factors).map(|(weight, factor)| weight * factor).sum()
    };
    Ok(sum(response.factors()) / sum(efficiency))
}

/// # Errors
/// `InvalidArgument` where only a layer's mean signal is known.
pub(crate) fn known_efficiency(response: &DetectorResponse, layer: usize) -> Result<&[f64]> {
    response.efficiency().ok_or_else(|| {
        crate::error::Error::invalid(
            format!("scene.detector_layers[{layer}]"),
            format!("\"{}\", without its detection efficiency", response.name()),
            "a response with one, because noise depends on how many photons are detected; equal to the response for a \
             detector that counts photons",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::SpectralModel;

    fn scene(layers: &[&str]) -> Scene {
        let scene = Scene::new([1, 1]).expect("valid");
        let response = |name: &&str| DetectorResponse::named(name, *scene.spectrum.grid()).expect("built in");
        Scene { detector_layers: layers.iter().map(response).collect(), ..scene }
    }

    const PATHS: [[f64; 4]; 4] =
        [[0.0; 4], [0.05, 2.1, 21.2, 3.84], [0.0, 0.0, 200.0, 0.0], [0.01, 0.0, 0.0, 60.0]];

    /// Against the sum that has one row only.
    #[test]
    fn every_layer_is_what_it_is_alone() {
        let both = scene(&["top_energy", "bottom_counting"]);
        let channels = Channels::new(&both, &[], false).expect("valid");
        assert_eq!(channels.count(), 2);
        let (mut scratch, mut exact, mut fast) = (Scratch::default(), [0.0; 2], [0.0; 2]);
        for path in PATHS {
            channels.exact(&path, &mut exact);
            channels.fast(&path, &mut scratch, &mut fast);
            for layer in 0..2 {
                let model = SpectralModel::new(&both.detected(layer).expect("valid"), &both.materials);
                let alone = model.expect("valid").intensity(&path);
                let row = channels.of_layer(layer)[1];
                assert!((exact[row] / alone - 1.0).abs() < 1e-13, "{path:?} {layer}");
                assert!((fast[row] / alone - 1.0).abs() < 2e-5, "{path:?} {layer}: {} {alone}", fast[row]);
            }
        }
    }

    /// A filter in the beam is as good as a material in the volume, and one that the spectrum has passed changes nothing.
    #[test]
    fn what_lies_before_the_volume_attenuates_as_the_volume_does() {
        let scene = scene(&[]);
        let bone = scene.materials.coefficients(3).to_vec();
        let mut signal = [[0.0]; 3];
        let plain = Channels::new(&scene, &[], false).expect("valid");
        plain.exact(&[0.0, 1.0, 10.0, 2.5], &mut signal[0]);
        for (passed, areal, place) in [(0.0, 1.5, 1), (0.75, 2.25, 2)] {
            let before = [Before { coefficients: &bone, passed }];
            let filtered = Channels::new(&scene, &before, false).expect("valid");
            filtered.exact(&[0.0, 1.0, 10.0, 1.0, areal], &mut signal[place]);
        }
        assert!(signal.iter().all(|s| (s[0] / signal[0][0] - 1.0).abs() < 1e-13), "{signal:?}");
    }

    #[test]
    fn moments_are_those_of_the_gains() {
        let scene = scene(&["top_energy"]);
        let channels = Channels::new(&scene, &[], true).expect("valid");
        let rows = channels.of_layer(0);
        assert_eq!(channels.count(), 4);
        let response = &scene.detector_layers[0];
        let efficiency = response.efficiency().expect("known");
        let mut signals = [0.0; 4];
        channels.exact(&[0.0; 4], &mut signals);
        for (power, row) in rows.into_iter().enumerate() {
            let term = |k: usize| {
                let gain = response.factors()[k] / efficiency[k];
                scene.spectrum.weights()[k] * efficiency[k] * gain.powi(power as i32)
            };
            let sum: f64 = (0..136).map(term).sum();
            assert!((signals[row] / sum - 1.0).abs() < 1e-12, "{power}");
        }
        // One sum is all that a detector that counts needs.
        let counting = self::scene(&["top_counting"]);
        assert_eq!(Channels::new(&counting, &[], true).expect("valid").count(), 1);
        let own = DetectorResponse::new("own", *scene.spectrum.grid(), vec![2.0; 136]).expect("valid");
        let own = Scene { detector_layers: vec![own], ..scene };
        assert!(Channels::new(&own, &[], false).is_ok());
        let message = Channels::new(&own, &[], true).expect_err("not known").to_string();
        assert!(message.contains("detection efficiency"), "{message}");
    }
}
