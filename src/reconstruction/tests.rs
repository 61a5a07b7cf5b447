//! Both methods against dense least squares.

use std::ops::ControlFlow;

use glam::DVec3;

use super::*;
use crate::context::Context;
use crate::engine::Backend;
use crate::error::Result;
use crate::geometry::{DetectorPose, Grid, View};
use crate::least_squares::Columns;
use crate::linear_operator::LinearOperator;
use crate::method::Algorithm;
use crate::ray_transform::RayTransform;

/// A matrix by rows.
struct Matrix {
    columns: usize,
    values: Vec<f64>,
}

impl LinearOperator<f64> for Matrix {
    fn domain(&self) -> usize {
        self.columns
    }

    fn range(&self) -> usize {
        self.values.len() / self.columns
    }

    fn forward(&self, volume: &[f64]) -> Result<Vec<f64>> {
        Ok(self.values.chunks(self.columns).map(|row| crate::vector::dot(row, volume)).collect())
    }

    fn adjoint(&self, images: &[f64]) -> Result<Vec<f64>> {
        let mut volume = vec![0.0; self.columns];
        for (row, value) in self.values.chunks(self.columns).zip(images) {
            crate::vector::add(&mut volume, *value, row);
        }
        Ok(volume)
    }
}

/// Values in [0, 1] without any symmetry.
fn values(count: usize, seed: usize) -> Vec<f64> {
    (0..count).map(|n| ((n + 31 * seed + 1) * 7919 % 1009) as f64 / 1008.0).collect()
}

/// Some rays miss the volume.
fn transform() -> RayTransform<f64> {
    let grid = Grid::centred([3, 4, 2], DVec3::new(2.0, 1.5, 2.5)).expect("valid");
    let view = |n: u8| DetectorPose::c_arm(grid.centre(), 23.0 * f64::from(n), 20.0, 30.0, 1.5, [9, 7]);
    let views: Vec<_> = (0..7).map(|n| View::Pose(view(n))).collect();
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    RayTransform::new(&context, grid, &views, [9, 7], Algorithm::Exact).expect("valid")
}

