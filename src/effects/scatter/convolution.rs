//! Gaussians over cells.

use std::f64::consts::TAU;

/// Fewest points at which a Gaussian is summed per standard deviation: exact to float64's rounding.
const POINTS_PER_WIDTH: f64 = 8.0;
/// Fewest of them per cell.
const POINTS_PER_CELL: f64 = 4.0;
/// Standard deviations beyond which a Gaussian is nothing: 1e-15 of it is there.
const FARTHEST: f64 = 8.0;

/// Density, mean over each of `count` cells of `cell_mm`, of what the cells' `amplitudes` make when each is spread evenly over its
/// cell and blurred by a Gaussian of standard deviation `width` mm: one axis after the other.
pub(super) fn blurred(amplitudes: &[f64], count: [usize; 2], cell_mm: [f64; 2], width: f64) -> Vec<f64> {
    let [nx, ny] = count;
    let [along, down] = [0, 1].map(|k| profile(width / cell_mm[k], count[k], 1.0 / cell_mm[k]));
    let mut lines = vec![0.0; nx * ny];
    for (line, amplitudes) in lines.chunks_mut(nx).zip(amplitudes.chunks(nx)) {
        for (from, amplitude) in amplitudes.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            // The profile's middle, at nx − 1, belongs to the cell itself.
            add(line, *amplitude, &along[nx - 1 - from..]);
        }
    }
    let mut all = vec![0.0; nx * ny];
    for (to, sum) in all.chunks_mut(nx).enumerate() {
        for (from, line) in lines.chunks(nx).enumerate() {
            add(sum, down[ny - 1 + to - from], line);
        }
    }
    all
}

/// How much of what is spread evenly over a cell comes to the cells −(count−1) … count−1 further, when it is blurred by a
/// Gaussian of `width` cells, times `scale`: tents around points of the Gaussian, which is summed by the trapezoidal rule.
fn profile(width: f64, count: usize, scale: f64) -> Vec<f64> {
    let step = (width / POINTS_PER_WIDTH).min(1.0 / POINTS_PER_CELL);
    let reach = (count as f64).min(FARTHEST * width);
    let points = (reach / step).ceil() as i64;
    let mut profile = vec![0.0; 2 * count - 1];
    for i in -points..=points {
        let at = i as f64 * step;
        let weight = scale * step / (width * TAU.sqrt()) * (-0.5 * (at / width).powi(2)).exp();
        let (cell, part) = (at.floor(), at - at.floor());
        for (cell, part) in [(cell, 1.0 - part), (cell + 1.0, part)] {
            let index = cell + (count - 1) as f64;
            if index >= 0.0 && index < profile.len() as f64 {
                profile[index as usize] += part * weight;
            }
        }
    }
    profile
}

/// Adds `factor` times the values.
pub(super) fn add(sum: &mut [f64], factor: f64, values: &[f64]) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += factor * value);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_keeps_its_amplitude_and_its_width() {
        // Tents make the mean square of the distance that of the Gaussian and 1/6 of a square cell more; of a Gaussian much
        // narrower than a cell they make its mean distance.
        let expected = |width: f64| {
            if width < 0.2 { width * (2.0 / std::f64::consts::PI).sqrt() } else { width * width + 1.0 / 6.0 }
        };
        for width in [0.1, 1.5, 4.0, 9.0] {
            let count = 101;
            let profile = profile(width, count, 1.0);
            let at = |k: usize| k as f64 - (count - 1) as f64;
            let sum: f64 = profile.iter().sum();
            let square: f64 = profile.iter().enumerate().map(|(k, p)| p * at(k).powi(2)).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{width}: {sum}");
            assert!((square - expected(width)).abs() < 0.015, "{width}: {square} for {}", expected(width));
        }
    }

    #[test]
    fn cells_are_blurred_along_both_axes() {
        let (count, cell_mm) = ([40, 30], [5.0, 7.0]);
        let mut amplitudes = vec![0.0; 1200];
        amplitudes[15 * 40 + 20] = 3.0;
        let blurred = blurred(&amplitudes, count, cell_mm, 21.0);
        let sum = blurred.iter().sum::<f64>() * 35.0;
        assert!((sum / 3.0 - 1.0).abs() < 1e-3, "{sum}");
        // At its place, and 4 × 5 mm and 3 × 7 mm aside: the density of a Gaussian, the cells' own width is 1 %.
        for (x, y) in [(0, 0), (4, 0), (0, 3), (4, 3)] {
            let radius = (5.0 * f64::from(x)).powi(2) + (7.0 * f64::from(y)).powi(2);
            let expected = 3.0 / (TAU * 441.0) * (-0.5 * radius / 441.0).exp();
            let have = blurred[(15 + y as usize) * 40 + 20 + x as usize];
            assert!((have / expected - 1.0).abs() < 0.02, "{x}, {y}: {have} for {expected}");
        }
    }
}
