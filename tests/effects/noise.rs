//! Noise: its mean, its variance, and that it is last.

use drr::Scene;
use drr::effects::{DetectorBlur, Effects, FillFactor, Noise};
use drr::engine::{Backend, SILENT};
use drr::{Context, Projector};

use crate::stand::{SIDE, SIGNALS, block, image, intensity, mean, nothing, response, scene, variance, view};

const QUANTUM: Noise = Noise { photons_per_pixel: 400.0, quantum: true, electronic_photons: 0.0, seed: 7 };

fn noisy(noise: Noise) -> Effects {
    Effects { noise: Some(noise), ..Effects::default() }
}

fn differences(with: &[f64], without: &[f64]) -> Vec<f64> {
    with.iter().zip(without).map(|(a, b)| a - b).collect()
}

/// Pixels of an open field are independent: both estimates are within five standard errors.
fn check(values: &[f64], expected_mean: f64, expected_variance: f64) {
    let (n, mean, variance) = (values.len() as f64, mean(values), variance(values));
    assert!((mean - expected_mean).abs() < 5.0 * (expected_variance / n).sqrt(), "{mean} {expected_mean}");
    assert!(
        (variance / expected_variance - 1.0).abs() < 5.0 * (2.5 / n).sqrt(),
        "{variance} {expected_variance}"
    );
}

#[test]
fn a_counting_detector_s_open_field_is_poisson() {
    let open = intensity(&nothing(), noisy(QUANTUM));
    check(&open, 1.0, 1.0 / 400.0);
    // Counts are whole.
    assert!(open.iter().all(|x| (x * 400.0 - (x * 400.0).round()).abs() < 1e-4));
}

#[test]
fn an_integrating_detector_s_noise_is_that_of_its_gains() {
    let response = response("top_energy");
    let scene = Scene { detector_layers: vec![response.clone()], ..scene(noisy(QUANTUM)) };
    let weights = scene.spectrum.weights().to_vec();
    let efficiency = response.efficiency().expect("known");
    let moment = |power: i32| -> f64 {
        let gain = |k: usize| response.factors()[k] / efficiency[k];
        (0..weights.len()).map(|k| weights[k] * efficiency[k] * gain(k).powi(power)).sum()
    };
    let open: Vec<f64> = image(&nothing(), scene).intensity.into_iter().map(f64::from).collect();
    check(&open, moment(1), moment(2) / 400.0);
    // More than that of as many photons of one gain: Swank's factor.
    assert!(moment(2) * moment(0) / moment(1).powi(2) > 1.02);
}

#[test]
fn electronic_noise_is_added_to_the_signal() {
    let both = Noise { electronic_photons: 15.0, ..QUANTUM };
    check(&intensity(&nothing(), noisy(both)), 1.0, (400.0 + 15.0 * 15.0) / (400.0 * 400.0));
    let only = Noise { quantum: false, ..both };
    check(&intensity(&nothing(), noisy(only)), 1.0, (15.0 / 400.0_f64).powi(2));
}

/// In mean signals of one detected photon, whether quantum noise is there or not.
#[test]
fn electronic_noise_of_an_integrating_detector_is_in_its_mean_gains() {
    let response = response("top_energy");
    let only = Noise { quantum: false, electronic_photons: 15.0, ..QUANTUM };
    let scene = Scene { detector_layers: vec![response.clone()], ..scene(noisy(only)) };
    let sum = |factors: &[f64]| -> f64 {
        scene.spectrum.weights().iter().zip(factors).map(|(weight, factor)| weight * factor).sum()
    };
    let (signal, detected) = (sum(response.factors()), sum(response.efficiency().expect("known")));
    let open: Vec<f64> = image(&nothing(), scene).intensity.into_iter().map(f64::from).collect();
    check(&open, signal, (15.0 * signal / detected / 400.0).powi(2));
}

