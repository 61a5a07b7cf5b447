use std::f64::consts::PI;

use glam::DVec3;

use super::linearised::Linearised;
use super::*;
use crate::alignment::Misalignment;
use crate::engine::Backend;
use crate::geometry::View;
use crate::linear_operator::LinearOperator;
use crate::method::Algorithm;
use crate::parallel::{ParallelProjector, Quadrature, RaySelection};
use crate::ray_transform::RayTransform;
use crate::reconstruction::{Cgls, Problem, cgls};
use crate::vector::norm;

const SIDE: usize = 20;
const SPACING: f64 = 5.0;
const VIEWS: usize = 30;

/// Solid balls in a ball, by the part of a voxel that they fill.
fn object(side: usize) -> Vec<f32> {
    let half = 0.5 * SIDE as f64 * SPACING;
    let balls = [
        ([0.0, 0.0, 0.0], 0.75, 0.02),
        ([0.35, 0.1, -0.2], 0.2, 0.02),
        ([-0.3, 0.25, 0.3], 0.25, -0.015),
        ([0.1, -0.45, 0.1], 0.15, 0.03),
        ([-0.2, -0.2, -0.4], 0.2, 0.02),
        ([0.2, 0.3, 0.45], 0.12, 0.03),
        ([-0.5, -0.1, 0.0], 0.15, 0.02),
    ];
    let inside = |p: DVec3| {
        let value = |(centre, radius, value): &([f64; 3], f64, f64)| {
            if (p - half * DVec3::from_array(*centre)).length() < radius * half { *value } else { 0.0 }
        };
        balls.iter().map(value).sum::<f64>()
    };
    let mm = SIDE as f64 * SPACING / side as f64;
    let at = |n: f64, part: usize| (n + (part as f64 + 0.5) / 3.0) * mm - half;
    let voxel = |n: usize| {
        let [i, j, k] = [n % side, n / side % side, n / side / side].map(|n| n as f64);
        let parts = (0..27).map(|s| inside(DVec3::new(at(i, s % 3), at(j, s / 3 % 3), at(k, s / 9))));
        (parts.sum::<f64>() / 27.0) as f32
    };
    (0..side.pow(3)).map(voxel).collect()
}

fn geometry(side: usize) -> ParallelGeometry {
    let mm = SIDE as f64 * SPACING / side as f64;
    ParallelGeometry::new([side; 3], DVec3::splat(mm), [SIDE + 6, SIDE + 6], [SPACING; 2])
}

/// Root mean squares over all views of the errors of angles, degrees, and shifts, mm.
fn errors(views: &[ViewParameters], truth: &[ViewParameters]) -> [f64; 2] {
    let mut squares = [0.0; 5];
    for (own, right) in without_common_motion(views, truth).unwrap().iter().zip(truth) {
        for (k, (own, right)) in own.to_array().into_iter().zip(right.to_array()).enumerate() {
            squares[k] += (own - right).powi(2);
        }
    }
    let rms = |squares: &[f64]| (squares.iter().sum::<f64>() / (squares.len() * views.len()) as f64).sqrt();
    [rms(&squares[..3]).to_degrees(), rms(&squares[3..])]
}

/// Root mean square error of a reconstruction with these views, relative to the object's root mean square.
fn error_with(context: &Context, images: &[f32], views: &[ViewParameters]) -> f64 {
    let geometry = geometry(SIDE);
    let seen: Vec<_> = views.iter().map(|view| View::Projection(geometry.projection(view))).collect();
    let grid = geometry.grid().unwrap();
    let transform = RayTransform::new(context, grid, &seen, geometry.detector, Algorithm::Joseph).unwrap();
    let problem = Problem { operator: &transform, images, weights: None, start: None };
    let options = Cgls { iterations: 12 };
    let found = cgls(&problem, &options, &mut |_| ControlFlow::Continue(())).unwrap().volume;
    let truth = object(SIDE);
    let error: Vec<f32> = found.iter().zip(&truth).map(|(own, truth)| own - truth).collect();
    norm(&error) / norm(&truth)
}

