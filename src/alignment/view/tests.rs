use glam::DVec3;

use super::*;
use crate::alignment::{Misalignment, PhotonNoise};
use crate::context::Context;
use crate::engine::Backend;
use crate::parallel::{ParallelGeometry, ParallelProjector, Quadrature, RaySelection};

/// Voxels as large as those of a chest in 256³ would be in 48³: 7.5 mm, 360 mm in all.
const SIDE: usize = 48;
const MM: f64 = 7.5;

/// Half width, centre (mm) and attenuation (1/mm) of smooth blobs: a body, and organs in it.
const BLOBS: [([f64; 3], [f64; 3], f64); 6] = [
    ([52.0, 38.0, 50.0], [0.0, 0.0, 0.0], 0.02),
    ([22.0, 20.0, 28.0], [40.0, -10.0, 20.0], -0.012),
    ([22.0, 20.0, 28.0], [-40.0, -5.0, 10.0], -0.012),
    ([18.0, 20.0, 22.0], [20.0, -30.0, -15.0], 0.01),
    ([15.0, 15.0, 45.0], [0.0, 45.0, 0.0], 0.025),
    ([22.0, 18.0, 18.0], [-50.0, 20.0, -60.0], 0.015),
];

fn geometry() -> ParallelGeometry {
    ParallelGeometry::new([SIDE; 3], DVec3::splat(MM), [SIDE; 2], [MM; 2])
}

fn phantom() -> Vec<f32> {
    let grid = geometry().grid().expect("valid");
    let value = |n: usize| {
        let index = [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE].map(|i| i as f64);
        let at = grid.index_to_world().transform_point3(DVec3::from_array(index));
        let blob = |&(width, centre, mu): &([f64; 3], [f64; 3], f64)| {
            let x = (at - DVec3::from_array(centre)) / DVec3::from_array(width);
            mu * (-0.5 * x.length_squared()).exp()
        };
        BLOBS.iter().map(blob).sum::<f64>() as f32
    };
    (0..SIDE.pow(3)).map(value).collect()
}

struct Stand {
    pyramid: Pyramid<f32>,
    exact: ParallelProjector<f32>,
}

impl Stand {
    fn new() -> Self {
        let context = Context::new(Backend::Cpu, 2).expect("threads");
        let volume = phantom();
        let pyramid = Pyramid::new(&context, geometry(), Quadrature::Steps, &volume, 3).expect("valid");
        let exact = ParallelProjector::new(&context, geometry(), Quadrature::Exact, &volume).expect("valid");
        Self { pyramid, exact }
    }

    /// Not the operator that it is aligned with: exact integrals, with the noise of photons.
    fn measured(&self, view: usize, at: &ViewParameters, photons: f64) -> Vec<f32> {
        let mut image = self.exact.forward_project_view(at, RaySelection::default()).expect("valid");
        PhotonNoise { photons, seed: 11 }.apply(view, SIDE, &mut image);
        image
    }

    fn align(&self, measured: &[f32], mask: Option<&[bool]>, start: &ViewParameters) -> Alignment {
        let mut silent = |_: usize, _: &Step<5>| ControlFlow::Continue(());
        let options = AlignmentOptions::default();
        self.pyramid.align_view(measured, mask, start, &options, &mut silent).expect("aligned")
    }
}

/// Differences, degrees and mm.
fn errors(found: &ViewParameters, truth: &ViewParameters) -> [f64; 5] {
    let (found, truth) = (found.to_array(), truth.to_array());
    std::array::from_fn(|k| (found[k] - truth[k]).abs() * if k < 3 { 1_f64.to_degrees() } else { 1.0 })
}

