//! Parallel beams: values, derivatives and normal equations against the float64 twin on the CPU.

use std::f64::consts::PI;

use drr::engine::Backend;
use drr::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection, ViewParameters};
use drr::{Context, Error};
use glam::DVec3;

use crate::support::{noise, relative_l2};

pub(super) const TESTS: [super::Test; 5] = [
    ("parallel::values_and_derivatives_are_the_twin_s", values_and_derivatives_are_the_twin_s),
    ("parallel::masks_and_lengths_are_the_twin_s", masks_and_lengths_are_the_twin_s),
    ("parallel::batches_are_their_views", batches_are_their_views),
    ("parallel::samples_on_planes_are_the_upper_cell_s", samples_on_planes_are_the_upper_cell_s),
    ("parallel::what_it_lacks_is_refused", what_it_lacks_is_refused),
];

/// Of values, relative L2.
const VALUES: f64 = 2e-6;
/// Of derivatives, of the largest.
const DERIVATIVES: f64 = 1e-5;

fn volume(dimensions: [usize; 3]) -> Vec<f32> {
    let [nx, ny, nz] = dimensions.map(|n| n as f64);
    let value = |n: usize| {
        let [i, j, k] =
            [n % dimensions[0], n / dimensions[0] % dimensions[1], n / (dimensions[0] * dimensions[1])];
        let [x, y, z] = [i as f64 / nx, j as f64 / ny, k as f64 / nz];
        (0.02 + 0.01 * (7.0 * x + 3.0 * y * z).sin() + 0.01 * noise(n as u64)) as f32
    };
    (0..dimensions.iter().product()).map(value).collect()
}

/// Detectors that see more than the volume, and steps that leave it.
fn geometries() -> Vec<ParallelGeometry> {
    let plain = ParallelGeometry::new([40, 36, 44], DVec3::new(1.0, 1.3, 0.8), [50, 41], [0.9, 1.1]);
    let small = ParallelGeometry::new([1, 2, 3], DVec3::new(2.0, 0.5, 1.0), [7, 5], [0.7, 0.9]);
    vec![
        ParallelGeometry { steps: 90, ..plain },
        ParallelGeometry {
            centre: DVec3::new(430.0, -77.0, 1210.0),
            detector_centre: [431.0, 1207.0],
            ..plain
        },
        plain.with_step(0.21),
        plain.with_step(3.7),
        ParallelGeometry { steps: 2000, ..plain },
        ParallelGeometry { steps: 40, step: 0.25, ..small },
    ]
}

fn views() -> Vec<ViewParameters> {
    let random = |n: u64| 2.0 * noise(n) - 1.0;
    let mut views: Vec<_> = (0..6)
        .map(|n| ViewParameters {
            alpha: 0.4 * random(5 * n),
            beta: 0.4 * random(5 * n + 1),
            phi: PI * random(5 * n + 2),
            dx: 5.0 * random(5 * n + 3),
            dz: 5.0 * random(5 * n + 4),
        })
        .collect();
    // Rays that miss the volume, and some that are almost along its planes.
    views.push(ViewParameters { dx: 1e4, ..views[0] });
    views.push(ViewParameters { alpha: 1e-5, beta: 0.013, phi: -2e-7, dx: 0.111, dz: 0.073 });
    views
}

fn projectors(
    backend: Backend,
    geometry: ParallelGeometry,
) -> (ParallelProjector<f32>, ParallelProjector<f64>) {
    let context = |backend| Context::new(backend, 2).expect("threads start");
    let values = volume(geometry.dimensions);
    let wide: Vec<f64> = values.iter().map(|&value| value.into()).collect();
    let made = ParallelProjector::new(&context(backend), geometry, Quadrature::Steps, &values);
    let twin = ParallelProjector::new(&context(Backend::Cpu), geometry, Quadrature::Steps, &wide);
    (made.expect("valid"), twin.expect("valid"))
}

/// Largest difference, of the largest value.
fn of_largest(x: &[f64], truth: &[f64]) -> f64 {
    let largest = truth.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    let off = x.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if off == 0.0 { 0.0 } else { off / largest }
}

fn hold(what: &str, error: f64, bound: f64) {
    assert!(error <= bound, "{what}: {error:.2e} for {bound:.0e}");
}

/// Holds all that one view gives to the twin.
fn conforms(
    (projector, twin): &(ParallelProjector<f32>, ParallelProjector<f64>),
    view: &ViewParameters,
    rays: RaySelection<'_>,
) {
    let name = format!("{:?}, {view:?}", projector.geometry());
    let image = projector.forward_project_view(view, rays).expect("valid");
    let truth = twin.view_jacobian(view, rays).expect("valid");
    hold(&format!("{name}: values"), relative_l2(&image, &truth.image), VALUES);
    let jacobian = projector.view_jacobian(view, rays).expect("valid");
    assert_eq!(jacobian.image, image, "{name}: the same sums");
    let scale = (0..5).map(|k| truth.derivatives[k].iter().fold(0.0_f64, |most, d| most.max(d.abs())));
    for (k, scale) in scale.enumerate() {
        let wide: Vec<f64> = jacobian.derivatives[k].iter().map(|&d| d.into()).collect();
        let error = of_largest(&wide, &truth.derivatives[k]);
        hold(&format!("{name}: derivative {k}, up to {scale:e}"), error, DERIVATIVES);
    }
    // Where rays do not count, what was measured may be anything.
    let mut measured: Vec<f64> =
        truth.image.iter().enumerate().map(|(n, value)| 0.9 * value + 0.05 * noise(n as u64)).collect();
    for (n, value) in measured.iter_mut().enumerate() {
        if rays.mask.is_some_and(|mask| !mask[n]) {
            *value = f64::NAN;
        }
    }
    let narrow: Vec<f32> = measured.iter().map(|&value| value as f32).collect();
    let measured: Vec<f64> = narrow.iter().map(|&value| value.into()).collect();
    let made = projector.view_loss_value_and_grad(view, &narrow, rays).expect("valid");
    let truth = twin.view_loss_value_and_grad(view, &measured, rays).expect("valid");
    assert_eq!(made.rays, truth.rays);
    hold(&format!("{name}: loss"), (made.loss / truth.loss - 1.0).abs(), 2.0 * VALUES);
    hold(&format!("{name}: gradient"), of_largest(&made.gradient, &truth.gradient), DERIVATIVES);
    for (made, truth) in made.hessian.iter().zip(&truth.hessian) {
        hold(&format!("{name}: hessian"), of_largest(made, truth), DERIVATIVES);
    }
    assert_eq!(made, projector.view_loss_value_and_grad(view, &narrow, rays).expect("valid"));
}