#[test]
fn views_and_volume_are_found_together() {
    let context = Context::new(Backend::Cpu, 0).unwrap();
    let start: Vec<_> = (0..VIEWS)
        .map(|n| ViewParameters { phi: PI * n as f64 / VIEWS as f64, ..ViewParameters::default() })
        .collect();
    let hidden = Misalignment { degrees: 2.0, mm: 4.0, seed: 5 };
    let truth: Vec<_> = start.iter().enumerate().map(|(n, view)| hidden.applied(n, view)).collect();
    // Finer voxels and exact integrals: not what views are aligned with.
    let fine =
        ParallelProjector::new(&context, geometry(2 * SIDE), Quadrature::Exact, &object(2 * SIDE)).unwrap();
    let images = fine.batch_forward_project(&truth).unwrap();
    let geometry = geometry(SIDE);
    let problem = JointProblem { geometry: &geometry, images: &images, views: &start };
    let mut rounds = Vec::new();
    let found = JointAlignment::of(&geometry)
        .solve(&context, &problem, &mut |round| {
            rounds.push(errors(round.views, &truth));
            ControlFlow::Continue(())
        })
        .unwrap();
    let ([degrees, mm], last) = (errors(&start, &truth), errors(&found.views, &truth));
    assert_eq!(rounds.len(), 11);
    // Those of joint rounds are of the images themselves, and fall.
    assert!(found.residuals[2..].windows(2).all(|pair| pair[1] < pair[0]), "{:?}", found.residuals);
    assert!(last[0] < 0.5 * degrees && last[1] < 0.05 * mm, "{degrees}° {mm} mm: {rounds:?}");
    // Against the views as they are, of which the object has moved by what they have in common.
    let fixed = without_common_motion(&truth, &start).unwrap();
    let [thought, joint, real] =
        [&start, &found.views, &fixed].map(|views| error_with(&context, &images, views));
    assert!(joint - real < 0.1 * (thought - real), "{thought} {joint} {real}");
    // Nothing that all have in common is left.
    let fixed = without_common_motion(&found.views, &start).unwrap();
    assert!(errors(&fixed, &found.views)[1] < 1e-6);
}

#[test]
fn the_linear_model_is_that_of_images_and_its_adjoint_matches() {
    let context = Context::new(Backend::Cpu, 0).unwrap();
    let geometry = geometry(SIDE);
    let view = |n: u32| ViewParameters {
        phi: 0.8 * f64::from(n),
        alpha: 0.05,
        dx: 1.0,
        ..ViewParameters::default()
    };
    let views: Vec<_> = (0..4).map(view).collect();
    let volume: Vec<f64> = object(SIDE).into_iter().map(f64::from).collect();
    let projector = ParallelProjector::new(&context, geometry, Quadrature::Steps, &volume).unwrap();
    let seen: Vec<_> = views.iter().map(|view| View::Projection(geometry.projection(view))).collect();
    let grid = geometry.grid().unwrap();
    let transform = RayTransform::new(&context, grid, &seen, geometry.detector, Algorithm::Joseph).unwrap();
    let images = transform.forward(&volume).unwrap();
    let operator = Linearised::new(&context, &transform, &projector, &views, &images).unwrap();
    let mut state = 1_u64;
    let mut random = |count: usize| -> Vec<f64> {
        let next = |_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..count).map(next).collect()
    };
    let (x, b) = (random(operator.domain()), random(operator.range()));
    let (forward, back) = (operator.forward(&x).unwrap(), operator.adjoint(&b).unwrap());
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (left, right) = (product(&forward, &b), product(&x, &back));
    assert!((left - right).abs() < 1e-12 * norm(&forward) * norm(&b), "{left} {right}");
    // A small motion of one parameter, in its unit.
    let mut step = vec![0.0; operator.domain()];
    let unit = operator.units[2][4];
    step[transform.domain() + 2 * ViewParameters::COUNT + 4] = 1e-4 / unit;
    let mut moved = views.clone();
    operator.moved(&mut moved, &step[transform.domain()..], 1.0);
    assert!((moved[2].dz - views[2].dz - 1e-4).abs() < 1e-15);
    let project = |view| projector.forward_project_view(view, RaySelection::default()).unwrap();
    let (before, after) = (project(&views[2]), project(&moved[2]));
    let predicted = operator.forward(&step).unwrap();
    let pixels = geometry.pixels();
    let difference: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    let error: Vec<f64> = difference.iter().zip(&predicted[2 * pixels..]).map(|(a, b)| a - b).collect();
    assert!(norm(&error) < 1e-3 * norm(&difference), "{} {}", norm(&error), norm(&difference));
}