#[test]
fn views_three_degrees_and_five_millimetres_off_are_found() {
    let stand = Stand::new();
    let misalignment = Misalignment { degrees: 3.0, mm: 5.0, seed: 5 };
    let mut worst = [0.0_f64; 5];
    for view in 0..8 {
        let nominal = ViewParameters { phi: 0.4 * view as f64, ..ViewParameters::default() };
        let truth = misalignment.applied(view, &nominal);
        let found = stand.align(&stand.measured(view, &truth, 3e7), None, &nominal);
        assert!(found.stop().converged() && found.levels.len() == 3, "{found:?}");
        let errors = errors(&found.parameters, &truth);
        (0..5).for_each(|k| worst[k] = worst[k].max(errors[k]));
    }
    assert!(worst[..3].iter().all(|error| *error < 0.02), "degrees: {worst:?}");
    assert!(worst[3..].iter().all(|error| *error < 0.05), "mm: {worst:?}");
}

#[test]
fn standard_deviations_are_those_of_the_errors_and_least_where_photons_count() {
    let stand = Stand::new();
    let truth = ViewParameters { alpha: 0.01, beta: -0.02, phi: 0.3, dx: 1.5, dz: -0.7 };
    let count = 16;
    let mut squares = [[0.0; 5]; 2];
    let mut sizes = [[0.0; 5]; 2];
    for (photons, view) in
        [false, true].into_iter().flat_map(|photons| (0..count).map(move |view| (photons, view)))
    {
        let options = AlignmentOptions { photons, ..AlignmentOptions::default() };
        let mut silent = |_: usize, _: &Step<5>| ControlFlow::Continue(());
        let measured = stand.measured(view, &truth, 1e4);
        let found =
            stand.pyramid.align_view(&measured, None, &truth, &options, &mut silent).expect("aligned");
        let (squares, sizes) = (&mut squares[usize::from(photons)], &mut sizes[usize::from(photons)]);
        let sigma = found.standard_deviations.expect("all five parameters");
        let (found, truth) = (found.parameters.to_array(), truth.to_array());
        (0..5)
            .for_each(|k| squares[k] += ((found[k] - truth[k]) / sigma[k]).powi(2) / f64::from(count as u32));
        (0..5).for_each(|k| sizes[k] += sigma[k] / f64::from(count as u32));
    }
    // 16 squares' mean is 1 ± 0.35. Of one variance for all pixels it would be 2.6 … 4.5: thick paths are noisier.
    assert!(squares.as_flattened().iter().all(|square| (0.35..2.5).contains(square)), "{squares:?}");
    // Where photons count, what is found is surer.
    assert!((0..5).all(|k| sizes[1][k] < 0.95 * sizes[0][k]), "{sizes:?}");
}

#[test]
fn pixels_that_do_not_count_may_hold_anything() {
    let stand = Stand::new();
    let truth = ViewParameters { phi: 0.03, dx: 2.0, ..ViewParameters::default() };
    let mut measured = stand.measured(0, &truth, 1e6);
    let mask: Vec<bool> = (0..measured.len()).map(|n| n % SIDE > 5).collect();
    for (value, counts) in measured.iter_mut().zip(&mask) {
        if !counts {
            *value = f32::NAN;
        }
    }
    let found = stand.align(&measured, Some(&mask), &ViewParameters::default());
    assert!(errors(&found.parameters, &truth).iter().all(|error| *error < 0.05), "{found:?}");
    assert!(found.levels.iter().all(|level| level.equations.rays < 43 * 48), "{found:?}");
}

