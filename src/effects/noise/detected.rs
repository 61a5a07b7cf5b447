//! The signal of the photons that a pixel detects.

use crate::effects::noise::normal::normal_quantile;
use crate::effects::noise::poisson::poisson_quantile;

/// Variance of the gains, relative to their squared mean, that is rounding of the moments and no spread.
const ROUNDING: f64 = 1e-12;

/// The photons that a pixel is expected to detect, of many energies: Poisson numbers of means λₖ that do not depend on
/// each other, each photon of which adds its gain gₖ to the signal.
///
/// The signal's cumulants are the moments: mean `m₁`, variance `m₂`, third central moment `m₃` (compound Poisson; for
/// X-rays R. K. Swank, J. Appl. Phys. 44 (1973) 4199, and B. R. Whiting, Proc. SPIE 4682 (2002) 53). What has the same
/// moments as the gains gives the same mean, variance and skewness.
///
/// The distribution function, for the energies that the built-in panel's top layer absorbs of the default tube, is that
/// of all energies to 0.1 at 0.3 photons, 0.02 at 10, 0.009 at 30, 0.005 at 100 and less above (600000 samples of each).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Photons {
    /// `m_r = Σ λₖ gₖʳ` for r = 0 … 3, gains at least 0. `m₀` is the number of photons.
    pub(crate) moments: [f64; 4],
}

/// Photons of one gain.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    gain: f64,
    /// Their expected number.
    photons: f64,
}

impl Photons {
    /// The signal, in units of the gains, for three uniform numbers in (0, 1): two for the photons, one for the
    /// electronic noise of standard deviation `electronic_sigma`, in the units of the signal.
    ///
    /// Mean, variance and third central moment are those of all energies' photons, and so is the probability that none
    /// is detected, `exp(−m₀)`. With one gain it is a Poisson number times the gain.
    pub(crate) fn signal(&self, draws: [f64; 3], electronic_sigma: f64) -> f64 {
        let [lower, upper] = self.nodes();
        lower.gain * poisson_quantile(draws[0], lower.photons)
            + upper.gain * poisson_quantile(draws[1], upper.photons)
            + electronic(draws, electronic_sigma)
    }

    /// The signal's mean, with electronic noise alone.
    pub(crate) fn mean_signal(&self, draws: [f64; 3], electronic_sigma: f64) -> f64 {
        self.moments[1] + electronic(draws, electronic_sigma)
    }

    /// Two gains, the lower one first, and the photons of each whose moments 0 … 3 are these: Gauss's quadrature of
    /// the measure of gains (G. H. Golub and J. H. Welsch, Math. Comp. 23 (1969) 221; W. Gautschi, "Orthogonal
    /// Polynomials", Oxford 2004, sec. 1.4).
    ///
    /// In units of the gains' standard deviation about their mean, the nodes are the roots of `t² − γ t − 1`, γ being
    /// the skewness of the gains, with the weights `1 / (1 + t²)`. The product of the roots is −1, which gives the
    /// smaller one without cancellation.
    fn nodes(&self) -> [Node; 2] {
        let none = Node { gain: 0.0, photons: 0.0 };
        let [photons, m1, m2, m3] = self.moments;
        if photons == 0.0 {
            return [none; 2];
        }
        let [mean, second, third] = [m1 / photons, m2 / photons, m3 / photons];
        let variance = second - mean * mean;
        if variance <= ROUNDING * mean * mean {
            return [Node { gain: mean, photons }, none];
        }
        let deviation = variance.sqrt();
        let skewness = (third - mean * (3.0 * second - 2.0 * mean * mean)) / (variance * deviation);
        let larger = 0.5 * (skewness + (skewness.hypot(2.0)).copysign(skewness));
        let node = |t: f64| Node {
            // Nodes lie among the gains; rounding may lead a little below a gain of 0.
            gain: if mean + deviation * t < 0.0 { 0.0 } else { mean + deviation * t },
            photons: photons / (1.0 + t * t),
        };
        if larger > 0.0 { [node(-1.0 / larger), node(larger)] } else { [node(larger), node(-1.0 / larger)] }
    }
}

