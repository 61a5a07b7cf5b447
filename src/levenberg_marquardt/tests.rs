use std::ops::ControlFlow;

use super::*;
use crate::error::{Error, Result};
use crate::normal_equations::NormalEquations;

fn sums<const N: usize>(rows: impl IntoIterator<Item = (f64, [f64; N])>) -> NormalEquations<N> {
    let mut sums = NormalEquations::default();
    rows.into_iter().for_each(|(residual, row)| sums.add(residual, &row));
    sums
}

fn silent<const N: usize>(_: &Step<N>) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Residuals 10 (y − x²) and 1 − x (Rosenbrock, Computer J. 3, 175, 1960), x in units of `unit`.
fn rosenbrock(unit: f64) -> impl FnMut(&[f64; 2]) -> Result<NormalEquations<2>> {
    move |&[x, y]| {
        let x = unit * x;
        Ok(sums([(10.0 * (y - x * x), [-20.0 * x * unit, 10.0]), (1.0 - x, [-unit, 0.0])]))
    }
}

/// A straight line through points that it does not fit.
const LINE: [(f64, f64); 4] = [(0.0, 1.0), (1.0, 3.0), (2.0, 4.0), (3.0, 4.0)];

fn line(&[slope, offset]: &[f64; 2]) -> NormalEquations<2> {
    sums(LINE.map(|(x, y)| (slope * x + offset - y, [x, 1.0])))
}

#[test]
fn rosenbrocks_valley_is_followed_to_its_end() {
    let solution =
        LevenbergMarquardt::default().minimise([-1.2, 1.0], rosenbrock(1.0), &mut silent).expect("a minimum");
    let [x, y] = solution.parameters;
    assert!((x - 1.0).abs() < 1e-9 && (y - 1.0).abs() < 1e-9, "{solution:?}");
    assert!(solution.stop.converged() && solution.steps.len() < 40, "{}", solution.steps.len());
    let accepted: Vec<f64> = solution.steps.iter().filter(|s| s.accepted).map(|s| s.loss).collect();
    assert!(accepted.windows(2).all(|pair| pair[1] < pair[0]));
    assert_eq!(solution.equations.loss, accepted[accepted.len() - 1]);
}

#[test]
fn units_do_not_change_the_path() {
    let run = |unit: f64| {
        let start = [-1.2 / unit, 1.0];
        LevenbergMarquardt::default().minimise(start, rosenbrock(unit), &mut silent).expect("a minimum")
    };
    let (metre, millimetre) = (run(1.0), run(1024.0));
    assert_eq!(metre.steps.len(), millimetre.steps.len());
    for (a, b) in metre.steps.iter().zip(&millimetre.steps) {
        assert!((a.loss - b.loss).abs() <= 1e-9 * a.loss + 1e-20, "{a:?} {b:?}");
    }
}

#[test]
fn a_linear_problem_takes_two_steps_and_knows_its_covariance() {
    let method = LevenbergMarquardt { damping: 1e-12, ..LevenbergMarquardt::default() };
    let solution = method.minimise([5.0, -7.0], |x| Ok(line(x)), &mut silent).expect("a line");
    // The closed form: slope 1, offset 1.5, Σ r² = 1, Σ (x − x̄)² = 5.
    let [slope, offset] = solution.parameters;
    assert!((slope - 1.0).abs() < 1e-10 && (offset - 1.5).abs() < 1e-10, "{solution:?}");
    assert!(solution.steps.len() <= 3 && solution.stop.converged(), "{solution:?}");
    let variance = 1.0 / (4.0 - 2.0);
    let exact =
        [[variance / 5.0, -1.5 * variance / 5.0], [-1.5 * variance / 5.0, variance * (0.25 + 2.25 / 5.0)]];
    let covariance = solution.covariance().expect("two unknowns from four points");
    for (row, exact) in covariance.iter().flatten().zip(exact.iter().flatten()) {
        assert!((row - exact).abs() < 1e-10, "{covariance:?}");
    }
    let deviations = solution.standard_deviations().expect("a covariance");
    assert!((deviations[0] - 0.1_f64.sqrt()).abs() < 1e-10);
}

