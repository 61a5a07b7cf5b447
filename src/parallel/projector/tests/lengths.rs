//! Parts of rays, and rays that do not count, in images, derivatives and losses.

use super::*;

fn part<T: Real>(projector: &ParallelProjector<T>, length: [f64; 2]) -> Vec<f64> {
    let lengths = vec![length; projector.geometry().pixels()];
    let rays = RaySelection { lengths: Some(&lengths), mask: None };
    let jacobian = projector.view_jacobian(&VIEW, rays).expect("valid");
    assert_eq!(projector.forward_project_view(&VIEW, rays).expect("valid"), jacobian.image);
    let planes = jacobian.derivatives.iter().flatten();
    jacobian.image.iter().chain(planes).map(|value| (*value).into()).collect()
}

/// Parts before and behind y = −2.3 mm, which lies within a step, against the whole; relative to the largest.
fn parts_add<T: Real>(projector: &ParallelProjector<T>) -> f64 {
    let [all, near, far] = [[-60.0, 60.0], [-60.0, -2.3], [-2.3, 60.0]].map(|length| part(projector, length));
    let whole = projector.view_jacobian(&VIEW, RaySelection::default()).expect("valid");
    let image: Vec<f64> = whole.image.iter().map(|value| (*value).into()).collect();
    let most = largest(image.iter().copied());
    let full = largest(image.iter().zip(&all).map(|(a, b)| a - b));
    let split = largest((0..all.len()).map(|n| near[n] + far[n] - all[n]));
    assert!(largest(near.iter().copied()) > 0.1 * most && largest(far.iter().copied()) > 0.1 * most);
    full.max(split) / most
}

#[test]
fn parts_of_rays_add_to_the_whole() {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    let narrow: Vec<f32> = volume(geometry().dimensions).iter().map(|value| *value as f32).collect();
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let narrow = ParallelProjector::new(&context, geometry(), quadrature, &narrow).expect("valid");
        let (wide, narrow) = (parts_add(&projector(quadrature)), parts_add(&narrow));
        assert!(wide < 1e-14 && narrow < 4e-6, "{quadrature:?}: {wide:e} {narrow:e}");
    }
}

#[test]
fn of_the_steps_at_an_intervals_ends_the_part_inside_counts() {
    // In a field that is 3 everywhere along the part: 3 times its length, however it lies in the steps.
    let geometry = ParallelGeometry::new([30; 3], DVec3::ONE, [3, 2], [1.7, 1.3]).with_step(0.7);
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let values = vec![3.0; 27_000];
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = ParallelProjector::new(&context, geometry, quadrature, &values).expect("valid");
        for [from, to] in [[-1.23, 0.71], [0.01, 0.02], [0.35, 1.05], [2.0, 2.0], [-6.0, 7.1]] {
            let lengths = vec![[from, to]; 6];
            let rays = RaySelection { lengths: Some(&lengths), mask: None };
            let image = projector.forward_project_view(&VIEW, rays).expect("valid");
            let off = largest(image.iter().map(|value| value - 3.0 * (to - from)));
            assert!(off < 1e-13, "{quadrature:?}, {from} … {to}: {off:e}");
        }
    }
}

#[test]
fn losses_are_of_the_rays_that_count_and_of_their_parts() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let pixels = geometry().pixels();
        let mask: Vec<bool> = (0..pixels).map(|n| n % 5 < 2).collect();
        let lengths: Vec<_> = (0..pixels).map(|n| [-9.0 + 0.02 * n as f64, 0.5 + 0.01 * n as f64]).collect();
        let rays = RaySelection { mask: Some(&mask), lengths: Some(&lengths) };
        let measured: Vec<f64> = (0..pixels).map(|n| if mask[n] { 2.0 } else { f64::NAN }).collect();
        let equations = projector.view_loss_value_and_grad(&VIEW, &measured, rays).expect("valid");
        let jacobian = projector
            .view_jacobian(&VIEW, RaySelection { mask: None, lengths: Some(&lengths) })
            .expect("valid");
        let mut sum = NormalEquations::<5>::default();
        for n in (0..pixels).filter(|n| mask[*n]) {
            sum.add(jacobian.image[n] - 2.0, &std::array::from_fn(|k| jacobian.derivatives[k][n]));
        }
        assert_eq!((equations.rays, sum.rays), (58, 58));
        assert!((equations.loss / sum.loss - 1.0).abs() < 1e-13, "{quadrature:?}");
        let most = largest(sum.hessian.as_flattened().iter().copied());
        for k in 0..5 {
            let off = largest((0..5).map(|l| equations.hessian[k][l] - sum.hessian[k][l]));
            assert!(off < 1e-13 * most, "{quadrature:?}, {k}: {off:e}");
            let off = (equations.gradient[k] - sum.gradient[k]).abs();
            assert!(off < 1e-13 * largest(sum.gradient.into_iter()), "{quadrature:?}, {k}: {off:e}");
        }
    }
}