/// The minimiser of Σ w (b − A x)².
fn dense_solution(operator: &dyn LinearOperator<f64>, images: &[f64], weights: &[f64]) -> Vec<f64> {
    let unit = |n| (0..operator.domain()).map(|k| f64::from(u8::from(k == n))).collect::<Vec<_>>();
    let columns = (0..operator.domain()).flat_map(|n| operator.forward(&unit(n)).expect("valid"));
    let columns = Columns::new(operator.range(), columns.collect());
    let support: Vec<_> = (0..operator.domain()).collect();
    let factors: Vec<_> = weights.iter().map(|weight| weight.sqrt()).collect();
    let target: Vec<_> = images.iter().zip(&factors).map(|(value, factor)| value * factor).collect();
    columns.weighted(&support, &factors).solve(&support, &target)
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn go_on(_: &Iteration<'_, f64>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn problem<'a>(operator: &'a dyn LinearOperator<f64>, images: &'a [f64]) -> Problem<'a, f64> {
    Problem { operator, images, weights: None, start: None }
}

/// Up to rounding.
fn falls(residuals: &[f64]) -> bool {
    residuals.windows(2).all(|pair| pair[1] < pair[0] + 4e-15)
}

#[test]
fn cgls_finds_the_least_squares_solution() {
    let operator = transform();
    // No volume has these images.
    let images = values(operator.range(), 1);
    for weights in [vec![1.0; images.len()], values(images.len(), 2)] {
        let weighted = Problem { weights: Some(&weights), ..problem(&operator, &images) };
        let found = cgls(&weighted, &Cgls { iterations: 50 }, &mut go_on).expect("valid");
        let off = largest_difference(&found.volume, &dense_solution(&operator, &images, &weights));
        assert!(off < 1e-15, "{off:e}");
        assert!(found.residuals[0] == 1.0 && falls(&found.residuals), "{:?}", found.residuals);
    }
}

#[test]
fn cgls_solves_n_equations_in_n_steps() {
    let n = 12;
    // Twelve singular values, all different.
    let diagonal = |k: usize| if k.is_multiple_of(n + 1) { 1.0 + (k / n) as f64 / 4.0 } else { 0.0 };
    let matrix =
        values(n * n, 10).into_iter().enumerate().map(|(k, value)| diagonal(k) + 0.2 * (value - 0.5));
    let operator = Matrix { columns: n, values: matrix.collect() };
    let x = values(n, 3);
    let images = operator.forward(&x).expect("valid");
    let found = cgls(&problem(&operator, &images), &Cgls { iterations: n }, &mut go_on).expect("valid");
    let off = largest_difference(&found.volume, &x);
    assert!(off < 4e-15 && found.residuals[n] < 4e-15, "{off:e}, {:?}", found.residuals);
    assert!(found.residuals[n - 1] > 1e-5, "{:?}", found.residuals);
}

#[test]
fn sirt_lessens_its_sum_in_every_iteration_and_ends_at_the_least() {
    let operator = transform();
    let images = values(operator.range(), 4);
    let rows = operator.forward(&vec![1.0; operator.domain()]).expect("valid");
    for weights in [vec![1.0; images.len()], values(images.len(), 5)] {
        let per_row = |(weight, row): (&f64, &f64)| if *row > 0.0 { weight / row } else { 0.0 };
        let scaled: Vec<_> = weights.iter().zip(&rows).map(per_row).collect();
        let wanted = dense_solution(&operator, &images, &scaled);
        for relaxation in [0.5, 1.0, 1.9] {
            let weighted = Problem { weights: Some(&weights), ..problem(&operator, &images) };
            let sum = |volume: &[f64]| {
                let residual = weighted.residual(volume).expect("valid");
                residual.iter().zip(&scaled).map(|(value, scale)| value * value * scale).sum::<f64>()
            };
            let mut sums = vec![sum(&vec![0.0; operator.domain()])];
            let iterations = (800.0 / relaxation) as usize;
            let options = Sirt { iterations, relaxation, ..Sirt::default() };
            let found = sirt(&weighted, &options, &mut |iteration| {
                sums.push(sum(iteration.volume));
                ControlFlow::Continue(())
            });
            let rounding = 1e-14 * sums[0];
            assert!(sums.windows(2).all(|pair| pair[1] < pair[0] + rounding), "relaxation {relaxation}");
            let off = largest_difference(&found.expect("valid").volume, &wanted);

            assert!(off < 4e-10, "relaxation {relaxation}: {off:e}");
        }
    }
}

#[test]
fn consistent_images_give_the_volume_back() {
    let operator = transform();
    let object = values(operator.domain(), 6);
    let images = operator.forward(&object).expect("valid");
    let found = cgls(&problem(&operator, &images), &Cgls { iterations: 40 }, &mut go_on).expect("valid");
    assert!(largest_difference(&found.volume, &object) < 3e-15);
    let options = Sirt { iterations: 300, relaxation: 1.9, ..Sirt::default() };
    let found = sirt(&problem(&operator, &images), &options, &mut go_on).expect("valid");
    assert!(largest_difference(&found.volume, &object) < 4e-7 && falls(&found.residuals));

    let again = Problem { start: Some(&object), ..problem(&operator, &images) };
    let found = sirt(&again, &Sirt { iterations: 1, ..options }, &mut go_on).expect("valid");
    assert!(found.residuals[0] < 1e-15 && largest_difference(&found.volume, &object) < 1e-14);
}

#[test]
fn the_report_ends_the_iterations_with_the_volume_so_far() {
    let operator = transform();
    let images = values(operator.range(), 7);
    let mut seen = Vec::new();
    let mut stop_at_three = |iteration: &Iteration<'_, f64>| {
        seen.push((iteration.number, iteration.residual, iteration.volume.to_vec()));
        if iteration.number == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let ended = [
        cgls(&problem(&operator, &images), &Cgls::default(), &mut stop_at_three).expect("valid"),
        sirt(&problem(&operator, &images), &Sirt::default(), &mut stop_at_three).expect("valid"),
    ];
    let short = [
        cgls(&problem(&operator, &images), &Cgls { iterations: 3 }, &mut go_on).expect("valid"),
        sirt(&problem(&operator, &images), &Sirt { iterations: 3, ..Sirt::default() }, &mut go_on)
            .expect("valid"),
    ];
    assert_eq!(ended, short);
    for (found, seen) in ended.iter().zip(seen.chunks(3)) {
        assert_eq!(seen.iter().map(|seen| seen.0).collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(seen.iter().map(|seen| seen.1).collect::<Vec<_>>(), found.residuals[1..]);
        assert_eq!(seen[2].2, found.volume);
    }
}

#[test]
fn images_of_nothing_give_nothing() {
    let operator = transform();
    let images = vec![0.0; operator.range()];
    let found = cgls(&problem(&operator, &images), &Cgls::default(), &mut go_on).expect("valid");
    assert_eq!((found.volume, found.residuals), (vec![0.0; operator.domain()], vec![0.0]));
    let found = sirt(&problem(&operator, &images), &Sirt::default(), &mut go_on).expect("valid");
    assert_eq!((found.volume, found.residuals), (vec![0.0; operator.domain()], vec![0.0; 101]));
}

#[test]
fn images_that_overflow_are_refused_as_such() {
    let operator = transform();
    let images: Vec<f64> = values(operator.range(), 7).iter().map(|value| f64::MAX * (value - 0.5)).collect();
    // A small element beside large ones: what SIRT divides by its row's sum overflows.
    let small = Matrix { columns: 1, values: vec![1e-3] };
    let refused = [
        cgls(&problem(&operator, &images), &Cgls::default(), &mut go_on),
        sirt(&problem(&small, &[1e308]), &Sirt::default(), &mut go_on),
    ];
    for refused in refused {
        let error = refused.expect_err("refused").to_string();
        assert!(error.starts_with("images' largest value is") && error.contains("float64"), "{error}");
    }
}

#[test]
fn pixels_without_weight_do_not_count() {
    let operator = transform();
    let mut images = values(operator.range(), 8);
    let weights: Vec<_> = (0..images.len()).map(|n| f64::from(u8::from(n % 5 != 0))).collect();
    let both = |images: &[f64]| {
        let weighted = Problem { weights: Some(&weights), ..problem(&operator, images) };
        let sirt = sirt(&weighted, &Sirt::default(), &mut go_on).expect("valid");
        [cgls(&weighted, &Cgls::default(), &mut go_on).expect("valid"), sirt]
    };
    let before = both(&images);
    images.iter_mut().step_by(5).for_each(|value| *value = 1e6);
    assert_eq!(before, both(&images));
}

#[test]
fn values_are_kept_from_turning_negative_and_what_no_ray_meets_stays() {
    // The last column is empty, and so is the last row.
    let operator = Matrix { columns: 3, values: vec![1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0] };
    let (images, start) = ([1.0, 2.0, 7.0], [0.5, 0.5, 0.25]);
    let started = Problem { start: Some(&start), ..problem(&operator, &images) };
    let options = Sirt { iterations: 500, ..Sirt::default() };
    let free = sirt(&started, &options, &mut go_on).expect("valid").volume;
    assert!(largest_difference(&free, &[-1.0, 2.0, 0.25]) < 1e-12, "{free:?}");
    let kept = sirt(&started, &Sirt { non_negative: true, ..options }, &mut go_on).expect("valid").volume;
    // The least of (1 − y)²/2 + (2 − y)².
    assert!(largest_difference(&kept, &[0.0, 5.0 / 3.0, 0.25]) < 1e-12, "{kept:?}");
}

#[test]
fn bad_problems_are_refused_by_name() {
    let operator = transform();
    let images = values(operator.range(), 9);
    let good = problem(&operator, &images);
    let message = |problem: &Problem<'_, f64>, options: Sirt| {
        sirt(problem, &options, &mut go_on).expect_err("refused").to_string()
    };
    let default = Sirt::default();
    let none = message(&good, Sirt { iterations: 0, ..default });
    assert_eq!(none, "iterations is 0; valid: 1 … 1000000");
    for relaxation in [0.0, 2.0, -1.0, f64::NAN] {
        let text = message(&good, Sirt { relaxation, ..default });
        assert_eq!(text, format!("relaxation is {relaxation}; valid: above 0, below 2"));
    }
    let few = message(&Problem { images: &images[1..], ..good }, default);
    assert_eq!(
        few,
        format!("images' length is {}; valid: {}, one per pixel", images.len() - 1, images.len())
    );
    let mut bad = images.clone();
    bad[3] = f64::NAN;
    assert_eq!(
        message(&Problem { images: &bad, ..good }, default),
        "images[3] is NaN; valid: finite numbers"
    );
    bad[3] = -1.0;
    let negative = message(&Problem { weights: Some(&bad), ..good }, default);
    assert_eq!(negative, "weights[3] is -1; valid: finite numbers, at least 0");
    let short = message(&Problem { start: Some(&[0.0]), ..good }, default);
    assert_eq!(short, format!("start's length is 1; valid: {}, one per voxel", operator.domain()));
}
