//! A pair of views finds the object again.

use std::sync::Arc;

use glam::DVec3;

use super::*;
use crate::alignment::PhotonNoise;
use crate::context::Context;
use crate::engine::Backend;
use crate::geometry::DetectorPose;
use crate::registration::phantom::{SIZE, pair, registrar};

const TRUTH: RigidMotion =
    RigidMotion { angles: [0.02, -0.05, 0.03], translation: DVec3::new(3.0, -2.0, 1.0) };

/// 2° and 4 mm off in every parameter.
fn start() -> RigidMotion {
    let off = [1.0, -1.0, 1.0].map(|sign| sign * 2.0_f64.to_radians());
    let angles = std::array::from_fn(|axis| TRUTH.angles[axis] + off[axis]);
    RigidMotion { angles, translation: TRUTH.translation + DVec3::new(-4.0, 4.0, 4.0) }
}

fn silent(_: usize, _: &Step<6>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

#[test]
fn a_noisy_stereo_pair_recovers_two_degrees_and_four_millimetres() {
    let registrar = registrar::<f32>(2, 3);
    let poses = pair(registrar.finest().volume().grid());
    let noise = PhotonNoise { photons: 1e6, seed: 11 };
    let images: Vec<Vec<f32>> = poses
        .iter()
        .enumerate()
        .map(|(v, pose)| {
            let mut image = registrar.finest().project(pose, &TRUTH, Signal::LineIntegral).expect("valid");
            noise.apply(v, SIZE[0], &mut image);
            image
        })
        .collect();
    let views: Vec<_> = poses
        .iter()
        .zip(&images)
        .map(|(&pose, measured)| RegistrationView { pose, measured, mask: None })
        .collect();
    let options = RegistrationOptions::default();
    let found = registrar.register(&views, &start(), &options, &mut silent).expect("valid");
    let deviations = found.standard_deviations().expect("all six");
    let off: [f64; 6] = std::array::from_fn(|k| found.motion.to_array()[k] - TRUTH.to_array()[k]);
    assert!(found.stop().converged());
    for (k, off) in off.into_iter().enumerate() {
        assert!(off.abs() < 4.0 * deviations[k], "parameter {k}: {off:e}, {:e}", deviations[k]);
        // Depth, along y, is told by parallax of 6° alone.
        let limit = [0.02_f64.to_radians(), 0.02_f64.to_radians(), 0.02_f64.to_radians(), 0.05, 0.5, 0.05][k];
        assert!(off.abs() < limit, "parameter {k}: {off:e}");
    }
    let [across, depth] = [deviations[3], deviations[4]];
    assert!(depth > 3.0 * across && depth < 30.0 * across, "{depth} mm, {across} mm across");
    assert_eq!(found.levels.len(), 3);
}

#[test]
fn levels_pass_on_what_they_find_and_a_report_can_stop() {
    let registrar = registrar::<f64>(1, 2);
    let pose = pair(registrar.finest().volume().grid())[0];
    let image = registrar.finest().project(&pose, &TRUTH, Signal::Intensity).expect("valid");
    let mask: Vec<bool> = (0..image.len()).map(|n| n % SIZE[0] > 3).collect();
    let views = [RegistrationView { pose, measured: &image, mask: Some(&mask) }];
    let options = RegistrationOptions { signal: Signal::Intensity, ..RegistrationOptions::default() };
    let found = registrar.register(&views, &start(), &options, &mut silent).expect("valid");
    let counted = mask.iter().filter(|counts| **counts).count();
    assert_eq!(found.levels[1].equations.rays, counted);
    assert_eq!(found.levels[1].steps[0].parameters, found.levels[0].parameters);
    let loss = |level: usize| found.levels[level].equations.loss;
    assert!(loss(1) < 1e-6 * found.levels[1].steps[0].loss, "{:e}", loss(1));
    let stopped = &mut |level: usize, step: &Step<6>| {
        if level == 1 && step.iteration == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let cut = registrar.register(&views, &start(), &options, stopped).expect("valid");
    assert_eq!((cut.stop(), cut.levels[1].steps.len()), (Stop::Cancelled, 2));
    assert_eq!(cut.levels[0], found.levels[0]);
}

#[test]
fn what_is_not_valid_is_refused_by_name() {
    let registrar = registrar::<f32>(1, 1);
    let pose = pair(registrar.finest().volume().grid())[0];
    let refused = |views: &[RegistrationView<'_, f32>], start: &RigidMotion| {
        let options = RegistrationOptions::default();
        registrar.register(views, start, &options, &mut silent).expect_err("not valid").to_string()
    };
    assert!(refused(&[], &TRUTH).starts_with("views is empty"));
    let view = RegistrationView { pose, measured: &[0.0; 3], mask: None };
    assert!(refused(&[view], &TRUTH).starts_with("views[0].measured's length is 3"));
    let image = vec![0.0; SIZE[0] * SIZE[1]];
    let view = RegistrationView { pose, measured: &image, mask: None };
    let nan = RigidMotion { angles: [f64::NAN, 0.0, 0.0], ..TRUTH };
    assert!(refused(&[view], &nan).starts_with("start.alpha is NaN"));
    let lost = RegistrationView { pose: DetectorPose { source: pose.first_pixel, ..pose }, ..view };
    assert!(refused(&[view, lost], &TRUTH).starts_with("views[1].source is"));
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let scene = crate::Scene::new(SIZE).expect("valid");
    for levels in [0, 7] {
        let volume: Arc<_> = registrar.finest().volume().clone();
        let error = Registrar::<f32>::new(&context, volume, &scene, levels).err().expect("levels");
        assert_eq!(
            error.to_string(),
            format!("levels is {levels}; valid: 1 … 6 for a detector of 48 × 48 pixels")
        );
    }
}
