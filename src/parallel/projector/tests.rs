//! Derivatives against differences, sums against closed forms.

use glam::DVec3;

use super::*;
use crate::engine::Backend;

mod arguments;
mod derivatives;
mod images;
mod kinks;
mod lengths;

/// Values without any symmetry.
fn volume(dimensions: [usize; 3]) -> Vec<f64> {
    let [nx, ny, nz] = dimensions;
    let value = |n: usize| {
        let [x, y, z] = [n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64);
        1.0 + (0.9 * x + 0.3 * y * z).sin() + 0.1 * ((n * 7919 % 1009) as f64 / 1009.0)
    };
    (0..nx * ny * nz).map(value).collect()
}

fn geometry() -> ParallelGeometry {
    let geometry = ParallelGeometry::new([9, 12, 10], DVec3::new(1.0, 1.3, 0.8), [11, 13], [0.9, 0.7]);
    ParallelGeometry { centre: DVec3::new(0.4, -3.0, 0.2), detector_centre: [0.1, -0.3], ..geometry }
}

fn projector(quadrature: Quadrature) -> ParallelProjector<f64> {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    ParallelProjector::new(&context, geometry(), quadrature, &volume(geometry().dimensions)).expect("valid")
}

const VIEW: ViewParameters = ViewParameters { alpha: 0.123, beta: -0.071, phi: 0.617, dx: 0.33, dz: -0.41 };

#[test]
fn derivatives_are_those_of_differences() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let rays = RaySelection::default();
        let jacobian = projector.view_jacobian(&VIEW, rays).expect("valid");
        for k in 0..5 {
            let moved = |by: f64| {
                let mut view = VIEW.to_array();
                view[k] += by;
                projector.forward_project_view(&ViewParameters::from_array(view), rays).expect("valid")
            };
            let h = 1e-7;
            let largest = jacobian.derivatives[k].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            let (after, before) = (moved(h), moved(-h));
            let differences = after.iter().zip(&before).map(|(a, b)| 0.5 * (a - b) / h);
            let off =
                differences.zip(&jacobian.derivatives[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-7 * largest, "{quadrature:?}, parameter {k}: {off:e} of {largest:e}");
        }
    }
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

#[test]
fn loss_gradient_and_hessian_are_those_of_the_jacobian() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let rays = RaySelection::default();
        let moved = ViewParameters { alpha: 0.1, dz: 0.2, ..VIEW };
        let measured = projector.forward_project_view(&moved, rays).expect("valid");
        let equations = projector.view_loss_value_and_grad(&VIEW, &measured, rays).expect("valid");
        let jacobian = projector.view_jacobian(&VIEW, rays).expect("valid");
        let residuals: Vec<f64> = jacobian.image.iter().zip(&measured).map(|(a, b)| a - b).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((equations.loss / (0.5 * dot(&residuals, &residuals)) - 1.0).abs() < 1e-12);
        for k in 0..5 {
            let gradient = dot(&jacobian.derivatives[k], &residuals);
            assert!((equations.gradient[k] - gradient).abs() < 1e-11 * gradient.abs(), "{k}");
            for l in 0..5 {
                let product = dot(&jacobian.derivatives[k], &jacobian.derivatives[l]);
                assert!((equations.hessian[k][l] - product).abs() < 1e-11 * equations.hessian[k][k].max(1.0));
            }
        }
        let at_home = projector.view_loss_value_and_grad(&moved, &measured, rays).expect("valid");
        assert_eq!((at_home.loss, at_home.gradient, at_home.rays), (0.0, [0.0; 5], 11 * 13));
    }
}

#[test]
fn an_affine_field_is_integrated_exactly_by_both() {
    // f = 2 + 0.3 x − 0.2 y + 0.1 z of the object, rays that stay inside: f at the middle of the part, times its length.
    let geometry = ParallelGeometry::new([40, 40, 40], DVec3::ONE, [4, 5], [1.7, 1.3]).with_step(0.5);
    let field = |q: DVec3| 2.0 + 0.3 * q.x - 0.2 * q.y + 0.1 * q.z;
    let at = |n: usize| DVec3::new((n % 40) as f64, (n / 40 % 40) as f64, (n / 1600) as f64) - 19.5;
    let values: Vec<f64> = (0..64_000).map(|n| field(at(n))).collect();
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    let lengths = vec![[-6.0, 5.0]; geometry.pixels()];
    let rays = RaySelection { lengths: Some(&lengths), mask: None };
    let back = VIEW.motion().rotation().transpose();
    for quadrature in [Quadrature::Exact, Quadrature::Steps] {
        let projector = ParallelProjector::new(&context, geometry, quadrature, &values).expect("valid");
        let image = projector.forward_project_view(&VIEW, rays).expect("valid");
        for (pixel, value) in image.iter().enumerate() {
            let world = geometry.pixel_position((pixel % 4) as f64, (pixel / 4) as f64) - 0.5 * DVec3::Y;
            let exact = 11.0 * field(back * (world - VIEW.motion().translation));
            assert!((value - exact).abs() < 1e-13 * exact.abs().max(1.0), "{quadrature:?}: {value} {exact}");
        }
    }
}

