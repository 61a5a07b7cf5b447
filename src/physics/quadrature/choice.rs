//! Which bins, with which weights.

use crate::least_squares::Columns;
use crate::physics::SpectralModel;
use crate::physics::quadrature::training::paths;

/// Most bins to choose from; of more, every n-th is taken.
const MOST_CANDIDATES: usize = 256;
/// Most nodes.
const MOST_NODES: usize = 40;
/// How much heavier the sum of the weights counts than any error.
const SUM: f64 = 100.0;
/// Steps of the search for better places, in candidates.
const STEPS: [usize; 4] = [8, 4, 2, 1];

/// Most rounds in which the largest error is lowered.
const EVENINGS: usize = 12;
/// An error this far above the goal is not lowered to it.
const HOPELESS: f64 = 4.0;

/// Bins (ascending) and weights (above 0, of sum 1).
pub(super) type Nodes = (Vec<usize>, Vec<f64>);

/// The relative errors of the line integral on training paths, as a linear function of the nodes' weights:
/// row i is `e^{−τ_k(A_i)} / (S(A_i) · max(p_i, floor))` over the candidate bins k, its target the sum over all bins.
pub(super) struct Choice {
    candidates: Vec<usize>,
    rows: (Columns, Vec<f64>),
    /// The same on few rows.
    compressed: (Columns, Vec<f64>),
    tolerance: f64,
}

/// A set of candidates in order, their weights, and the length of the residual.
#[derive(Debug, Clone)]
struct Trial {
    support: Vec<usize>,
    weights: Vec<f64>,
    residual: f64,
}

impl Choice {
    pub(super) fn new(model: &SpectralModel, limits: &[f64], floor: f64, tolerance: f64) -> Self {
        let stride = model.bins().div_ceil(MOST_CANDIDATES);
        let candidates: Vec<usize> = (0..model.bins()).step_by(stride).collect();
        let paths = paths(model, limits, floor);
        let rows = paths.len() + 1;
        let mut values = vec![0.0; rows * candidates.len()];
        let mut target = vec![0.0; rows];
        for (i, path) in paths.iter().enumerate() {
            let p = model.line_integral(path);
            let terms = terms(model, path, p, floor);
            target[i] = terms.iter().zip(model.weights()).map(|(term, weight)| term * weight).sum();
            candidates.iter().enumerate().for_each(|(c, &k)| values[c * rows + i] = terms[k]);
        }
        values.chunks_mut(rows).for_each(|column| column[rows - 1] = SUM / floor);
        target[rows - 1] = SUM / floor * model.weights().iter().sum::<f64>();
        let columns = Columns::new(rows, values);
        let compressed = columns.compressed(&target, 1e-2 * tolerance);
        Self { candidates, rows: (columns, target), compressed, tolerance }
    }

    /// Nodes within the tolerance on the training paths, the fewest last.
    pub(super) fn nodes(&self) -> Vec<Nodes> {
        let mut support = (Vec::new(), Vec::new());
        let (columns, target) = &self.compressed;
        for _ in 0..3 * MOST_NODES {
            let full = support.0.len() >= MOST_NODES.min(target.len());
            if full
                || !columns.grow(&mut support, target)
                || self.error(&support.0, &support.1) <= 0.1 * self.tolerance
            {
                break;
            }
        }
        support.0.sort_unstable();
        let mut trial = self.trial(support.0);
        let mut found = Vec::new();
        loop {
            if self.error(&trial.support, &trial.weights) <= self.tolerance {
                found.push(self.named(&trial));
            }
            let Some(smaller) = self.without_one(&trial) else { return found };
            trial = smaller;
        }
    }

    /// A node less, the others moved. `None` where that leaves the tolerance.
    fn without_one(&self, trial: &Trial) -> Option<Trial> {
        let without = |i: usize| {
            let mut support = trial.support.clone();
            support.remove(i);
            self.trial(support)
        };
        let mut trials: Vec<Trial> =
            (0..trial.support.len()).map(without).filter(|t| !t.support.is_empty()).collect();
        trials.sort_by(|a, b| a.residual.total_cmp(&b.residual));
        let goal = 0.8 * self.tolerance;
        trials
            .into_iter()
            .take(3)
            .map(|trial| self.evened(self.moved(trial), goal))
            .find(|(_, error)| *error <= goal)
            .map(|(trial, _)| trial)
    }

