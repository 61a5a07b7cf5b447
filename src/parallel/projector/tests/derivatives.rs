//! Derivatives at poses drawn at random, against central differences; what float32 makes of them.

use super::*;
use crate::parallel::frame::Frame;

/// Poses up to ±0.6 rad and ±2 mm, the same ones each time.
fn poses(count: usize) -> Vec<ViewParameters> {
    let mut state = 20_260_117_u64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    let mut pose = || [0.6, 0.6, 0.6, 2.0, 2.0].map(|most| most * uniform());
    (0..count).map(|_| ViewParameters::from_array(pose())).collect()
}

fn moved(view: &ViewParameters, k: usize, by: f64) -> ViewParameters {
    let mut view = view.to_array();
    view[k] += by;
    ViewParameters::from_array(view)
}

/// Pixels none of whose samples changes cells, along any axis, when a parameter moves by ±h: sums over steps have
/// kinks at faces, which differences across them would see.
fn smooth(view: &ViewParameters, h: f64) -> Vec<bool> {
    let geometry = geometry();
    let frames: Vec<[Frame; 2]> =
        (0..5).map(|k| [h, -h].map(|by| Frame::new(&geometry, &moved(view, k, by)))).collect();
    let same = |u: usize, v: usize| {
        let middle = 0.5 * (geometry.steps as f64 - 1.0);
        let cell =
            |frame: &Frame, step: usize| (frame.at(u, v) + (step as f64 - middle) * frame.step).floor();
        frames.iter().all(|[a, b]| (0..geometry.steps).all(|step| cell(a, step) == cell(b, step)))
    };
    (0..geometry.pixels()).map(|pixel| same(pixel % 11, pixel / 11)).collect()
}

fn off(a: &[f64], b: &[f64]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| a - b)) / largest(b.iter().copied())
}

#[test]
fn image_loss_gradient_and_hessian_are_those_of_differences_at_any_pose() {
    let h = 1e-7;
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let truth = projector.forward_project_view(&VIEW, RaySelection::default()).expect("valid");
        let mut worst = [0.0_f64; 4];
        for view in poses(6) {
            let mask = smooth(&view, h);
            assert!(mask.iter().filter(|smooth| **smooth).count() > 135, "of 143");
            let rays = RaySelection { mask: Some(&mask), lengths: None };
            let image = |view: &ViewParameters| projector.forward_project_view(view, rays).expect("valid");
            let equations = |view: &ViewParameters| {
                projector.view_loss_value_and_grad(view, &truth, rays).expect("valid")
            };
            let jacobian = projector.view_jacobian(&view, rays).expect("valid");
            let at_home = equations(&view);
            let central = |k: usize| {
                let (after, before) = (image(&moved(&view, k, h)), image(&moved(&view, k, -h)));
                after.iter().zip(&before).map(|(a, b)| 0.5 * (a - b) / h).collect::<Vec<_>>()
            };
            let columns: [Vec<f64>; 5] = std::array::from_fn(central);
            let residuals: Vec<f64> =
                (0..truth.len()).map(|n| if mask[n] { jacobian.image[n] - truth[n] } else { 0.0 }).collect();
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let loss = |k: usize| {
                0.5 * (equations(&moved(&view, k, h)).loss - equations(&moved(&view, k, -h)).loss) / h
            };
            for (column, derivative) in columns.iter().zip(&jacobian.derivatives) {
                worst[0] = worst[0].max(off(column, derivative));
            }
            let losses: [f64; 5] = std::array::from_fn(loss);
            worst[1] = worst[1].max(off(&losses, &at_home.gradient));
            let gradient: [f64; 5] = std::array::from_fn(|k| dot(&columns[k], &residuals));
            worst[2] = worst[2].max(off(&gradient, &at_home.gradient));
            let products = (0..25).map(|n| dot(&columns[n / 5], &columns[n % 5])).collect::<Vec<_>>();
            worst[3] = worst[3].max(off(&products, at_home.hessian.as_flattened()));
        }
        assert!(worst.iter().all(|off| *off < 1e-7), "{quadrature:?}: {worst:?}");
    }
}

#[test]
fn differences_err_first_by_their_step_then_by_rounding() {
    // Of the exact quadrature, whose image has no kinks: h², until eps/h is more.
    let projector = projector(Quadrature::Exact);
    let rays = RaySelection::default();
    let exact = projector.view_jacobian(&VIEW, rays).expect("valid");
    let error = |h: f64| {
        let image = |by: f64| projector.forward_project_view(&moved(&VIEW, 2, by), rays).expect("valid");
        let differences: Vec<f64> = image(h).iter().zip(&image(-h)).map(|(a, b)| 0.5 * (a - b) / h).collect();
        off(&differences, &exact.derivatives[2])
    };
    let errors = [1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12].map(error);
    assert!(errors[..4].windows(2).all(|pair| pair[1] < 0.2 * pair[0]), "{errors:?}");
    assert!(errors[4..].windows(2).all(|pair| pair[1] > 5.0 * pair[0]), "{errors:?}");
}

#[test]
fn float32_derivatives_are_float64s_on_a_smooth_volume() {
    // 32 voxels a wave: neighbouring ones differ by a fifth of the amplitude at most. Runs and single fetches.
    let geometry = ParallelGeometry::new([40, 44, 48], DVec3::ONE, [37, 41], [1.1, 1.0]);
    let at = |n: usize| [n % 40, n / 40 % 44, n / 1760].map(|i| 0.2 * i as f64);
    let value = |n: usize| {
        let [x, y, z] = at(n);
        0.02 + 0.01 * x.sin() * (y + 0.5).cos() * (z - 0.3).sin()
    };
    let wide: Vec<f64> = (0..40 * 44 * 48).map(value).collect();
    let narrow: Vec<f32> = wide.iter().map(|value| *value as f32).collect();
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let wide = ParallelProjector::new(&context, geometry, quadrature, &wide).expect("valid");
        let narrow = ParallelProjector::new(&context, geometry, quadrature, &narrow).expect("valid");
        let mut worst = 0.0_f64;
        for view in poses(2).into_iter().chain([ViewParameters { alpha: 0.01, beta: -0.02, ..VIEW }]) {
            let wide = wide.view_jacobian(&view, RaySelection::default()).expect("valid");
            let narrow = narrow.view_jacobian(&view, RaySelection::default()).expect("valid");
            for (narrow, wide) in narrow.derivatives.iter().zip(&wide.derivatives) {
                let narrow: Vec<f64> = narrow.iter().copied().map(f64::from).collect();
                worst = worst.max(off(&narrow, wide));
            }
        }
        assert!(worst < 5e-6, "{quadrature:?}: {worst:e}");
    }
}