#[test]
fn bad_problems_are_named() {
    let context = Context::new(Backend::Cpu, 1).unwrap();
    let geometry = geometry(4);
    let refused = |settings: JointAlignment, images: &[f32], views: &[ViewParameters]| {
        let problem = JointProblem { geometry: &geometry, images, views };
        settings.solve(&context, &problem, &mut |_| ControlFlow::Continue(())).unwrap_err().to_string()
    };
    let settings = JointAlignment::of(&geometry);
    let view = [ViewParameters::default()];
    let image = vec![1.0; geometry.pixels()];
    assert!(refused(settings, &image, &[]).starts_with("views is empty"));
    assert!(refused(settings, &image[1..], &view).starts_with("images' length is 675"));
    let rough = JointAlignment { smoothing_mm: f64::NAN, ..settings };
    assert!(refused(rough, &image, &view).starts_with("smoothing_mm is NaN"));
    assert!(refused(JointAlignment { rounds: 1 << 20, ..settings }, &image, &view).starts_with("rounds is"));
    let still = JointAlignment { iterations: 0, ..settings };
    assert!(refused(still, &image, &view).starts_with("iterations is 0"));
    assert!(still.validate().is_err() && settings.validate().is_ok());
    let mut unknown = image.clone();
    unknown[5] = f32::NAN;
    assert!(refused(settings, &unknown, &view).starts_with("images[5] is NaN"));
    let bad = ViewParameters { alpha: f64::INFINITY, ..view[0] };
    let named = refused(settings, &[1.0; 2 * 676], &[view[0], bad]);
    assert!(named.starts_with("views[1].alpha is inf"), "{named}");
}

#[test]
fn nothing_is_found_in_empty_images() {
    let context = Context::new(Backend::Cpu, 1).unwrap();
    let geometry = geometry(4);
    let view = [ViewParameters::default()];
    let images = vec![0.0_f64; geometry.pixels()];
    let problem = JointProblem { geometry: &geometry, images: &images, views: &view };
    let settings = JointAlignment { alignments: 0, rounds: 1, ..JointAlignment::of(&geometry) };
    let found = settings.solve(&context, &problem, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!((found.views, found.residuals), (view.to_vec(), vec![0.0]));
    assert!(found.volume.iter().all(|value| *value == 0.0));
}

#[test]
fn no_round_raises_the_residual_or_leaves_the_range() {
    let context = Context::new(Backend::Cpu, 1).unwrap();
    let geometry = geometry(6);
    let view = |n: u32| ViewParameters { phi: 0.7 * f64::from(n), ..ViewParameters::default() };
    let views: Vec<_> = (0..3).map(view).collect();
    // Of no object: long steps of the linear model fit nothing.
    let images: Vec<f64> = (0..3 * geometry.pixels()).map(|n| (n * 7919 % 1009) as f64 - 504.0).collect();
    let problem = JointProblem { geometry: &geometry, images: &images, views: &views };
    let settings =
        JointAlignment { alignments: 0, rounds: 12, smoothing_mm: 0.0, ..JointAlignment::of(&geometry) };
    let found = settings.solve(&context, &problem, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(found.residuals.windows(2).all(|pair| pair[1] < pair[0]), "{:?}", found.residuals);
    assert!(found.views.iter().all(|view| view.validate().is_ok()));
}
