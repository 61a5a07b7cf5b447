//! A sample of random numbers against the distribution that it should have (for tests).

/// Standard errors within which a moment must be: chance leaves them once in two million moments.
const STANDARD_ERRORS: f64 = 5.0;

/// Random numbers that were drawn.
pub(super) struct Sample {
    values: Vec<f64>,
}

impl Sample {
    pub(super) fn new(values: Vec<f64>) -> Self {
        Self { values }
    }

    /// Mean, variance and third central moment within the errors that a sample of this size has. They are estimated
    /// from the sample itself.
    pub(super) fn assert_cumulants(&self, [mean, variance, third]: [f64; 3], what: &str) {
        for (power, expected) in [(1, 0.0), (2, variance), (3, third)] {
            let (found, error) = self.moment(mean, power);
            let distance = (found - expected).abs();
            assert!(
                distance <= STANDARD_ERRORS * error,
                "{what}, moment {power}: {found}, not {expected} ± {error}"
            );
        }
    }

    /// The mean of (value − centre)^power and its standard error.
    fn moment(&self, centre: f64, power: i32) -> (f64, f64) {
        let n = self.values.len() as f64;
        let powers = || self.values.iter().map(|value| (value - centre).powi(power));
        let mean = powers().sum::<f64>() / n;
        let variance = powers().map(|p| (p - mean) * (p - mean)).sum::<f64>() / n;
        (mean, (variance / n).sqrt())
    }

    /// The part of the sample that is `value`.
    pub(super) fn share_of(&self, value: f64) -> f64 {
        self.values.iter().filter(|v| **v == value).count() as f64 / self.values.len() as f64
    }

    /// The largest distance between the two samples' distribution functions (Kolmogorov, Smirnov).
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let sorted = |sample: &Self| {
            let mut values = sample.values.clone();
            values.sort_by(f64::total_cmp);
            values
        };
        let (a, b) = (sorted(self), sorted(other));
        let below = |values: &[f64], x: f64| values.partition_point(|v| *v <= x) as f64 / values.len() as f64;
        a.iter().chain(&b).map(|x| (below(&a, *x) - below(&b, *x)).abs()).fold(0.0, f64::max)
    }

    /// The correlation coefficient of two samples, pair by pair.
    pub(super) fn correlation(&self, other: &Self) -> f64 {
        let n = self.values.len() as f64;
        let mean = |s: &Self| s.values.iter().sum::<f64>() / n;
        let (a, b) = (mean(self), mean(other));
        let pairs = || self.values.iter().zip(&other.values).map(|(x, y)| (x - a, y - b));
        let sum = |product: fn((f64, f64)) -> f64| pairs().map(product).sum::<f64>();
        sum(|(x, y)| x * y) / (sum(|(x, _)| x * x) * sum(|(_, y)| y * y)).sqrt()
    }
}
