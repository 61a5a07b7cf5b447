//! The paths on which nodes are chosen.

use crate::physics::SpectralModel;

/// Paths spread over the box.
const SPREAD: usize = 192;
/// Paths about as thin as the floor, where the relative error is that of the first derivatives.
const THIN: usize = 64;

/// Areal densities in the box 0 … `limits`: denser towards 0, with many on its faces, edges and corners. Always the same.
pub(super) fn paths(model: &SpectralModel, limits: &[f64], floor: f64) -> Vec<Vec<f64>> {
    let spread = (1..=SPREAD).map(|i| path(i, limits));
    let thin = (SPREAD + 1..=SPREAD + THIN).map(|i| {
        let path = path(i, limits);
        let shrink = (floor / model.line_integral(&path)).min(1.0);
        path.iter().map(|areal| areal * shrink).collect()
    });
    let axes = (0..limits.len()).flat_map(|material| {
        [0.03, 0.1, 0.3, 0.6, 1.0].map(|part| {
            let mut path = vec![0.0; limits.len()];
            path[material] = part * limits[material];
            path
        })
    });
    spread.chain(thin).chain(axes).chain([limits.to_vec()]).collect()
}

/// Point i of the sequence that the powers of `1/g` make, `g^(n+1) = g + 1` in n dimensions, which fills boxes evenly
/// (M. Roberts, The unreasonable effectiveness of quasirandom sequences, 2018).
fn path(i: usize, limits: &[f64]) -> Vec<f64> {
    let dimensions = limits.len() as f64;
    let root = (0..32).fold(1.5, |g: f64, _| (1.0 + g).powf(1.0 / (dimensions + 1.0)));
    let at = |m: usize| (0.5 + i as f64 * root.powi(-(m as i32 + 1))).fract();
    limits.iter().enumerate().map(|(m, limit)| limit * part(at(m))).collect()
}

/// From an even distribution over 0 … 1 to one with much at both ends.
fn part(even: f64) -> f64 {
    ((even - 0.2) / 0.65).clamp(0.0, 1.0).powi(2)
}
