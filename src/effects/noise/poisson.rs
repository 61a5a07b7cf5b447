//! The quantile of the Poisson distribution.

use std::f64::consts::SQRT_2;

use crate::effects::noise::normal::{normal_quantile, polynomial};

/// Below this mean the probabilities are summed; the expansion's error is within 3e-6 of u from here on.
const SUMMED_BELOW: f64 = 12.0;

/// |s| below which the power series are exact to rounding; their radius of convergence is 2√π.
const SERIES_BELOW: f64 = 0.1;
/// r(s) − 1 = s + s²/6 − …, the inverse of s² / 2 = 1 − r + r ln r, lowest power first.
const EXCESS: [f64; 10] = [
    0.0,
    1.0,
    1.0 / 6.0,
    -1.0 / 72.0,
    1.0 / 270.0,
    -23.0 / 17_280.0,
    19.0 / 34_020.0,
    -11_237.0 / 43_545_600.0,
    13.0 / 102_060.0,
    -2_482_411.0 / 37_623_398_400.0,
];
/// ln(s √r / (r − 1)) / ln r in powers of s, lowest first.
const SHIFT: [f64; 8] = [
    1.0 / 3.0,
    -1.0 / 36.0,
    7.0 / 810.0,
    -137.0 / 38_880.0,
    5.0 / 3_024.0,
    -165_779.0 / 195_955_200.0,
    301.0 / 656_100.0,
    -1_219_369.0 / 4_702_924_800.0,
];
/// More steps of Newton's method than any s needs.
const MOST_STEPS: usize = 12;

/// The smallest count k with P(N ≤ k) ≥ `u` for a Poisson number N of that `mean`, 0 ≤ mean ≤ 1e15, 0 < u < 1.
///
/// From a mean of 12 on, k is that of a u at most 3e-6 away; below, that of u to rounding. NaN stays NaN.
pub(super) fn poisson_quantile(u: f64, mean: f64) -> f64 {
    if mean < SUMMED_BELOW { summed(u, mean) } else { expanded(u, mean) }
}

fn summed(u: f64, mean: f64) -> f64 {
    let mut count = 0.0;
    let mut probability = (-mean).exp();
    let mut sum = probability;
    while sum < u {
        count += 1.0;
        probability *= mean / count;
        let next = sum + probability;
        // The sum of all is 1 but for rounding; a u nearer to 1 than that has no count of its own.
        if next == sum && count > mean {
            break;
        }
        sum = next;
    }
    count
}

/// The incomplete gamma function continues P(N ≤ k) to real k; its inverse by Temme's expansion, which holds from one
/// tail to the other: M. B. Giles, Algorithm 955, ACM Trans. Math. Softw. 42(1) (2016) 7, eqs. for `Q_T` and its
/// correction 0.0218 / (x + 0.065 λ).
fn expanded(u: f64, mean: f64) -> f64 {
    let s = normal_quantile(u) / mean.sqrt();
    // r would be less than 0: u is below P(N = 0).
    if s <= -SQRT_2 {
        return 0.0;
    }
    let (excess, shift) = if s.abs() < SERIES_BELOW {
        (polynomial(&EXCESS, s), polynomial(&SHIFT, s))
    } else {
        let excess = excess(s);
        (excess, (s * (1.0 + excess).sqrt() / excess).ln() / excess.ln_1p())
    };
    let leading = mean + (mean * excess + shift);
    // Never below 0: towards the lowest counts the shift is 1/3 … 1/2, and the correction less than 0.03.
    (leading - 0.0218 / (leading + 0.065 * mean)).floor()
}

