//! Noise against the sum over all energies.

use super::*;
use crate::effects::noise::poisson::poisson_quantile;
use crate::effects::noise::sample::Sample;
use crate::physics::{DetectorResponse, EnergyGrid, Spectrum};

const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;
const QUANTUM: Noise = Noise { photons_per_pixel: 1e4, quantum: true, electronic_photons: 0.0, seed: 11 };

/// Gain and detected photons per photon of dose, bin by bin, of an energy-integrating layer.
fn bins(layer: &str) -> Vec<(f64, f64)> {
    let tube = Spectrum::named(Spectrum::DEFAULT, GRID).unwrap();
    let factors = |kind: &str| DetectorResponse::named(&format!("{layer}_{kind}"), GRID).unwrap();
    let (counted, energy) = (factors("counting"), factors("energy"));
    let photons = tube.weights().iter().zip(counted.factors()).map(|(w, a)| w * a);
    let gains = energy.factors().iter().zip(counted.factors()).map(|(e, a)| e / a);
    gains.zip(photons).filter(|(_, photons)| *photons > 0.0).collect()
}

fn moments(bins: &[(f64, f64)]) -> [f64; 4] {
    [0, 1, 2, 3].map(|r| bins.iter().map(|(gain, photons)| photons * gain.powi(r)).sum())
}

fn flat(size: [usize; 2], moments: [f64; 4]) -> [Plane; 4] {
    moments.map(|moment| Plane::filled(size, moment).unwrap())
}

fn image(noise: &Noise, planes: &[Plane; 4], view: usize, layer: usize) -> Plane {
    noise.applied(planes.each_ref(), 50.0, view, layer).unwrap()
}

/// Signals whose every bin has a Poisson number of its own, per photon of dose.
fn slow(bins: &[(f64, f64)], dose: f64, count: usize) -> Sample {
    let mut signals = vec![0.0; count];
    for (k, (gain, photons)) in bins.iter().enumerate() {
        let mut random = RowRandom::new(99, 0, 0, k);
        for three in signals.chunks_mut(3) {
            let counts = random.draws().map(|u| poisson_quantile(u, photons * dose));
            three.iter_mut().zip(counts).for_each(|(signal, count)| *signal += gain * count / dose);
        }
    }
    Sample::new(signals)
}

/// Mean, variance and third central moment per photon of dose.
fn cumulants([_, m1, m2, m3]: [f64; 4], dose: f64) -> [f64; 3] {
    [m1, m2 / dose, m3 / (dose * dose)]
}

#[test]
fn an_open_field_has_the_moments_of_all_energies() {
    for (view, layer) in ["top", "bottom"].into_iter().enumerate() {
        let moments = moments(&bins(layer));
        let planes = flat([1000, 1000], moments);
        for detected in [0.3, 30.0, 1e4] {
            let dose = detected / moments[0];
            let noise = Noise { photons_per_pixel: dose, ..QUANTUM };
            let sample = Sample::new(image(&noise, &planes, view, view).values().to_vec());
            sample.assert_cumulants(cumulants(moments, dose), &format!("{layer}, {detected} photons"));
            let nothing = (-detected).exp();
            let error = 5.0 * (nothing / 1e6).sqrt();
            assert!((sample.share_of(0.0) - nothing).abs() <= error, "{layer}, {detected} photons");
        }
    }
}

#[test]
fn two_poisson_numbers_are_distributed_as_those_of_all_energies() {
    let bins = bins("top");
    let moments = moments(&bins);
    let count = 30_000;
    let planes = flat([200, count / 200], moments);
    // Of one photon the signal is one of two gains, not of all; among many photons that is lost.
    for (detected, beyond_chance) in [(0.3, 0.1), (30.0, 0.01), (1e4, 0.0)] {
        let dose = detected / moments[0];
        let slow = slow(&bins, dose, count);
        slow.assert_cumulants(cumulants(moments, dose), &format!("all energies, {detected} photons"));
        let noise = Noise { photons_per_pixel: dose, ..QUANTUM };
        let fast = Sample::new(image(&noise, &planes, 0, 0).values().to_vec());
        // Exceeded by chance once in a thousand.
        let chance = 1.95 * (2.0 / count as f64).sqrt();
        let distance = fast.distance(&slow);
        assert!(distance < chance + beyond_chance, "{detected} photons: {distance}");
    }
}

