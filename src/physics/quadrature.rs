//! The sum over energies with fewer of them.

mod alloy;
mod bound;
mod choice;
mod expansion;
mod training;

use serde::Serialize;

use crate::physics::SpectralModel;
use crate::physics::quadrature::alloy::Alloy;
use crate::physics::quadrature::bound::Bound;
use crate::physics::quadrature::choice::Choice;

/// One energy of a reduced sum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Node {
    /// keV.
    pub kev: f64,
    /// Relative weight; all sum to 1.
    pub weight: f64,
    /// Index among the bins of the model.
    #[serde(skip)]
    bin: usize,
}

/// A few of a spectrum's bins with new weights, which give the line integral of all bins with a bounded error, over a box
/// of areal densities.
///
/// With materials' coefficients and the spectrum fixed, what passes is an integral over energies whose integrands
/// `exp(−τ)` are alike, so that, as with Gauss's rule, a few energies give it to many digits. They are chosen on
/// sample paths, but the bound is computed for every path of the box.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Quadrature {
    nodes: Vec<Node>,
    limits: Vec<f64>,
    floor: f64,
    bound: f64,
}

impl Quadrature {
    /// The fewest of `model`'s bins found for which `|Δp| ≤ tolerance · max(p, floor)` for all areal densities
    /// `0 ≤ A_m ≤ limits[m]` (g/cm², one per material; 0: the material is absent).
    ///
    /// `None` where that takes all bins, where the bound cannot be had with reasonable work, and unless `floor`
    /// and `tolerance` are finite and above 0 and the limits finite, at least 0, one per material. Tolerances near
    /// the 1e-13 of float64's own rounding cannot be bounded.
    pub fn new(model: &SpectralModel, limits: &[f64], floor: f64, tolerance: f64) -> Option<Self> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let valid = limits.iter().all(|limit| *limit == 0.0 || positive(*limit));
        if limits.len() != model.materials() || !valid || !positive(floor) || !positive(tolerance) {
            return None;
        }
        if !model.line_integral(limits).is_finite() {
            return None;
        }
        let found = Choice::new(model, limits, floor, tolerance).nodes();
        let alloy = Alloy::new(model, limits);
        if !alloy.limits().iter().all(|limit| limit.is_finite()) {
            return None;
        }
        let fewer = found.into_iter().rev().filter(|(bins, _)| bins.len() < model.bins());
        fewer.take(3).find_map(|(bins, weights)| {
            let bound = Bound::new(&alloy, (&bins, &weights), floor, tolerance).over_all()?;
            let node = |(bin, weight): (usize, f64)| Node { kev: model.energies()[bin], weight, bin };
            let nodes = bins.into_iter().zip(weights).map(node).collect();
            Some(Self { nodes, limits: limits.to_vec(), floor, bound })
        })
    }

    /// The energies, in ascending order.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The largest areal density of each material for which the bound holds, g/cm².
    pub fn limits(&self) -> &[f64] {
        &self.limits
    }

    /// The line integral below which the bound is one of the absolute error divided by this.
    pub fn floor(&self) -> f64 {
        self.floor
    }

    /// Bound of `|Δp| / max(p, floor)` within the limits.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// Whether the bound holds for these areal densities.
    pub fn holds(&self, areal_density: &[f64]) -> bool {
        areal_density.len() == self.limits.len()
            && areal_density.iter().zip(&self.limits).all(|(areal, limit)| (0.0..=*limit).contains(areal))
    }

    /// The reduced sum as a model of its own: the I0 and materials of `exact`, the model this was made for, and only
    /// the nodes. Its least attenuation is that of all bins.
    ///
    /// # Panics
    /// When `exact` has too few bins to be that model.
    pub fn model(&self, exact: &SpectralModel) -> SpectralModel {
        let bins: Vec<usize> = self.nodes.iter().map(|node| node.bin).collect();
        exact.of_bins(&bins, self.nodes.iter().map(|node| node.weight).collect())
    }
}

#[cfg(test)]
mod tests;
