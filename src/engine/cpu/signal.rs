//! From areal densities to the detector's signal, in float32.

use std::sync::Arc;

use crate::engine::cpu::bins::{Bins, WIDTH, Wide};
use crate::physics::{MAX_MATERIALS, Quadrature, SpectralModel};

/// Terms that are summed in float32 before the sum goes to float64.
const BLOCK: usize = 16;

/// A sum of transmissions below this is due to bins whose weight float32 holds badly or not at all.
const FAINT: f64 = 1e-30;

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
        let bins = self.bins(areal_density);
        depth.clear();
        depth.resize(bins.weights.len(), [0.0; WIDTH]);
        let mut present = false;
        for (row, &areal) in bins.coefficients.iter().zip(areal_density) {
            let areal = areal as f32;
            if areal != 0.0 {
                present = true;
                for (depth, mu) in depth.iter_mut().zip(row) {
                    (0..WIDTH).for_each(|i| depth[i] += areal * mu[i]);
                }
            }
        }
        if !present {
            return (self.i0(), 0.0);
        }
        let mut least = [f32::INFINITY; WIDTH];
        for depth in &*depth {
            (0..WIDTH).for_each(|i| least[i] = least[i].min(depth[i]));
        }
        let least = least.into_iter().fold(f32::INFINITY, f32::min);
        let mut beyond = 0.0;
        for (weights, depths) in bins.weights.chunks(BLOCK).zip(depth.chunks(BLOCK)) {
            let mut sum = [0.0; WIDTH];
            for (weight, depth) in weights.iter().zip(depths) {
                let transmitted = exp_minus(&std::array::from_fn(|i| depth[i] - least));
                (0..WIDTH).for_each(|i| sum[i] += weight[i] * transmitted[i]);
            }
            beyond += sum.into_iter().map(f64::from).sum::<f64>();
        }
        beyond /= bins.weight_sum;
        if beyond < FAINT {
            let seen = &areal_density[..self.model.materials()];
            return (self.model.intensity(seen), self.model.line_integral(seen));
        }
        let line_integral = f64::from(least) - beyond.ln();
        (self.i0() * (-line_integral).exp(), line_integral)
    }
}

/// exp(−x) for x ≥ 0, relative error below 2e-7 + x·1e-7; 0 below 2⁻¹²⁶. The second term is harmless here: such a
/// term of the sum is itself smaller by exp(−x), and sums without any larger one go to float64.
#[inline(always)]
fn exp_minus(x: &Wide) -> Wide {
    const ROUND: f32 = 12_582_912.0; // 1.5·2²³, see path::nearest
    // Taylor series of exp on |r| ≤ ln(2)/2: the first term left out is below 6e-9.
    const SERIES: [f32; 7] = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];
    let (mut power, mut r, mut scale) = ([1.0 / 5040.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
    for i in 0..WIDTH {
        let y = x[i] * -std::f32::consts::LOG2_E;
        let kept = if y > -126.0 { y } else { -126.0 };
        let shifted = kept + ROUND;
        r[i] = (kept - (shifted - ROUND)) * std::f32::consts::LN_2;
        let exponent = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
        scale[i] = if y < -126.0 { 0.0 } else { exponent };
    }
    for coefficient in SERIES {
        for i in 0..WIDTH {
            power[i] = power[i] * r[i] + coefficient;
        }
    }
    std::array::from_fn(|i| power[i] * scale[i])
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

    #[test]
    fn the_exponential_is_accurate_and_underflows_to_zero() {
        for k in 0..200_000 {
            let x = k as f32 * 4.3e-4;
            let exact = f64::from(-x).exp();
            let relative = (f64::from(exp_minus(&[x; WIDTH])[0]) / exact - 1.0).abs();
            assert!(relative < 2e-7 + 1e-7 * f64::from(x), "x = {x}: {relative}");
        }
        assert_eq!(
            exp_minus(&[0.0, 88.0, f32::INFINITY, 0.0, 1e30, 0.0, 0.0, 0.0]),
            [1., 0., 0., 1., 0., 1., 1., 1.]
        );
    }
}