fn values_and_derivatives_are_the_twin_s(backend: Backend) {
    for geometry in geometries() {
        let projectors = projectors(backend, geometry);
        let moved = |view: ViewParameters| {
            // About the world's origin, the object would leave the detector.
            if geometry.centre == DVec3::ZERO {
                view
            } else {
                ViewParameters { phi: 0.0, alpha: 0.0, beta: 0.0, ..view }
            }
        };
        for view in views() {
            conforms(&projectors, &moved(view), RaySelection::default());
        }
    }
}

fn masks_and_lengths_are_the_twin_s(backend: Backend) {
    for geometry in geometries().into_iter().step_by(2) {
        let projectors = projectors(backend, geometry);
        let pixels = geometry.pixels() as u64;
        let mask: Vec<bool> = (0..pixels).map(|n| noise(n) < 0.6).collect();
        let reach = 0.6 * geometry.step * geometry.steps as f64;
        let lengths: Vec<[f64; 2]> = (0..pixels)
            .map(|n| {
                let [a, b] = [2 * n, 2 * n + 1].map(|n| (2.0 * noise(n) - 1.0) * reach + geometry.centre.y);
                if n % 7 == 0 { [a, a] } else { [a.min(b), a.max(b)] }
            })
            .collect();
        for (mask, lengths) in
            [(Some(&mask[..]), None), (None, Some(&lengths[..])), (Some(&mask), Some(&lengths))]
        {
            conforms(&projectors, &views()[1], RaySelection { mask, lengths });
        }
    }
}

fn batches_are_their_views(backend: Backend) {
    let (projector, _) = projectors(backend, geometries()[0]);
    let views: Vec<_> = views().into_iter().cycle().take(35).collect();
    let images = projector.batch_forward_project(&views).expect("valid");
    let pixels = projector.geometry().pixels();
    for (image, view) in images.chunks(pixels).zip(&views) {
        assert_eq!(image, projector.forward_project_view(view, RaySelection::default()).expect("valid"));
    }
    assert!(projector.batch_forward_project(&[]).expect("valid").is_empty());
}

/// Every coordinate is a whole number of voxels or half of one, which float32 and float64 both have exactly.
fn samples_on_planes_are_the_upper_cell_s(backend: Backend) {
    let geometry = ParallelGeometry::new([9, 9, 9], DVec3::ONE, [11, 12], [1.0, 1.0]);
    let projectors = projectors(backend, ParallelGeometry { steps: 12, ..geometry });
    for dx in [0.0, 0.5, 1.0] {
        let view = ViewParameters { dx, dz: -dx, ..ViewParameters::default() };
        conforms(&projectors, &view, RaySelection::default());
    }
}

fn what_it_lacks_is_refused(backend: Backend) {
    let context = Context::new(backend, 1).expect("threads start");
    let geometry = geometries()[5];
    let values = volume(geometry.dimensions);
    let wide: Vec<f64> = values.iter().map(|&value| value.into()).collect();
    let invalid = ParallelProjector::new(&context, geometry, Quadrature::Steps, &values[1..]).map(drop);
    assert!(matches!(invalid, Err(Error::InvalidArgument { .. })), "{invalid:?}");
    let refused = |made: drr::Result<()>, words: &str| match made {
        Err(Error::Unsupported(text)) => assert!(text.contains(words) && text.contains("cpu"), "{text}"),
        other => panic!("{other:?}"),
    };
    let made =
        |quadrature, wide: &[f64]| ParallelProjector::new(&context, geometry, quadrature, wide).map(drop);
    if backend == Backend::Cpu {
        assert_eq!(made(Quadrature::Exact, &wide), Ok(()));
        return;
    }
    refused(made(Quadrature::Steps, &wide), "float32");
    let exact = ParallelProjector::new(&context, geometry, Quadrature::Exact, &values).map(drop);
    refused(exact, "exact");
}

/// The reference is float64's.
pub(super) fn the_reference_is_wide() {
    let context = Context::new(Backend::Reference, 1).expect("threads start");
    let geometry = geometries()[5];
    let values = volume(geometry.dimensions);
    let wide: Vec<f64> = values.iter().map(|&value| value.into()).collect();
    let steps = Quadrature::Steps;
    let refused = ParallelProjector::new(&context, geometry, steps, &values).map(drop);
    assert!(matches!(&refused, Err(Error::Unsupported(text)) if text.contains("float64")), "{refused:?}");
    assert!(ParallelProjector::new(&context, geometry, steps, &wide).is_ok());
}
