//! The largest error of a reduced sum over a box of areal densities.

use std::collections::VecDeque;

use crate::physics::quadrature::alloy::Alloy;
use crate::physics::quadrature::expansion::Expansion;
use crate::physics::{MAX_MATERIALS, SpectralModel};

/// Multiplications after which a bound counts as out of reach.
const MOST_WORK: usize = 12_000_000;

/// What a cell costs at least, in multiplications.
const CELL: usize = 5000;

/// Part of a cell's tolerance below which single terms are not looked at.
const SMALL: f64 = 2e-3;

/// The exact sum and a reduced one over the same bins, in the variables of [`Alloy`].
///
/// With `S(A) = Σ_k w_k e^{−τ_k(A)}` and `S'(A)` likewise of the reduced weights, the error of the line integral is
/// `Δp = −ln(S'/S)`. In a cell of the box, `A = c + δ` with `|δ_m| ≤ h_m`, both are written with the weights that they
/// have behind c, `P_k = w_k e^{−τ_k(c)} / S(c)` and `Q_k = w'_k e^{−τ_k(c)} / S(c)`, and with the coefficients'
/// distances from their mean under P, `x_km`:
///
/// `S'/S − 1 = Σ_k (Q_k − P_k) e^{−δ·x_k} / Σ_k P_k e^{−δ·x_k}`
///
/// The denominator is at least 1 by Jensen's inequality, so a bound B of the numerator ([`Expansion`]) gives
/// `|Δp| ≤ −ln(1 − B)`. Cells are halved until this is within the tolerance at the least p of the cell, that of its
/// lower corner. Rounding in float64 is not counted: it is of the order of 1e-13 · max(p, 1).
pub(super) struct Bound<'a> {
    alloy: &'a Alloy,
    model: &'a SpectralModel,
    exact: Vec<f64>,
    reduced: Vec<f64>,
    floor: f64,
    tolerance: f64,
}

#[derive(Debug, Clone, Copy)]
struct Cell {
    low: [f64; MAX_MATERIALS],
    high: [f64; MAX_MATERIALS],
}

enum Verdict {
    /// The relative error is at most this.
    Within(f64),
    /// The tolerance is not kept.
    Beyond,
    /// To be halved along this material.
    Open(usize),
}

impl<'a> Bound<'a> {
    /// Of the sum over the bins `bins` of `model`, with any positive factor of their `weights`.
    pub(super) fn new(
        alloy: &'a Alloy,
        (bins, weights): (&[usize], &[f64]),
        floor: f64,
        tolerance: f64,
    ) -> Self {
        let model = alloy.model();
        let [exact, sum] = [model.weights(), weights].map(|weights| weights.iter().sum::<f64>());
        let mut reduced = vec![0.0; model.bins()];
        bins.iter().zip(weights).for_each(|(&bin, weight)| reduced[bin] += weight / sum);
        let exact = model.weights().iter().map(|weight| weight / exact).collect();
        Self { alloy, model, exact, reduced, floor, tolerance }
    }

    /// Bound of `|Δp| / max(p, floor)` over all paths. `None` where it exceeds the
    /// tolerance, or too much work would tell.
    pub(super) fn over_all(&self) -> Option<f64> {
        let mut whole = Cell { low: [0.0; MAX_MATERIALS], high: [0.0; MAX_MATERIALS] };
        whole.high[..self.model.materials()].copy_from_slice(self.alloy.limits());
        let (mut open, mut largest, mut work) = (VecDeque::from([whole]), 0.0, 0);
        // The largest cells first: where the tolerance is not kept, some centre tells soon.
        while let Some(cell) = open.pop_front() {
            if !self.alloy.meets(&cell.low, &cell.high) {
                continue;
            }
            match self.judge(&cell, &mut work) {
                Verdict::Within(error) => largest = f64::max(largest, error),
                Verdict::Beyond => return None,
                Verdict::Open(material) => open.extend(cell.halves(material)),
            }
            if work > MOST_WORK {
                return None;
            }
        }
        Some(largest)
    }

    fn judge(&self, cell: &Cell, work: &mut usize) -> Verdict {
        let bins = self.model.bins();
        let (centre, half) = cell.centre_and_half();
        let (passing, p) = self.passing(&centre);
        *work += CELL + 10 * bins * self.model.materials();
        let differences: Vec<f64> =
            (0..bins).map(|k| passing[k] * (self.reduced[k] - self.exact[k])).collect();
        let error = differences.iter().sum::<f64>().ln_1p().abs();
        if !(error <= self.tolerance * p.max(self.floor)) && self.alloy.meets(&centre, &centre) {
            return Verdict::Beyond;
        }
        let least = self.passing(&cell.low).1.max(self.floor);
        let allowed = -(-self.tolerance * least).exp_m1();
        let exact: Vec<f64> =
            passing.iter().zip(&self.exact).map(|(passing, weight)| passing * weight).collect();
        let columns: Vec<Vec<f64>> = (0..self.model.materials())
            .filter(|&m| half[m] > 0.0)
            .map(|m| {
                let row = self.model.coefficients(m);
                let mean: f64 = row.iter().zip(&exact).map(|(mu, mass)| mu * mass).sum();
                row.iter().map(|mu| half[m] * (mu - mean)).collect()
            })
            .collect();
        let masses: Vec<f64> = (0..bins).map(|k| exact[k] + passing[k] * self.reduced[k]).collect();
        if let Some(expansion) = Expansion::new(&differences, &columns, &masses, SMALL * allowed) {
            *work += expansion.work();
            let bound = expansion.bound(allowed);
            if bound < allowed {
                return Verdict::Within((-(-bound).ln_1p() / least).min(self.tolerance));
            }
        }
        self.cut(&half, &columns, &masses)
    }

    /// Along the material whose coefficients spread most over the cell.
    fn cut(&self, half: &[f64], columns: &[Vec<f64>], masses: &[f64]) -> Verdict {
        let spread = |column: &[f64]| masses.iter().zip(column).map(|(mass, x)| mass * x * x).sum::<f64>();
        let wide = (0..self.model.materials()).filter(|&m| half[m] > 0.0).zip(columns);
        let widest = wide.max_by(|a, b| spread(a.1).total_cmp(&spread(b.1)));
        widest.map_or(Verdict::Beyond, |(material, _)| Verdict::Open(material))
    }

    /// `e^{−τ_k} / S` of each bin, and p.
    fn passing(&self, areal_density: &[f64]) -> (Vec<f64>, f64) {
        let mut values = vec![0.0; self.model.bins()];
        for (m, areal) in (0..self.model.materials()).zip(areal_density) {
            values.iter_mut().zip(self.model.coefficients(m)).for_each(|(tau, mu)| *tau += mu * areal);
        }
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        for tau in &mut values {
            *tau = (least - *tau).exp();
        }
        let sum: f64 = values.iter().zip(&self.exact).map(|(passing, weight)| passing * weight).sum();
        for passing in &mut values {
            *passing /= sum;
        }
        (values, least - sum.ln())
    }
}

impl Cell {
    fn centre_and_half(&self) -> ([f64; MAX_MATERIALS], [f64; MAX_MATERIALS]) {
        let pair = |sign: f64| std::array::from_fn(|m| 0.5 * (self.high[m] + sign * self.low[m]));
        (pair(1.0), pair(-1.0))
    }

    fn halves(self, material: usize) -> [Self; 2] {
        let middle = 0.5 * (self.low[material] + self.high[material]);
        let (mut below, mut above) = (self, self);
        below.high[material] = middle;
        above.low[material] = middle;
        [below, above]
    }
}