fn electronic(draws: [f64; 3], sigma: f64) -> f64 {
    if sigma == 0.0 { 0.0 } else { sigma * normal_quantile(draws[2]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::noise::random::RowRandom;
    use crate::effects::noise::sample::Sample;

    fn photons(bins: &[(f64, f64)]) -> Photons {
        let moment = |r| bins.iter().map(|(gain, mean)| mean * gain.powi(r)).sum();
        Photons { moments: [0, 1, 2, 3].map(moment) }
    }

    #[test]
    fn two_nodes_have_the_moments_of_many_gains() {
        let mut random = RowRandom::new(3, 0, 0, 0);
        for count in (2..40).chain([500]) {
            let bin = |[gain, mean, _]: [f64; 3]| (150.0 * gain, 10.0_f64.powf(20.0 * mean - 10.0));
            let bins: Vec<_> = (0..count).map(|_| bin(random.draws())).collect();
            let many = photons(&bins);
            let nodes = many.nodes();
            let few = photons(&nodes.map(|node| (node.gain, node.photons)));
            for (found, expected) in few.moments.iter().zip(many.moments) {
                assert!((found / expected - 1.0).abs() < 1e-10, "{count} gains: {few:?}, not {many:?}");
            }
            let (least, most) =
                bins.iter().fold((f64::MAX, 0.0_f64), |(l, m), (g, _)| (l.min(*g), m.max(*g)));
            assert!(nodes.iter().all(|node| node.photons >= 0.0), "{nodes:?}");
            let margin = 1e-3 * most;
            let among = least - margin..=most + margin;
            assert!(nodes.iter().all(|n| among.contains(&n.gain)), "{nodes:?} of {least} … {most}");
        }
    }

    #[test]
    fn two_gains_are_found_again() {
        for (few, many) in [((20.0, 3.0), (60.0, 0.5)), ((20.0, 0.5), (60.0, 3.0)), ((0.0, 7.0), (1.0, 7.0))]
        {
            for (node, (gain, mean)) in photons(&[many, few]).nodes().iter().zip([few, many]) {
                assert!((node.gain - gain).abs() < 1e-13 * 60.0, "{node:?}, not {gain}");
                assert!((node.photons / mean - 1.0).abs() < 1e-13, "{node:?}, not {mean}");
            }
        }
    }

    #[test]
    fn one_gain_is_one_poisson_number() {
        let mut random = RowRandom::new(4, 0, 0, 0);
        for gain in [1.0, 0.3, 57.123] {
            for mean in [1e-9, 0.7, 1e3, 1e12] {
                // As from many bins of the same gain, with their rounding.
                let photons = photons(&[(gain, mean / 3.0), (gain, mean / 7.0), (gain, mean * 11.0 / 21.0)]);
                let draws = random.draws();
                let (signal, count) = (photons.signal(draws, 0.0), poisson_quantile(draws[0], mean));
                assert!((signal - gain * count).abs() <= 1e-14 * gain * count, "{gain}, {mean}: {signal}");
            }
        }
    }

    #[test]
    fn without_photons_there_is_electronic_noise_alone() {
        let dark = Photons { moments: [0.0; 4] };
        assert_eq!(dark.signal([0.9, 0.9, 0.9], 0.0), 0.0);
        assert_eq!(dark.signal([0.9, 0.9, 0.9], 3.0), 3.0 * normal_quantile(0.9));
        assert_eq!(dark.mean_signal([0.9, 0.9, 0.1], 3.0), 3.0 * normal_quantile(0.1));
    }

    #[test]
    fn electronic_noise_adds_its_variance() {
        let photons = photons(&[(1.0, 4.0), (3.0, 2.0)]);
        let [_, mean, variance, third] = photons.moments;
        let mut random = RowRandom::new(5, 0, 0, 0);
        let noisy = (0..300_000).map(|_| photons.signal(random.draws(), 2.5));
        Sample::new(noisy.collect())
            .assert_cumulants([mean, variance + 6.25, third], "with electronic noise");
        let mut random = RowRandom::new(6, 0, 0, 0);
        let smooth = (0..300_000).map(|_| photons.mean_signal(random.draws(), 2.5));
        Sample::new(smooth.collect()).assert_cumulants([mean, 6.25, 0.0], "electronic noise alone");
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        assert!(Photons { moments: [f64::NAN; 4] }.signal([0.5; 3], 0.0).is_nan());
    }
}