#[test]
fn a_report_that_breaks_keeps_the_best_so_far() {
    let stand = Stand::new();
    let measured = stand.measured(0, &ViewParameters { dx: 4.0, ..ViewParameters::default() }, 1e6);
    let mut levels = Vec::new();
    let mut second = |level: usize, step: &Step<5>| {
        levels.push(level);
        if level == 1 && step.iteration == 1 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let (start, options) = (ViewParameters::default(), AlignmentOptions::default());
    let found = stand.pyramid.align_view(&measured, None, &start, &options, &mut second).expect("aligned");
    assert_eq!((found.stop(), found.levels.len()), (Stop::Cancelled, 2));
    assert_eq!(found.evaluations(), levels.len());
    assert!((found.parameters.dx - 4.0).abs() < 2.0, "{found:?}");
}

#[test]
fn what_cannot_be_told_has_no_standard_deviation() {
    let context = Context::new(Backend::Cpu, 1).expect("a thread");
    // Rods along z, so long that their ends are not seen: Δz changes nothing.
    let mut geometry = ParallelGeometry::new([20, 20, 400], DVec3::splat(2.0), [20, 6], [2.0; 2]);
    geometry.detector_centre = [0.0, 0.0];
    let rod = |n: usize| if (n % 20).abs_diff(7) < 2 && (n / 20 % 20).abs_diff(12) < 3 { 0.02 } else { 0.0 };
    let volume: Vec<f64> = (0..20 * 20 * 400).map(rod).collect();
    let pyramid = Pyramid::new(&context, geometry, Quadrature::Steps, &volume, 1).expect("valid");
    let truth = ViewParameters { dx: 0.3, ..ViewParameters::default() };
    let measured = pyramid.finest().forward_project_view(&truth, RaySelection::default()).expect("valid");
    let mut silent = |_: usize, _: &Step<5>| ControlFlow::Continue(());
    let start = ViewParameters { phi: 0.02, ..ViewParameters::default() };
    let found = pyramid
        .align_view(&measured, None, &start, &AlignmentOptions::default(), &mut silent)
        .expect("aligned");
    assert_eq!((found.parameters.dz, found.standard_deviations), (0.0, None));
    assert!(found.levels[0].without_influence[4]);
}

#[test]
fn bad_levels_and_measured_images_are_named() {
    let context = Context::new(Backend::Cpu, 1).expect("a thread");
    let none = Pyramid::new(&context, geometry(), Quadrature::Steps, &phantom(), 0).err().expect("refused");
    assert_eq!(none.to_string(), "levels is 0; valid: 1 … 7");
    let stand = Stand::new();
    let mut silent = |_: usize, _: &Step<5>| ControlFlow::Continue(());
    let (start, options) = (ViewParameters::default(), AlignmentOptions::default());
    let mut refused = |measured: &[f32], mask: Option<&[bool]>| {
        let found = stand.pyramid.align_view(measured, mask, &start, &options, &mut silent);
        found.expect_err("refused").to_string()
    };
    assert_eq!(refused(&[0.0; 7], None), "measured's length is 7; valid: 2304, one per pixel");
    assert!(refused(&[f32::NAN; SIDE * SIDE], None).starts_with("measured[0] is NaN"));
    assert!(refused(&[0.0; SIDE * SIDE], Some(&[false; SIDE * SIDE])).starts_with("mask is empty"));
}

#[test]
fn paths_of_which_no_photon_number_exists_have_weights() {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    // p is 1800 … 2600, or as much below 0, in all pixels: exp(−p) is 0, or ∞.
    for sign in [1.0, -1.0] {
        let volume: Vec<f64> =
            phantom().iter().map(|value| sign * (5.0 + 200.0 * f64::from(*value))).collect();
        let geometry = ParallelGeometry { detector: [24; 2], ..geometry() };
        let pyramid = Pyramid::new(&context, geometry, Quadrature::Steps, &volume, 1).expect("valid");
        let truth = ViewParameters { dx: 0.5, dz: -0.5, ..ViewParameters::default() };
        let measured = pyramid.finest().forward_project_view(&truth, RaySelection::default()).expect("valid");
        let options = AlignmentOptions { photons: true, ..AlignmentOptions::default() };
        let start = ViewParameters::default();
        let mut silent = |_: usize, _: &Step<5>| ControlFlow::Continue(());
        let found = pyramid.align_view(&measured, None, &start, &options, &mut silent).expect("aligned");
        let solution = &found.levels[0];
        assert!(solution.steps.iter().all(|step| step.loss.is_finite()), "{solution:?}");
        assert!(solution.equations.loss < solution.steps[0].loss, "{solution:?}");
    }
}
