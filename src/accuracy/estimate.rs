//! A root mean square of all rays, estimated from some of them.

use serde::Serialize;

/// The confidence that is aimed at with [`Estimate::rms_high`]. Where a few rays have most of the error it is less: the test
/// `truthfulness` tells how often bounds hold.
pub const CONFIDENCE: f64 = 0.99;

/// Student's t for that confidence, one-sided, by degrees of freedom from 1 on.
const STUDENT: [f64; 7] = [31.821, 6.965, 4.541, 3.747, 3.365, 3.143, 2.998];

/// What none of n rays shows is, with that confidence, true of no more than this over n of all: −ln(0.01). The rule of
/// three has −ln(0.05) (Hanley and Lippman-Hand, JAMA 249(13), 1743, 1983).
const UNSEEN: f64 = 4.605;

/// How much larger than the largest error seen those may be that are not.
const LARGER: f64 = 1.5;

/// The size of an error over some rays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Estimate {
    /// Root mean square over the rays that were looked at.
    pub rms: f64,
    /// What that of all rays is below, with [`CONFIDENCE`]; `rms` itself when all rays were looked at. It leaves room for
    /// errors half as large again as the largest seen, as many as could have gone unseen.
    pub rms_high: f64,
    /// Largest absolute value among the rays that were looked at.
    pub max: f64,
    /// Rays that were looked at.
    pub rays: usize,
}

impl Estimate {
    /// Of the errors in each replicate of a sample, which is that `part` of all rays; `None` when there are none.
    pub fn of<I: Iterator<Item = f64>>(replicates: impl Iterator<Item = I>, part: f64) -> Option<Self> {
        let (mut sums, mut max) = (Vec::new(), 0.0_f64);
        for replicate in replicates {
            let (mut squares, mut rays) = (0.0, 0_usize);
            for error in replicate {
                squares += error * error;
                max = max.max(error.abs());
                rays += 1;
            }
            sums.push((squares, rays as f64));
        }
        let count = sums.len() as f64;
        let rays: f64 = sums.iter().map(|(_, rays)| rays).sum();
        if rays == 0.0 {
            return None;
        }
        let mean_square = sums.iter().map(|(squares, _)| squares).sum::<f64>() / rays;
        // Replicates have different numbers of rays: the variance of a ratio of means (Cochran, §6.4).
        let off = |(squares, own): &(f64, f64)| (squares - mean_square * own) * count / rays;
        let variance = sums.iter().map(|sum| off(sum).powi(2)).sum::<f64>() / (count * (count - 1.0));
        let spread = match sums.len() {
            1 => 0.0,
            n => STUDENT[(n - 2).min(STUDENT.len() - 1)] * variance.sqrt(),
        };
        let unseen = UNSEEN * (LARGER * max).powi(2) / rays;
        let rms_high = (mean_square + (1.0 - part) * f64::max(spread, unseen)).sqrt();
        Some(Self { rms: mean_square.sqrt(), rms_high, max, rays: rays as usize })
    }
}

/// The errors of two parts of the rays, joined.
impl Estimate {
    /// Of rays that were all looked at, and of a sample of `others` more.
    pub(crate) fn of_strata(
        all: impl Iterator<Item = f64>,
        sampled: Option<Self>,
        others: usize,
    ) -> Option<Self> {
        let known = Self::of(std::iter::once(all), 1.0);
        let Some(known) = known else { return sampled };
        // Of others that none was looked at of, nothing better is known.
        let none = Self { rms: 0.0, rms_high: known.max, max: known.max, rays: 0 };
        let sampled = sampled.unwrap_or(none);
        let (n, m) = (known.rays as f64, others as f64);
        let joined = |of_sampled: f64| ((n * known.rms.powi(2) + m * of_sampled.powi(2)) / (n + m)).sqrt();
        Some(Self {
            rms: joined(sampled.rms),
            rms_high: joined(sampled.rms_high),
            max: known.max.max(sampled.max),
            rays: known.rays + sampled.rays,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_rays_leave_nothing_to_estimate() {
        let all = Estimate::of(std::iter::once([3.0, -4.0].into_iter()), 1.0).expect("rays");
        assert_eq!(all, Estimate { rms: 12.5_f64.sqrt(), rms_high: 12.5_f64.sqrt(), max: 4.0, rays: 2 });
        assert_eq!(Estimate::of(std::iter::once([0.0; 0].into_iter()), 1.0), None);
    }

    /// Skewed errors, as at edges: most are small, a few are twenty times as large.
    #[test]
    fn the_upper_end_is_exceeded_as_rarely_as_it_says() {
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut error = || if uniform() < 0.05 { 20.0 * uniform() } else { uniform() };
        let truth = (0.95 / 3.0 + 0.05 * 400.0 / 3.0_f64).sqrt();
        let (mut exceeded, mut wide) = (0, 0.0);
        for _ in 0..1000 {
            let replicates: Vec<Vec<f64>> = (0..8).map(|_| (0..128).map(|_| error()).collect()).collect();
            let estimate = Estimate::of(replicates.iter().map(|r| r.iter().copied()), 0.0).expect("rays");
            exceeded += usize::from(estimate.rms_high < truth);
            wide += estimate.rms_high / truth / 1000.0;
        }
        assert!(exceeded <= 10, "{exceeded} of 1000");
        assert!(wide < 1.5, "{wide} times as wide as the truth");
    }

    /// One ray in five hundred has nearly all of the error.
    #[test]
    fn rare_large_errors_are_allowed_for() {
        let error = |n: u64| if n % 500 == 7 { 100.0 } else { 0.1 };
        let truth = (100.0_f64.powi(2) / 500.0 + 0.01).sqrt();
        let exceeded = (0..500).filter(|start| {
            let replicates = (0..8).map(|r| (0..128).map(move |k| error(start * 61 + r * 7919 + k * 37)));
            let estimate = Estimate::of(replicates, 0.0).expect("rays");
            // Of a sample without any of them nothing can be said.
            estimate.max > 1.0 && estimate.rms_high < truth
        });
        assert!(exceeded.count() <= 5);
    }
}