/// r − 1 for the r on the side of s of 1 with s² / 2 = 1 − r + r ln r, by Newton's method.
fn excess(s: f64) -> f64 {
    let rest = 1.0 - 0.5 * s * s;
    // Where the series leads below r = 0, r (1 − ln r) = 1 − s²/2 is solved by repeated substitution, once.
    let mut excess = if s < -1.2 { rest / (1.0 - rest.ln()) - 1.0 } else { polynomial(&EXCESS[..4], s) };
    for _ in 0..MOST_STEPS {
        let next = (excess + 0.5 * s * s) / excess.ln_1p() - 1.0;
        let step = next - excess;
        excess = next;
        // The next step would be of the order of this one's square.
        if step.abs() <= 1e-9 * excess.abs().min(1.0 + excess) {
            break;
        }
    }
    excess
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::noise::random::RowRandom;
    use crate::effects::noise::sample::Sample;

    /// Cumulative probabilities of `first`, `first` + 1, …: those within 10 standard deviations and more of the mean,
    /// by the ratios of neighbours from the mode on, which are exact to rounding, and their sum.
    fn cumulative(mean: f64) -> (f64, Vec<f64>) {
        let reach = 10.0 * mean.sqrt() + 40.0;
        let (first, last) = ((mean - reach).max(0.0).floor(), (mean + reach).ceil());
        let mode = mean.floor();
        let mut terms = vec![1.0];
        let mut k = mode;
        while k > first {
            terms.push(terms[terms.len() - 1] * k / mean);
            k -= 1.0;
        }
        terms.reverse();
        while k + (terms.len() as f64) <= last {
            terms.push(terms[terms.len() - 1] * mean / (k + terms.len() as f64));
        }
        let all: f64 = terms.iter().sum();
        let mut sum = 0.0;
        let add = |term: f64| {
            sum += term / all;
            sum
        };
        (first, terms.into_iter().map(add).collect())
    }

    #[test]
    fn counts_are_those_of_the_summed_probabilities() {
        let mut random = RowRandom::new(1, 0, 0, 0);
        let means =
            [1e-6, 1e-3, 0.1, 0.5, 1.0, 3.0, 8.5, 11.9, 12.0, 12.1, 13.7, 20.0, 40.0, 77.7, 300.0, 1e3, 1e4];
        for mean in means {
            let (first, sums) = cumulative(mean);
            let tolerance = if mean < SUMMED_BELOW { 1e-14 } else { 3e-6 };
            for u in (0..2000).flat_map(|_| random.draws()) {
                let count = first + sums.partition_point(|sum| *sum < u) as f64;
                let found = poisson_quantile(u, mean);
                let step = sums[(count.min(found) - first) as usize];
                let same = found == count || (found - count).abs() == 1.0 && (u - step).abs() < tolerance;
                assert!(same, "mean {mean}, u {u}: {found}, not {count}");
            }
        }
    }

    #[test]
    fn tails_are_those_of_the_summed_probabilities() {
        for mean in [12.0, 13.5, 25.0, 100.0, 2.5e3] {
            let (first, sums) = cumulative(mean);
            for exponent in 4..40 {
                let u = 0.5_f64.powi(exponent);
                let count = first + sums.partition_point(|sum| *sum < u) as f64;
                let found = poisson_quantile(u, mean);
                // A count that 0.2 % of its tail's probability would make right.
                let [low, high] =
                    [0.998, 1.002].map(|f| first + sums.partition_point(|sum| *sum < f * u) as f64);
                assert!((low..=high).contains(&found), "mean {mean}, u 2^-{exponent}: {found}, not {count}");
            }
        }
    }

    #[test]
    fn moments_are_the_mean_three_times() {
        for (row, mean) in [1e-3, 0.5, 3.0, 11.9, 12.1, 40.0, 1e3, 1e6, 1e9].into_iter().enumerate() {
            let mut random = RowRandom::new(2, 0, 0, row);
            let draws = (0..333_334).flat_map(|_| random.draws());
            let sample = Sample::new(draws.map(|u| poisson_quantile(u, mean)).collect());
            sample.assert_cumulants([mean; 3], &format!("mean {mean}"));
        }
    }

    #[test]
    fn evenly_spread_quantiles_have_the_moments() {
        // No chance in it: the midpoint rule in u, in whose errors only the outermost parts and steps matter.
        let n = 400_000;
        for mean in [0.5, 3.0, 11.9, 12.1, 40.0, 1e3, 1e6, 1e9, 1e15] {
            let mut moments = [0.0; 3];
            for k in 0..n {
                let u = (f64::from(k) + 0.5) / f64::from(n);
                let deviation = poisson_quantile(u, mean) - mean;
                moments.iter_mut().zip(1..).for_each(|(m, r)| *m += deviation.powi(r) / f64::from(n));
            }
            let sd = mean.sqrt();
            let [first, second, third] = [moments[0] / sd, moments[1] / mean - 1.0, moments[2] / mean - 1.0];
            assert!(first.abs() < 1e-5 && second.abs() < 1e-3, "mean {mean}: {first:e}, {second:e}");
            assert!(mean > 1e4 || third.abs() < 0.01, "mean {mean}: {third:e}");
        }
    }

    #[test]
    fn nothing_expected_is_nothing_counted() {
        for u in [f64::MIN_POSITIVE, 0.5, 1.0 - f64::EPSILON / 2.0] {
            assert_eq!(poisson_quantile(u, 0.0), 0.0);
            assert!(poisson_quantile(u, f64::NAN).is_nan());
        }
    }

    #[test]
    fn the_extremes_of_u_have_a_count() {
        for exponent in -20..=15 {
            let mean = 10.0_f64.powi(exponent);
            let [low, high] = [0.5_f64.powi(53), 1.0 - 0.5_f64.powi(53)].map(|u| poisson_quantile(u, mean));
            let sd = mean.sqrt();
            assert!(low >= (mean - 9.0 * sd - 1.0).max(0.0) && low <= mean, "mean {mean}: {low}");
            assert!(high >= mean.floor() && high <= mean + 9.0 * sd + 20.0, "mean {mean}: {high}");
        }
    }
}