/// Blur comes before noise: neighbours' noise stays independent, and the variance is that of the blurred signal.
#[test]
fn noise_is_white_behind_a_blur() {
    let blur = DetectorBlur::gaussians(&[(1.0, 6.0)]).expect("valid");
    let with = Effects { detector_blur: Some(blur.clone()), ..noisy(QUANTUM) };
    let without = Effects { detector_blur: Some(blur), ..Effects::default() };
    let volume = block();
    let (with, without) = (intensity(&volume, with), intensity(&volume, without));
    let scaled: Vec<f64> = differences(&with, &without)
        .iter()
        .zip(&without)
        .map(|(d, mean)| d / (mean / 400.0).sqrt())
        .collect();
    check(&scaled, 0.0, 1.0);
    let neighbours: f64 = scaled.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / scaled.len() as f64;
    assert!(neighbours.abs() < 5.0 / (scaled.len() as f64).sqrt(), "{neighbours}");
}

/// The active area comes before noise: half as many photons, twice the relative variance.
#[test]
fn an_active_area_detects_fewer_photons() {
    let fill_factor = Some(FillFactor::new(0.5).expect("valid"));
    let open = intensity(&nothing(), Effects { fill_factor, ..noisy(QUANTUM) });
    check(&open, 0.5, 0.5 / 400.0);
}

#[test]
fn the_same_seed_gives_the_same_image_for_any_threads_and_another_does_not() {
    let volume = block();
    let with = |threads: usize, seed: u64| {
        let context = Context::new(Backend::Cpu, threads).expect("threads start");
        let effects = Effects {
            detector_blur: Some(DetectorBlur::gaussians(&[(1.0, 4.0)]).expect("valid")),
            ..noisy(Noise { seed, electronic_photons: 2.0, ..QUANTUM })
        };
        let projector = Projector::new(&context, volume.clone(), scene(effects)).expect("valid");
        projector.project(&[view(3.0), view(3.0)], SIGNALS, SILENT).expect("projects")
    };
    let one = with(1, 1);
    assert_eq!(one, with(3, 1));
    let other = with(1, 2);
    let different = one.intensity.iter().zip(&other.intensity).filter(|(a, b)| a != b).count();
    assert!(different > SIDE * SIDE, "{different}");
    // Two views of one call have noise of their own.
    assert_ne!(one.view(&one.intensity, 0), one.view(&one.intensity, 1));
}

/// Engines agree to rounding, so that a mean may pass a step of the Poisson distribution: then by one photon.
#[test]
fn the_reference_engine_draws_the_same_photons() {
    let projector = crate::stand::projector(&block(), scene(noisy(QUANTUM)));
    let fast = projector.project(&[view(3.0)], SIGNALS, SILENT).expect("projects");
    let twin = projector.reference(drr::Algorithm::Joseph, &[view(3.0)], SIGNALS, SILENT).expect("projects");
    let off = |k: usize| (f64::from(fast.intensity[k]) - twin.intensity[k]).abs() * 400.0;
    let differ = (0..SIDE * SIDE).filter(|&k| off(k) > 1e-3).count();
    assert!(differ <= 3, "{differ}");
    assert!((0..SIDE * SIDE).all(|k| off(k) < 1.001));
}

#[test]
fn noise_without_a_dose_and_of_an_unknown_gain_are_refused() {
    let error = |noise: Noise| scene(noisy(noise)).validate().expect_err("refused").to_string();
    let message = error(Noise { photons_per_pixel: 0.0, ..QUANTUM });
    assert!(message.contains("photons_per_pixel is 0") && message.contains("dose"), "{message}");
    assert!(error(Noise { quantum: false, ..QUANTUM }).contains("quantum"));
    let own = drr::physics::DetectorResponse::new(
        "own",
        *scene(Effects::default()).spectrum.grid(),
        vec![3.0; 136],
    );
    let own = Scene { detector_layers: vec![own.expect("valid")], ..scene(noisy(QUANTUM)) };
    let message = own.validate().expect_err("no efficiency").to_string();
    assert!(message.contains("detector_layers[0]") && message.contains("efficiency"), "{message}");
}
