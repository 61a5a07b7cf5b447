//! Exposures: the march once, images of it as often as wanted.

use drr::effects::{DetectorBlur, Effects, FocalSpot, Heel, Noise, Scatter};
use drr::engine::{Images, Layers, SILENT};
use drr::physics::Spectrum;
use drr::{Algorithm, Scene};

use crate::stand::{SIGNALS, block, projector, response, scene, view};

/// Two roundings of what is the same to float32: sums over energies, ray by ray and of rays side by side.
fn assert_same(a: &Images<f32>, b: &Images<f32>, what: &str) {
    for (a, b) in a.line_integral.iter().zip(&b.line_integral) {
        assert!((a - b).abs() <= 3e-7 * b + 1e-7, "{what}: {a} {b}");
    }
    for (a, b) in a.intensity.iter().zip(&b.intensity) {
        assert!((a - b).abs() <= 3e-7 * b, "{what}: {a} {b}");
    }
}

#[test]
fn a_second_spectrum_is_what_a_second_projection_would_be() {
    let volume = block();
    for supersampling in [1, 2] {
        let first = Scene { supersampling, ..scene(Effects::default()) };
        let exposure = projector(&volume, first.clone()).expose(&[view(3.0)], SILENT).expect("exposes");
        let spectrum = Spectrum::named("W60_2p5Al", *first.spectrum.grid()).expect("built in");
        let effects = Effects { fall_off: true, heel: Some(Heel::TYPICAL), ..Effects::default() };
        let detector_layers = ["top_energy", "bottom_energy"].map(response).to_vec();
        for second in [
            first.clone(),
            Scene { spectrum, ..first.clone() },
            Scene { effects, ..first.clone() },
            Scene { detector_layers, ..first.clone() },
        ] {
            let (developed, _) = exposure.develop(&second, Layers::ALL).expect("develops");
            let fresh =
                projector(&volume, second).project(&[view(3.0)], Layers::ALL, SILENT).expect("projects");
            assert_same(&developed, &fresh, &format!("{supersampling}"));
            for (a, b) in developed.areal_density.iter().zip(&fresh.areal_density) {
                assert!((a - b).abs() <= 1e-6 * b + 1e-7, "{a} {b}");
            }
            assert!(developed.bone_path.iter().zip(&fresh.bone_path).all(|(a, b)| (a - b).abs() < 1e-4));
        }
    }
}

#[test]
fn other_rays_and_other_matter_are_refused() {
    let first = scene(Effects::default());
    let exposure = projector(&block(), first.clone()).expose(&[view(3.0)], SILENT).expect("exposes");
    let focal_spot = Some(FocalSpot { width_mm: 1.0, height_mm: 1.0 });
    for (other, name) in [
        (Scene { detector: [20, 20], ..first.clone() }, "scene.detector"),
        (Scene { supersampling: 2, ..first.clone() }, "scene.supersampling"),
        (Scene { bone: None, ..first.clone() }, "scene.bone"),
        (
            Scene { effects: Effects { focal_spot, ..Effects::default() }, ..first.clone() },
            "scene.effects.focal_spot",
        ),
    ] {
        let message = exposure.develop(&other, SIGNALS).expect_err("refused").to_string();
        assert!(message.starts_with(name) && message.contains("rays have been cast"), "{message}");
    }
}

/// Every effect at once, in float32 against float64.
#[test]
fn everything_at_once_keeps_the_bounds_of_its_parts() {
    let volume = block();
    let all = Effects {
        fall_off: true,
        heel: Some(Heel::TYPICAL),
        focal_spot: Some(FocalSpot { width_mm: 6.0, height_mm: 4.0 }),
        scatter: Some(Scatter { histories: 1000, seed: 1 }),
        detector_blur: Some(DetectorBlur::gaussians(&[(0.8, 3.0), (0.2, 12.0)]).expect("valid")),
        ..Effects::default()
    };
    let detector_layers = ["top_energy", "bottom_energy"].map(response).to_vec();
    let projector = projector(&volume, Scene { detector_layers, supersampling: 2, ..scene(all) });
    let fast = projector.project(&[view(3.0)], Layers::ALL, SILENT).expect("projects");
    let twin = projector.reference(Algorithm::Joseph, &[view(3.0)], Layers::ALL, SILENT).expect("projects");
    for (a, b) in fast.line_integral.iter().zip(&twin.line_integral) {
        assert!((f64::from(*a) - b).abs() <= 2e-6 * b + 1e-6, "{a} {b}");
    }
    for (a, b) in fast.areal_density.iter().zip(&twin.areal_density) {
        assert!((f64::from(*a) - b).abs() <= 1e-6 * b + 5e-6, "{a} {b}");
    }
}

/// With nothing asked for, nothing but the plain image's code runs.
#[test]
fn effects_off_are_the_plain_image_bit_for_bit() {
    let volume = block();
    let plain = projector(&volume, scene(Effects::default()));
    let (images, stages) = plain.project_timed(&[view(3.0)], SIGNALS, SILENT).expect("projects");
    assert!(stages.seconds().is_empty(), "no stage of an effect ran");
    let stated = Scene {
        effects: Effects { noise: None::<Noise>, ..Effects::default() },
        ..scene(Effects::default())
    };
    assert_eq!(images, projector(&volume, stated).project(&[view(3.0)], SIGNALS, SILENT).expect("projects"));
    let exposure = plain.expose(&[view(3.0)], SILENT).expect("exposes");
    let (developed, stages) = exposure.develop(plain.scene(), SIGNALS).expect("develops");
    assert_same(&developed, &images, "developed");
    let names: Vec<_> = stages.seconds().into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["energies"]);
}