#[test]
fn a_parameter_without_influence_stays_and_is_named() {
    let solution = LevenbergMarquardt::default()
        .minimise(
            [5.0, 42.0, -7.0],
            |&[slope, _, offset]| Ok(sums(LINE.map(|(x, y)| (slope * x + offset - y, [x, 0.0, 1.0])))),
            &mut silent,
        )
        .expect("a line");
    assert_eq!(solution.parameters[1], 42.0);
    assert_eq!(solution.without_influence, [false, true, false]);
    assert!((solution.parameters[0] - 1.0).abs() < 1e-6 && (solution.parameters[2] - 1.5).abs() < 1e-6);
    let covariance = solution.covariance().expect("the others' covariance");
    assert!((covariance[0][0] - 0.1).abs() < 1e-6 && covariance[0][1] == 0.0, "{covariance:?}");
    assert_eq!(covariance[1][1], f64::INFINITY);
    assert!(solution.stop.converged() && !solution.converged());
    let doubt = solution.doubt(["slope", "age", "offset"]).expect("not all are told");
    assert_eq!(doubt, "not determined: nothing depends on age");
}

#[test]
fn a_singular_direction_is_damped_and_has_no_covariance() {
    // Only the sum of both counts: the shortest step in scaled parameters keeps their difference.
    let both = |&[a, b]: &[f64; 2]| Ok(sums(LINE.map(|(x, y)| ((a + b) * x - y, [x, x]))));
    let solution = LevenbergMarquardt::default().minimise([3.0, 1.0], both, &mut silent).expect("a sum");
    let [a, b] = solution.parameters;
    // Σ x y / Σ x² = 23/14.
    assert!((a + b - 23.0 / 14.0).abs() < 1e-6 && (a - b - 2.0).abs() < 1e-9, "{solution:?}");
    assert!(solution.stop.converged() && !solution.converged());
    assert!(solution.doubt(["a", "b"]).is_some_and(|doubt| doubt.contains("combination")));
    assert_eq!(solution.covariance(), None);
}

