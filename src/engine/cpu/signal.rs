//! From areal densities to the detector's signal, in float32.

use std::sync::Arc;

use crate::engine::cpu::bins::{Bins, Wide};
use crate::engine::cpu::level::{self, LANES, Level};
use crate::physics::{MAX_MATERIALS, Quadrature, SpectralModel};

/// A sum of transmissions below this is due to bins whose weight float32 holds badly or not at all.
pub(crate) const FAINT: f64 = 1e-30;

/// A spectral model laid out for float32.
#[derive(Debug, Clone)]
pub(super) struct Signal {
    model: Arc<SpectralModel>,
    all: Bins,
    /// The few energies that stand for all of them, and where they do.
    few: Option<(Quadrature, Bins)>,
}

impl Signal {
    pub(super) fn new(model: Arc<SpectralModel>, quadrature: Option<&Quadrature>) -> Self {
        let few = quadrature.map(|quadrature| (quadrature.clone(), Bins::of(&quadrature.model(&model))));
        Self { all: Bins::of(&model), few, model }
    }

    /// Signal of a ray that meets nothing.
    pub(super) fn i0(&self) -> f64 {
        self.model.i0()
    }

    /// A lower bound of the optical depth in every bin with weight.
    pub(super) fn least_depth(&self, areal_density: &[f64; MAX_MATERIALS]) -> f64 {
        (0..self.model.materials()).map(|m| self.model.least_attenuation(m) * areal_density[m]).sum()
    }

    /// What a ray is summed over: the few energies only where their error is known.
    fn bins(&self, areal_density: &[f64; MAX_MATERIALS]) -> &Bins {
        // As they will be summed: rounding may lift them above a limit.
        let rounded = areal_density.map(|areal| f64::from(areal as f32));
        match &self.few {
            Some((quadrature, few)) if quadrature.holds(&rounded[..self.model.materials()]) => few,
            _ => &self.all,
        }
    }

    /// Intensity and line integral, by log-sum-exp: with `τ_k = Σ_m (μ/ρ)_m(E_k) A_m` and
    /// `t = min_k τ_k`, `p = t − ln Σ_k w_k exp(t − τ_k)` and `I = I0 exp(−p)`. Nothing overflows, and I underflows to 0 while p stays finite.
    pub(super) fn of(&self, areal_density: &[f64; MAX_MATERIALS], depth: &mut Vec<Wide>) -> (f64, f64) {
        let mut passing = [0.0];
        let least = self.bins(areal_density).pass(areal_density.iter().copied(), depth, &mut passing);
        self.beyond(areal_density, least, passing[0])
    }

    /// Of what passes beyond the least depth.
    fn beyond(&self, areal_density: &[f64; MAX_MATERIALS], least: f64, beyond: f64) -> (f64, f64) {
        if beyond < FAINT {
            let seen = &areal_density[..self.model.materials()];
            return (self.model.intensity(seen), self.model.line_integral(seen));
        }
        let line_integral = least - beyond.ln();
        (self.i0() * (-line_integral).exp(), line_integral)
    }

    /// As [`Signal::of`], of 16 rays at once. Areal densities come with their materials; all others are 0.
    #[inline(always)]
    pub(super) fn of_lanes<S: Level>(
        &self,
        simd: S,
        areal_densities: &[(usize, level::Wide)],
        depth: &mut Vec<level::Wide>,
    ) -> [(f64, f64); LANES] {
        let mut rays = [[0.0; MAX_MATERIALS]; LANES];
        for (material, areal) in areal_densities {
            for n in 0..LANES {
                rays[n][*material] = f64::from(areal[n]);
            }
        }
        let materials = self.model.materials();
        let holds = |ray: &[f64; MAX_MATERIALS]| {
            self.few.as_ref().is_some_and(|(quadrature, _)| quadrature.holds(&ray[..materials]))
        };
        let by_few = rays.each_ref().map(holds);
        let mut sums = ([0.0; LANES], [0.0; LANES]);
        if let (Some((_, few)), true) = (&self.few, by_few.contains(&true)) {
            sums = few.pass_lanes(simd, areal_densities, depth);
        }
        if by_few.contains(&false) {
            let all = self.all.pass_lanes(simd, areal_densities, depth);
            for (n, _) in by_few.iter().enumerate().filter(|(_, few)| !**few) {
                (sums.0[n], sums.1[n]) = (all.0[n], all.1[n]);
            }
        }
        let mut signals = [(self.i0(), 0.0); LANES];
        for n in 0..LANES {
            if rays[n] != [0.0; MAX_MATERIALS] {
                signals[n] = self.beyond(&rays[n], f64::from(sums.0[n]), sums.1[n]);
            }
        }
        signals
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{EnergyGrid, MassAttenuation, Spectrum};

    /// An opaque ray is seen through one faint line: 80 mm of titanium, lines at 20 and at 150 keV.
    #[test]
    fn faint_bins_are_not_lost() {
        let grid = EnergyGrid::new(20.0, 130.0, 2).expect("valid");
        for faint in [1e-60, 1e-44, 1e-38, 1e-30, 1e-20, 1e-6] {
            let spectrum = Spectrum::new("two lines", grid, vec![1.0, faint]).expect("valid");
            let titanium = MassAttenuation::named(&["titanium"], grid).expect("tabulated");
            let model = SpectralModel::new(&spectrum, &titanium).expect("valid");
            let mut areal_density = [0.0; MAX_MATERIALS];
            areal_density[0] = 8.0 * 4.54;
            let exact = model.line_integral(&areal_density[..1]);
            let (_, got) = Signal::new(Arc::new(model), None).of(&areal_density, &mut Vec::new());
            assert!((got - exact).abs() <= 2e-6 * exact + 1e-6, "weight {faint}: {got} for {exact}");
        }
    }
}