#[test]
fn counted_photons_are_whole() {
    let planes = flat([100, 100], [0.01; 4]);
    let noise = Noise { photons_per_pixel: 1024.0, ..QUANTUM };
    let values = image(&noise, &planes, 0, 0).values().to_vec();
    assert!(values.iter().all(|value| (value * 1024.0).fract() == 0.0));
    Sample::new(values).assert_cumulants(cumulants([0.01; 4], 1024.0), "counted photons");
}

#[test]
fn electronic_noise_is_in_photons_of_mean_signal() {
    let moments = moments(&bins("top"));
    let planes = flat([500, 500], moments);
    for quantum in [true, false] {
        let noise = Noise { quantum, electronic_photons: 80.0, ..QUANTUM };
        let [mean, variance, third] = cumulants(moments, 1e4);
        let electronic = (80.0_f64 * 50.0 / 1e4).powi(2);
        let on = f64::from(u8::from(quantum));
        let sample = Sample::new(image(&noise, &planes, 0, 0).values().to_vec());
        sample.assert_cumulants([mean, on * variance + electronic, on * third], "electronic noise");
    }
}

#[test]
fn no_signal_is_no_noise() {
    let dark = flat([20, 20], [0.0; 4]);
    assert!(image(&QUANTUM, &dark, 0, 0).values().iter().all(|value| *value == 0.0));
    for size in [[0, 0], [0, 3], [3, 0]] {
        assert_eq!(image(&QUANTUM, &flat(size, [0.0; 4]), 0, 0).size(), size);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let planes = flat([61, 47], moments(&bins("top")));
    let noise = Noise { electronic_photons: 2.0, ..QUANTUM };
    let [one, two] = [1, 2].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let image = pool.install(|| image(&noise, &planes, 5, 1));
        image.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    });
    assert_eq!(one, two);
}

#[test]
fn seeds_views_layers_and_rows_know_nothing_of_each_other() {
    let size = [300, 300];
    let planes = flat(size, moments(&bins("top")));
    let noise = |seed| Noise { electronic_photons: 30.0, seed, ..QUANTUM };
    let images = [(11, 0, 0), (12, 0, 0), (11, 1, 0), (11, 0, 1), (11, 1, 1)]
        .map(|(seed, view, layer)| image(&noise(seed), &planes, view, layer).values().to_vec());
    let independent = |a: &[f64], b: &[f64], what: &str| {
        let [a, b] = [a, b].map(|values| Sample::new(values.to_vec()));
        let correlation = a.correlation(&b);
        assert!(correlation.abs() < 4.0 / 300.0, "{what}: {correlation}");
    };
    for (k, a) in images.iter().enumerate() {
        images[..k].iter().for_each(|b| independent(a, b, "images"));
        let last = a.len() - size[0];
        independent(&a[..last], &a[size[0]..], "rows");
        independent(&a[..a.len() - 1], &a[1..], "columns");
    }
}

#[test]
fn refusals_name_the_field_and_what_to_do() {
    let noise = Noise { electronic_photons: 3.0, ..QUANTUM };
    for photons_per_pixel in [f64::MIN_POSITIVE, 1.0, 1e12] {
        assert_eq!(Noise { photons_per_pixel, ..noise }.validate(), Ok(()));
    }
    for photons_per_pixel in [0.0, -1.0, 1.1e12, f64::NAN, f64::INFINITY] {
        let message = Noise { photons_per_pixel, ..noise }.validate().unwrap_err().to_string();
        assert!(message.starts_with("scene.effects.noise.photons_per_pixel is "), "{message}");
        assert!(message.contains("noise needs a dose"), "{message}");
    }
    for electronic_photons in [-1e-9, 1.1e6, f64::NAN, f64::INFINITY] {
        let message = Noise { electronic_photons, ..noise }.validate().unwrap_err().to_string();
        assert!(message.starts_with("scene.effects.noise.electronic_photons is "), "{message}");
    }
    for (quantum, electronic_photons) in [(true, 0.0), (false, 1e-3), (true, 1e6)] {
        assert_eq!(Noise { quantum, electronic_photons, ..noise }.validate(), Ok(()));
    }
    let message =
        Noise { quantum: false, electronic_photons: 0.0, ..noise }.validate().unwrap_err().to_string();
    assert!(message.starts_with("scene.effects.noise.quantum is false; valid: true, unless"), "{message}");
}
