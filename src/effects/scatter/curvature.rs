//! What the separable correction of [`Obliquity`] leaves of the longer way out of a round object.

use super::excursion::Surroundings;
use super::obliquity::Obliquity;

/// Distances at which the object around a cell is looked at.
const RINGS: usize = 8;

/// The part of each Gaussian's amplitude that a round object lets through.
#[derive(Debug)]
pub(super) struct Curvature<'a> {
    obliquity: &'a Obliquity,
    surroundings: &'a Surroundings<'a>,
    /// Distances of targets in the detector's plane, mm.
    radii: [f64; RINGS],
    /// For each Gaussian, how much of it is at each distance, up to a factor.
    often: Vec<[f64; RINGS]>,
}

impl<'a> Curvature<'a> {
    /// For Gaussians with standard deviations `widths` mm and targets up to `farthest` mm away.
    pub(super) fn new(
        obliquity: &'a Obliquity,
        surroundings: &'a Surroundings<'a>,
        widths: &[f64],
        farthest: f64,
    ) -> Self {
        let radii = std::array::from_fn(|k| farthest * (k as f64 + 0.5) / RINGS as f64);
        let often = |width: &f64| radii.map(|radius: f64| radius * (-0.5 * (radius / width).powi(2)).exp());
        Self { obliquity, surroundings, radii, often: widths.iter().map(often).collect() }
    }

    /// Multiplies the amplitudes of a cell's Gaussians by the mean of [`Obliquity::missed`] over targets, each as important
    /// as it is thick compared to the cell: behind the rim and beside the object there is far more primary than scatter.
    pub(super) fn reduce(&self, cell: usize, amplitudes: &mut [f64]) {
        if !(self.surroundings.areal_density[cell] > 0.0) {
            return;
        }
        let rings = self.radii.map(|radius| self.ring(cell, radius));
        for (amplitude, often) in amplitudes.iter_mut().zip(&self.often) {
            let sum = |k: usize| often.iter().zip(&rings).map(|(often, ring)| often * ring[k]).sum::<f64>();
            let [weights, factors] = [0, 1].map(sum);
            // Gaussians within the first ring and objects within it are left as they are.
            if weights > 0.0 {
                *amplitude *= factors / weights;
            }
        }
    }

    /// Sums over directions of the weights of targets at a distance, and of the weighted factors.
    fn ring(&self, cell: usize, radius: f64) -> [f64; 2] {
        let here = self.surroundings.areal_density[cell];
        let outer = 0.1 * radius / self.obliquity.magnification;
        let inner = outer * self.obliquity.aside(here);
        self.surroundings.sum(cell, [inner, outer], |leaving, target| {
            let weight = (target / here).min(1.0);
            [weight, weight * self.obliquity.missed(here, leaving, target)]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_lose_nothing_and_cylinders_lose_wide_scatter() {
        let obliquity = Obliquity { gap_mm: 500.0, magnification: 1.5, attenuation: 0.2 };
        let (count, cell_cm, widths) = ([61, 61], [0.5, 0.5], [1.0, 20.0, 60.0, 180.0]);
        let reduced = |areal_density: &[f64]| {
            let surroundings = Surroundings { areal_density, count, cell_cm };
            let mut amplitudes = [1.0; 4];
            Curvature::new(&obliquity, &surroundings, &widths, 200.0).reduce(30 * 61 + 30, &mut amplitudes);
            amplitudes
        };
        assert!(reduced(&vec![20.0; 61 * 61]).iter().all(|part| (part - 1.0).abs() < 1e-12));
        let areal = |cell: usize| {
            let x = 0.5 * ((cell % 61) as f64 - 30.0);
            2.0 * (100.0 - x * x).max(0.0).sqrt()
        };
        let cylinder = reduced(&(0..61 * 61).map(areal).collect::<Vec<_>>());
        let falls = cylinder.windows(2).all(|pair| pair[1] <= pair[0] + 1e-12);
        assert!(falls && cylinder[3] > 0.8 && cylinder[3] < 0.97, "{cylinder:?}");
        // exp(−μ M x²/2 gap), x the object's way across: 1/√(1 + μ M σ²/(gap M²)) of a Gaussian of 2 cm.
        let expected = 1.0 / (1.0_f64 + 0.2 * 1.5 * 4.0 / 50.0 / 2.25).sqrt();
        assert!((cylinder[1] - expected).abs() < 5e-3, "{} for {expected}", cylinder[1]);
    }
}
