//! A measured modulation transfer function as a mixture of Gaussians.

use crate::effects::BlurComponent;
use crate::effects::taps::gaussian_response;
use crate::error::{Error, Result};
use crate::least_squares::Columns;

/// How many standard deviations, evenly on a logarithmic scale, are tried.
const SIGMAS: usize = 64;
/// Of the smallest, in parts of the shortest period measured: at that frequency its MTF is 0.998.
const NARROWEST: f64 = 0.01;
/// Of the largest, in parts of the longest period measured: at that frequency its MTF is 3e-9.
const WIDEST: f64 = 1.0;
/// How much heavier the sum of the weights counts than any error.
const SUM: f64 = 100.0;
/// Most steps of the non-negative least squares.
const MOST_STEPS: usize = 96;
/// What rounding may make of an MTF of 1.
const ROUNDING: f64 = 1e-9;

/// Most points of a curve.
pub const MAX_MTF_POINTS: usize = 256;

/// Checks the frequencies (line pairs per mm, ascending from at least 0) and the MTF at each.
pub(super) fn validate(frequencies: &[f64], mtf: &[f64]) -> Result<()> {
    if !(2..=MAX_MTF_POINTS).contains(&frequencies.len()) {
        return Err(Error::invalid(
            "mtf: number of points",
            frequencies.len(),
            format!("2 … {MAX_MTF_POINTS}"),
        ));
    }
    if mtf.len() != frequencies.len() {
        let valid = format!("{}, one per frequency", frequencies.len());
        return Err(Error::invalid("mtf: number of values", mtf.len(), valid));
    }
    for (n, &frequency) in frequencies.iter().enumerate() {
        let ascends = n == 0 && frequency >= 0.0 || n > 0 && frequency > frequencies[n - 1];
        if !(ascends && frequency.is_finite()) {
            let valid = "finite, at least 0 and greater than the one before, line pairs per mm";
            return Err(Error::invalid(format!("frequencies_per_mm[{n}]"), frequency, valid));
        }
    }
    for (n, (&value, &frequency)) in mtf.iter().zip(frequencies).enumerate() {
        if !(0.0..=1.0 + ROUNDING).contains(&value) {
            return Err(Error::invalid(format!("mtf[{n}]"), value, "0 … 1"));
        }
        if frequency == 0.0 && value < 1.0 - ROUNDING {
            return Err(Error::invalid(format!("mtf[{n}]"), value, "1 at frequency 0"));
        }
    }
    Ok(())
}

/// At most `most` Gaussians, of standard deviations of at most `limit_mm`, whose MTF is near to the one given: the
/// non-negative least squares over many standard deviations (Lawson & Hanson, 1974, ch. 23) has a few of them only, and
/// of more than `most`, those whose loss costs least go. The arguments have passed `validate`.
pub(super) fn mixture(frequencies: &[f64], mtf: &[f64], limit_mm: f64, most: usize) -> Vec<BlurComponent> {
    let sigmas = sigmas(frequencies, limit_mm);
    let column = |&sigma: &f64| {
        let responses = frequencies.iter().map(move |frequency| gaussian_response(sigma, *frequency));
        responses.chain([SUM])
    };
    let columns = Columns::new(frequencies.len() + 1, sigmas.iter().flat_map(column).collect());
    let target: Vec<f64> = mtf.iter().copied().chain([SUM]).collect();
    let mut support = (Vec::new(), Vec::new());
    let mut steps = 0..MOST_STEPS;
    while steps.next().is_some() && columns.grow(&mut support, &target) {}
    while support.0.len() > most {
        support = without_one(&columns, &support.0, &target);
    }
    let component = |(k, weight): (usize, f64)| BlurComponent { weight, sigma_mm: sigmas[k] };
    let mut components: Vec<_> = support.0.into_iter().zip(support.1).map(component).collect();
    components.sort_by(|a, b| a.sigma_mm.total_cmp(&b.sigma_mm));
    components
}

/// The standard deviations to choose from: none, and those that make a difference at the frequencies measured.
fn sigmas(frequencies: &[f64], limit_mm: f64) -> Vec<f64> {
    let lowest = frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
    let highest = frequencies.iter().copied().fold(lowest, f64::max);
    let widest = (WIDEST / lowest).min(limit_mm);
    let narrowest = (NARROWEST / highest).min(widest);
    let part = |k: usize| k as f64 / (SIGMAS - 1) as f64;
    let sigma = |k: usize| (narrowest * (widest / narrowest).powf(part(k))).min(limit_mm);
    std::iter::once(0.0).chain((0..SIGMAS).map(sigma)).collect()
}

/// The best positive weights on a support with one column less (or more of them, where the weight of others would not
/// stay positive).
fn without_one(columns: &Columns, support: &[usize], target: &[f64]) -> (Vec<usize>, Vec<f64>) {
    let trial = |gone: usize| {
        let mut left: Vec<usize> = support.iter().copied().filter(|k| *k != gone).collect();
        let weights = loop {
            let weights = columns.solve(&left, target);
            if weights.iter().all(|weight| *weight > 0.0) {
                break weights;
            }
            let positive = left.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
            left = positive.map(|(k, _)| *k).collect();
        };
        let residual = columns.residual(&left, &weights, target);
        (residual.iter().map(|value| value * value).sum::<f64>(), (left, weights))
    };
    let trials = support.iter().map(|gone| trial(*gone));
    let best = trials.min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(Default::default, |(_, support)| support)
}