    /// The same places with weights whose largest error, not the sum of squares, is as small as `goal`, if that can be;
    /// and the error. Rows count the more, the larger their error was (Lawson's algorithm; Rice & Usow,
    /// Math. Comp. 22, 118, 1968).
    fn evened(&self, mut trial: Trial, goal: f64) -> (Trial, f64) {
        let mut error = self.error(&trial.support, &trial.weights);
        let (columns, target) = &self.rows;
        let (mut weights, mut masses) = (trial.weights.clone(), vec![1.0; target.len()]);
        for _ in 0..EVENINGS {
            if error <= goal || error > HOPELESS * goal {
                break;
            }
            let errors = columns.residual(&trial.support, &weights, target);
            let rows = target.len() - 1;
            masses[..rows].iter_mut().zip(&errors).for_each(|(mass, error)| *mass *= error.abs());
            let mean = masses[..rows].iter().sum::<f64>() / rows as f64;
            masses[..rows].iter_mut().for_each(|mass| *mass /= mean);
            let roots: Vec<f64> = masses.iter().map(|mass| mass.sqrt()).collect();
            let weighted = columns.weighted(&trial.support, &roots);
            let target: Vec<f64> = target.iter().zip(&roots).map(|(value, root)| value * root).collect();
            weights = weighted.solve(&(0..trial.support.len()).collect::<Vec<_>>(), &target);
            if !weights.iter().all(|weight| *weight > 0.0) {
                break;
            }
            let new = self.error(&trial.support, &weights);
            if new < error {
                (error, trial.weights) = (new, weights.clone());
            }
        }
        (trial, error)
    }

    /// The places that a search by smaller and smaller steps finds.
    fn moved(&self, mut best: Trial) -> Trial {
        for step in STEPS {
            for _ in 0..4 {
                let before = best.residual;
                for i in 0..best.support.len() {
                    for forward in [true, false] {
                        best = self.stepped(best, i, step, forward);
                    }
                }
                if !(best.residual < 0.99 * before) {
                    break;
                }
            }
        }
        best
    }

    /// With node i moved, if that is free and better.
    fn stepped(&self, best: Trial, i: usize, step: usize, forward: bool) -> Trial {
        let Some(&place) = best.support.get(i) else { return best };
        let moved = if forward { place + step } else { place.wrapping_sub(step) };
        if moved >= self.candidates.len() || best.support.contains(&moved) {
            return best;
        }
        let mut support = best.support.clone();
        support[i] = moved;
        support.sort_unstable();
        let trial = self.trial(support);
        if trial.residual < best.residual { trial } else { best }
    }

    /// The best weights on a support; candidates whose weight would not be positive leave it.
    fn trial(&self, mut support: Vec<usize>) -> Trial {
        let (columns, target) = &self.compressed;
        loop {
            let weights = columns.solve(&support, target);
            if weights.iter().all(|weight| *weight > 0.0) {
                let residual = columns.residual(&support, &weights, target);
                let residual = residual.iter().map(|value| value * value).sum::<f64>().sqrt();
                return Trial { support, weights, residual };
            }
            let positive = support.iter().zip(&weights).filter(|(_, weight)| **weight > 0.0);
            support = positive.map(|(&place, _)| place).collect();
        }
    }

    /// The largest relative error on the training paths.
    fn error(&self, support: &[usize], weights: &[f64]) -> f64 {
        let (columns, target) = &self.rows;
        let sum: f64 = weights.iter().sum();
        let normalised: Vec<f64> = weights.iter().map(|weight| weight / sum).collect();
        let residual = columns.residual(support, &normalised, target);
        residual[..residual.len() - 1]
            .iter()
            .fold(0.0, |worst, error| if error.abs() <= worst { worst } else { error.abs() })
    }

    fn named(&self, trial: &Trial) -> Nodes {
        let sum: f64 = trial.weights.iter().sum();
        let bins = trial.support.iter().map(|&place| self.candidates[place]).collect();
        (bins, trial.weights.iter().map(|weight| weight / sum).collect())
    }
}

/// `e^{−τ_k} / (S · max(p, floor))` of each bin.
fn terms(model: &SpectralModel, path: &[f64], p: f64, floor: f64) -> Vec<f64> {
    let mut values = vec![p; model.bins()];
    for (m, areal) in path.iter().enumerate() {
        values.iter_mut().zip(model.coefficients(m)).for_each(|(exponent, mu)| *exponent -= mu * areal);
    }
    values.iter().map(|exponent| exponent.exp() / p.max(floor)).collect()
}
