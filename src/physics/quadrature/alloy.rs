//! Materials that attenuate alike, taken as one and a remainder.

use crate::physics::SpectralModel;

/// Largest part of a material's spread over the energies that may remain.
const REMAINDER: f64 = 0.4;
/// Rounding of areal densities.
const SLACK: f64 = 1e-12;

/// The paths of a box in other variables, in which their box has fewer long sides.
///
/// Where `μ_n = α μ_m + r` with r at least 0 at every energy, `μ_m A_m + μ_n A_n = μ_m (A_m + α A_n) + r A_n`. So the
/// areal densities `A_m + α A_n` and `A_n` of materials with the coefficients `μ_m` and r stand for the same path, and
/// errors hardly vary along the second.
pub(super) struct Alloy {
    model: SpectralModel,
    /// Largest areal densities of the new variables.
    limits: Vec<f64>,
    /// Largest areal densities of the materials themselves.
    own: Vec<f64>,
    /// `(n, m, α)`
    shares: Vec<(usize, usize, f64)>,
}

impl Alloy {
    pub(super) fn new(model: &SpectralModel, limits: &[f64]) -> Self {
        let mut rows: Vec<Vec<f64>> =
            (0..model.materials()).map(|m| model.coefficients(m).to_vec()).collect();
        let (own, mut limits, mut shares) = (limits.to_vec(), limits.to_vec(), Vec::new());
        let spread = |row: &[f64]| spread(row, model.weights());
        let mut order: Vec<usize> = (0..rows.len()).filter(|&m| limits[m] > 0.0).collect();
        order.sort_by(|&a, &b| (own[a] * spread(&rows[a])).total_cmp(&(own[b] * spread(&rows[b]))));
        for (i, &n) in order.iter().enumerate() {
            let remainders = order[i + 1..].iter().map(|&m| {
                let factor = share(&rows[n], &rows[m]);
                let rest = rows[n].iter().zip(&rows[m]).map(|(mu, other)| (mu - factor * other).max(0.0));
                (m, factor, rest.collect::<Vec<f64>>())
            });
            let least = remainders.min_by(|a, b| spread(&a.2).total_cmp(&spread(&b.2)));
            if let Some((m, factor, rest)) =
                least.filter(|least| spread(&least.2) <= REMAINDER * spread(&rows[n]))
            {
                limits[m] += factor * limits[n];
                rows[n] = rest;
                shares.push((n, m, factor));
            }
        }
        Self { model: model.with_coefficients(rows.concat()), limits, own, shares }
    }

    /// The model of the new variables.
    pub(super) fn model(&self) -> &SpectralModel {
        &self.model
    }

    /// Largest areal densities of the new variables.
    pub(super) fn limits(&self) -> &[f64] {
        &self.limits
    }

    /// False only where no path of the box has new variables between `low` and `high`.
    pub(super) fn meets(&self, low: &[f64], high: &[f64]) -> bool {
        (0..self.own.len()).all(|material| {
            let part = |of: &[f64]| -> f64 {
                let parts = self.shares.iter().filter(|(_, m, _)| *m == material);
                parts.map(|(n, _, factor)| factor * of[*n]).sum()
            };
            let slack = SLACK * self.limits[material];
            !(high[material] - part(low) < -slack || low[material] - part(high) > self.own[material] + slack)
        })
    }
}

fn spread(row: &[f64], weights: &[f64]) -> f64 {
    let mean: f64 = row.iter().zip(weights).map(|(mu, weight)| mu * weight).sum();
    row.iter().zip(weights).map(|(mu, weight)| weight * (mu - mean).powi(2)).sum::<f64>().sqrt()
}

/// How much of `other` there is in `row` at every energy.
fn share(row: &[f64], other: &[f64]) -> f64 {
    let ratios = row.iter().zip(other).filter(|(_, other)| **other > 0.0).map(|(mu, other)| mu / other);
    let least = ratios.fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::{EnergyGrid, MassAttenuation, Spectrum};

    #[test]
    fn a_path_in_other_variables_is_the_same_path() {
        let grid = EnergyGrid::SPECIFICATION;
        let materials = ["air", "lung", "soft_tissue", "bone_cortical", "titanium", "tungsten"];
        let attenuation = MassAttenuation::named(&materials, grid).unwrap();
        let model =
            SpectralModel::new(&Spectrum::named(Spectrum::DEFAULT, grid).unwrap(), &attenuation).unwrap();
        let limits = [0.1, 8.0, 45.0, 12.0, 3.0, 0.2];
        let alloy = Alloy::new(&model, &limits);
        let merged: Vec<usize> = alloy.shares.iter().map(|(n, ..)| *n).collect();
        assert!(merged.contains(&0) && merged.contains(&1), "air and lung attenuate like tissue: {merged:?}");
        for part in [[1.0; 6], [0.0, 0.5, 1.0, 0.0, 0.3, 0.1], [0.9, 0.0, 0.0, 1.0, 0.0, 0.0]] {
            let path: Vec<f64> = limits.iter().zip(part).map(|(limit, part)| limit * part).collect();
            let mut other = path.clone();
            for (n, m, factor) in &alloy.shares {
                other[*m] += factor * other[*n];
            }
            let [p, same] = [model.line_integral(&path), alloy.model().line_integral(&other)];
            assert!((p - same).abs() <= 1e-13 * p, "{p} and {same}");
            assert!(alloy.meets(&other, &other));
            assert!(other.iter().zip(alloy.limits()).all(|(areal, limit)| *areal <= limit * (1.0 + 1e-15)));
        }
        // Lung alone, without the tissue that stands for most of it, is no path.
        let mut no_path = [0.0; 6];
        no_path[1] = 1.0;
        assert!(!alloy.meets(&no_path, &no_path));
    }
}