#[test]
fn it_stops_when_told_and_after_its_iterations() {
    let mut seen = Vec::new();
    let mut third = |step: &Step<2>| {
        seen.push(step.iteration);
        if step.iteration == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let method = LevenbergMarquardt::default();
    let solution = method.minimise([-1.2, 1.0], rosenbrock(1.0), &mut third).expect("three steps");
    assert_eq!((solution.stop, solution.steps.len()), (Stop::Cancelled, 4));
    assert_eq!(seen, [0, 1, 2, 3]);
    let few = LevenbergMarquardt { max_iterations: 2, ..method };
    let solution = few.minimise([-1.2, 1.0], rosenbrock(1.0), &mut silent).expect("two steps");
    assert_eq!((solution.stop, solution.steps.len()), (Stop::Iterations, 3));
    assert!(!solution.stop.converged());
}

#[test]
fn losses_that_are_not_finite_are_stepped_back_from() {
    // ln has no value at x ≤ 0; a full step from 8 would go there.
    let logarithm = |&[x]: &[f64; 1]| Ok(sums([(x.ln(), [1.0 / x])]));
    let solution = LevenbergMarquardt::default().minimise([8.0], logarithm, &mut silent).expect("ln x = 0");
    assert!((solution.parameters[0] - 1.0).abs() < 1e-9);
    assert!(solution.steps.iter().any(|step| step.loss.is_nan() && !step.accepted));
}

#[test]
fn parameters_beyond_their_range_are_stepped_back_from() {
    let logarithm = |&[x]: &[f64; 1]| match x {
        x if x > 0.0 => Ok(sums([(x.ln(), [1.0 / x]), (0.0, [0.0])])),
        x => Err(Error::invalid("x", x, "above 0")),
    };
    let method = LevenbergMarquardt::default();
    let solution = method.minimise([8.0], logarithm, &mut silent).expect("ln x = 0");
    assert!((solution.parameters[0] - 1.0).abs() < 1e-9 && solution.converged());
    assert!(solution.steps.iter().any(|step| step.loss == f64::INFINITY && !step.accepted));
    let error = method.minimise([-8.0], logarithm, &mut silent).expect_err("no start");
    assert_eq!(error.to_string(), "x is -8; valid: above 0");
}

#[test]
fn short_steps_that_were_forced_are_not_a_minimum() {
    // The derivative's sign is wrong: no step lowers the loss.
    let wrong = |&[x]: &[f64; 1]| Ok(sums([(x - 1.0, [-1.0]), (2.0, [0.0])]));
    let solution = LevenbergMarquardt::default().minimise([3.0], wrong, &mut silent).expect("an end");
    assert_eq!((solution.stop, solution.parameters), (Stop::Stalled, [3.0]));
    assert!(!solution.converged());
    // A first λ that makes every step negligible falls.
    let heavy = LevenbergMarquardt { damping: 1e14, ..LevenbergMarquardt::default() };
    let solution = heavy.minimise([5.0, -7.0], |x| Ok(line(x)), &mut silent).expect("a line");
    assert!(solution.converged() && (solution.parameters[0] - 1.0).abs() < 1e-5, "{solution:?}");
}

#[test]
fn an_exact_start_is_a_minimum() {
    let solution =
        LevenbergMarquardt::default().minimise([1.0, 1.0], rosenbrock(1.0), &mut silent).expect("a minimum");
    assert_eq!((solution.stop, solution.steps.len()), (Stop::Gradient, 1));
}

#[test]
fn bad_settings_and_starts_are_named() {
    let method = LevenbergMarquardt::default();
    let refused = |method: LevenbergMarquardt, start: [f64; 2]| {
        method.minimise(start, |x| Ok(line(x)), &mut silent).expect_err("refused").to_string()
    };
    let none = LevenbergMarquardt { max_iterations: 0, ..method };
    assert_eq!(refused(none, [0.0; 2]), "max_iterations is 0; valid: 1 … 100000");
    let damping = LevenbergMarquardt { damping: f64::NAN, ..method };
    assert_eq!(refused(damping, [0.0; 2]), "damping is NaN; valid: finite and above 0");
    let step = LevenbergMarquardt { step_tolerance: f64::NAN, ..method };
    assert_eq!(refused(step, [0.0; 2]), "step_tolerance is NaN; valid: at least 0, below 1");
    assert_eq!(refused(method, [0.0, f64::NAN]), "start[1] is NaN; valid: finite numbers");
    let error = method.minimise([0.0], |_| Err(Error::Cancelled), &mut silent);
    assert_eq!(error, Err(Error::Cancelled));
}

#[test]
fn equations_that_no_damping_makes_solvable_end_it() {
    // No residuals have such a JᵀJ: its entry beside the diagonal overflows in scaled parameters.
    let hessian = [[1e-300, 1e300], [1e300, 1.0]];
    let broken = |_: &[f64; 2]| Ok(NormalEquations { loss: 1.0, gradient: [1e-150, 1.0], hessian, rays: 2 });
    let method = LevenbergMarquardt { negligible: 0.0, ..LevenbergMarquardt::default() };
    let solution = method.minimise([0.0; 2], broken, &mut silent).expect("the start");
    assert_eq!((solution.stop, solution.parameters), (Stop::Iterations, [0.0; 2]));
}

#[test]
fn damping_that_fell_below_all_numbers_rises_again() {
    // The first step, which is accepted, divides the least damping that there is; then the equations are singular.
    let then_singular = |&[a, b]: &[f64; 2]| {
        let start = [(a + b - 1.0, [1.0, 1.0]), (a - b - 1.0, [1.0, -1.0])];
        Ok(if a + b > 7.0 { sums(start) } else { sums([(a + b - 3.0, [1.0, 1.0])]) })
    };
    let method = LevenbergMarquardt { damping: 5e-324, ..LevenbergMarquardt::default() };
    let solution = method.minimise([5.0, 3.0], then_singular, &mut silent).expect("an end");
    // Factorisations fail until λ is enough; it ends all the same.
    assert!(solution.steps[1].accepted && solution.equations.loss < 1e-20, "{solution:?}");
    assert!(solution.stop.converged() && !solution.converged(), "{solution:?}");
}

#[test]
fn every_level_starts_where_the_one_before_ended() {
    struct Line(f64);
    impl Level<1> for Line {
        fn begin(&mut self, start: &[f64; 1]) -> Result<()> {
            assert!((start[0] - (self.0 - 1.0)).abs() < 1e-9, "{start:?}");
            Ok(())
        }

        fn evaluate(&self, &[x]: &[f64; 1]) -> Result<NormalEquations<1>> {
            Ok(sums([(x - self.0, [1.0])]))
        }
    }
    let methods = CoarseToFine::default();
    let mut numbers = Vec::new();
    let mut note = |level: usize, _: &Step<1>| {
        numbers.push(level);
        if level == 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let mut levels = [1.0, 2.0, 3.0, 4.0].map(Line);
    let found = methods.minimise(&mut levels, [0.0], &mut note).expect("three levels");
    assert_eq!((found.len(), found.finest().stop), (3, Stop::Cancelled));
    assert_eq!(found.evaluations(), numbers.len());
    assert!(
        methods.minimise::<1>(&mut [] as &mut [Line], [0.0], &mut |_, _| ControlFlow::Continue(())).is_err()
    );
}

#[test]
fn an_end_is_said_in_words() {
    for stop in
        [Stop::Gradient, Stop::Step, Stop::Reduction, Stop::Stalled, Stop::Iterations, Stop::Cancelled]
    {
        assert_eq!(stop.to_string().starts_with("at a minimum"), stop.converged(), "{stop}");
    }
}