#[test]
fn steps_become_the_exact_integral_by_the_second_order() {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    let image = |quadrature: Quadrature, step: f64| {
        let geometry = ParallelGeometry { step, steps: (30.0 / step).round() as usize, ..geometry() };
        let volume = volume(geometry.dimensions);
        let projector = ParallelProjector::new(&context, geometry, quadrature, &volume).expect("valid");
        projector.forward_project_view(&VIEW, RaySelection::default()).expect("valid")
    };
    let exact = image(Quadrature::Exact, 1.0);
    // The mean square over rays, and over steps: where planes are crossed at whole steps, errors of single kinks
    // all add.
    let off = |scale: f64| {
        let steps = [0.89, 0.93, 0.97, 1.0, 1.03, 1.09, 1.13].map(|step| step * scale);
        let images = steps.map(|step| image(Quadrature::Steps, step));
        let squares = images.iter().flat_map(|image| image.iter().zip(&exact)).map(|(a, b)| (a - b).powi(2));
        squares.sum::<f64>().sqrt()
    };
    let order = (off(0.1) / off(0.01)).log10();
    assert!((order - 2.0).abs() < 0.2, "{order}");
}

#[test]
fn the_exact_integral_adds_over_parts_of_rays_and_masks_leave_zeros() {
    let projector = projector(Quadrature::Exact);
    let pixels = geometry().pixels();
    let part = |from: f64, to: f64| {
        let lengths = vec![[from, to]; pixels];
        let rays = RaySelection { lengths: Some(&lengths), mask: None };
        projector.forward_project_view(&VIEW, rays).expect("valid")
    };
    let [all, near, far] = [part(-40.0, 40.0), part(-40.0, -2.3), part(-2.3, 40.0)];
    let whole = projector.forward_project_view(&VIEW, RaySelection::default()).expect("valid");
    assert_eq!(all, whole);
    let most = largest(whole.iter().copied());
    assert!(largest((0..pixels).map(|n| near[n] + far[n] - all[n])) < 1e-13 * most);
    let mask: Vec<bool> = (0..pixels).map(|n| n % 3 == 1).collect();
    let rays = RaySelection { mask: Some(&mask), lengths: None };
    let some = projector.forward_project_view(&VIEW, rays).expect("valid");
    for n in 0..pixels {
        assert_eq!(some[n], if mask[n] { whole[n] } else { 0.0 });
    }
    let equations = projector.view_loss_value_and_grad(&VIEW, &some, rays).expect("valid");
    assert_eq!((equations.loss, equations.rays), (0.0, mask.iter().filter(|counts| **counts).count()));
}

#[test]
fn in_faces_the_derivative_is_one_of_the_sides() {
    // Rays of an object that is not moved run in the faces of cells: the loss has a kink there.
    let geometry = ParallelGeometry::new([8, 9, 10], DVec3::ONE, [8, 10], [1.0, 1.0]);
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let volume = volume(geometry.dimensions);
    let projector = ParallelProjector::new(&context, geometry, Quadrature::Steps, &volume).expect("valid");
    let rays = RaySelection::default();
    let still = projector.view_jacobian(&ViewParameters::default(), rays).expect("valid");
    for k in [3, 4] {
        let moved = |by: f64| {
            let mut view = [0.0; 5];
            view[k] = by;
            projector.forward_project_view(&ViewParameters::from_array(view), rays).expect("valid")
        };
        let (after, before) = (moved(1e-6), moved(-1e-6));
        for n in 0..geometry.pixels() {
            let [right, left] = [(after[n] - still.image[n]) * 1e6, (still.image[n] - before[n]) * 1e6];
            let d = still.derivatives[k][n];
            assert!(d > right.min(left) - 1e-7 && d < right.max(left) + 1e-7, "{k}, {n}: {left} {d} {right}");
        }
    }
}

#[test]
fn float32_is_the_same_for_any_number_of_threads_and_near_float64() {
    let wide = projector(Quadrature::Steps);
    let values: Vec<f32> = volume(geometry().dimensions).iter().map(|value| *value as f32).collect();
    let narrow = |threads: usize| {
        let context = Context::new(Backend::Cpu, threads).expect("threads");
        ParallelProjector::new(&context, geometry(), Quadrature::Steps, &values).expect("valid")
    };
    let view = ViewParameters { alpha: 0.02, beta: -0.01, ..VIEW };
    let rays = RaySelection::default();
    let measured = vec![1.5_f32; geometry().pixels()];
    let of = |threads: usize| narrow(threads).view_loss_value_and_grad(&view, &measured, rays);
    assert_eq!(of(1), of(2));
    assert_eq!(of(1), of(3));
    let exact = wide.view_loss_value_and_grad(&view, &vec![1.5; geometry().pixels()], rays).expect("valid");
    let near = of(1).expect("valid");
    assert!((near.loss / exact.loss - 1.0).abs() < 1e-6);
    let most = largest(exact.gradient.into_iter());
    assert!(largest((0..5).map(|k| near.gradient[k] - exact.gradient[k])) < 1e-5 * most);
}
