//! Pixels along one axis, and the coarser cells that scatter is computed in.

/// Weights of some neighbours: the first, and one weight for each from there on.
pub(super) type Stencil = (usize, Vec<f64>);

/// One axis of the detector cut into equal cells, whose borders need not be those of pixels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cells {
    count: usize,
    /// For each pixel, the cells it lies in with the part of it that does.
    parts: Vec<Stencil>,
    /// For each pixel, the cells that make its value.
    interpolation: Vec<Stencil>,
}

impl Cells {
    /// `pixels` in `count` cells, at most as many.
    pub(super) fn new(pixels: usize, count: usize) -> Self {
        let bounds = |p: usize| [p, p + 1].map(|edge| edge as f64 * count as f64 / pixels as f64);
        let parts = (0..pixels).map(|p| overlaps(bounds(p), count)).collect();
        let interpolation = (0..pixels).map(|p| mean_over(bounds(p), count)).collect();
        Self { count, parts, interpolation }
    }

    /// The number of cells.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// For each pixel, the cells it lies in and which part of it lies in each; the parts of a pixel sum to 1.
    pub(super) fn parts(&self) -> &[Stencil] {
        &self.parts
    }

    /// For each pixel, the cells whose values make the mean over the pixel of a continuous function that has the
    /// cells' means: pieces of parabolas (Colella & Woodward, J Comput Phys 54, 174, 1984, eq. 1.6 and 1.9, without their
    /// limiter). The sum over pixels is that of the cells times the pixels per cell.
    pub(super) fn interpolation(&self) -> &[Stencil] {
        &self.interpolation
    }
}

/// The cells that the interval meets and the part of the interval in each.
fn overlaps([low, high]: [f64; 2], count: usize) -> Stencil {
    let first = (low as usize).min(count - 1);
    let part = |cell: usize| {
        let upper = if cell + 1 == count { high } else { high.min((cell + 1) as f64) };
        ((upper - low.max(cell as f64)) / (high - low)).max(0.0)
    };
    (first, (first..count).take_while(|&cell| cell == first || (cell as f64) < high).map(part).collect())
}

/// Weights of the cells' means in the mean over an interval.
fn mean_over([low, high]: [f64; 2], count: usize) -> Stencil {
    let mut weights = vec![0.0; count];
    let (first, last) = ((low as usize).min(count - 1), (high.ceil() as usize).clamp(1, count) - 1);
    for cell in first..=last {
        let inside = |at: f64| (at - cell as f64).clamp(0.0, 1.0);
        let [from, to] = [low, high].map(|at| integrals(inside(at)));
        let [left, right, mean] = [0, 1, 2].map(|k| (to[k] - from[k]) / (high - low));
        weights[cell] += mean;
        add_edge(&mut weights, cell, left);
        add_edge(&mut weights, cell + 1, right);
    }
    let used = |weight: &f64| *weight != 0.0;
    let begin = weights.iter().position(used).unwrap_or(first);
    let end = weights.iter().rposition(used).map_or(begin + 1, |last| last + 1);
    (begin, weights[begin..end].to_vec())
}

/// From 0 to s of a cell of width 1: integral of the parabola in terms of its values at both ends and its mean.
fn integrals(s: f64) -> [f64; 3] {
    let (square, cube) = (s * s, s * s * s);
    [s - 2.0 * square + cube, cube - square, 3.0 * square - 2.0 * cube]
}

/// Adds `weight` times the value at the border before `cell`: of third order between four cells, of second next to the
/// ends, a straight line to the ends.
fn add_edge(weights: &mut [f64], cell: usize, weight: f64) {
    let count = weights.len();
    let terms: &[(usize, f64)] = match cell {
        _ if count == 1 => &[(0, 1.0)],
        0 => &[(0, 1.5), (1, -0.5)],
        _ if cell == count => &[(count - 1, 1.5), (count - 2, -0.5)],
        _ if cell == 1 || cell == count - 1 => &[(cell - 1, 0.5), (cell, 0.5)],
        _ => {
            let (near, far) = (7.0 / 12.0, -1.0 / 12.0);
            &[(cell - 2, far), (cell - 1, near), (cell, near), (cell + 1, far)]
        }
    };
    for (k, term) in terms {
        weights[*k] += weight * term;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apply(stencils: &[Stencil], cells: &[f64]) -> Vec<f64> {
        let value =
            |(first, weights): &Stencil| weights.iter().zip(&cells[*first..]).map(|(w, c)| w * c).sum();
        stencils.iter().map(value).collect()
    }

    #[test]
    fn nothing_is_lost_between_pixels_and_cells() {
        for (pixels, count) in [(1, 1), (7, 7), (720, 60), (725, 56), (100, 33), (5, 2), (64, 1), (64, 3)] {
            let axis = Cells::new(pixels, count);
            let cells: Vec<f64> = (0..count).map(|k| (k as f64 * 1.7).sin() + 2.0).collect();
            let (fine, coarse) = (apply(axis.interpolation(), &cells), cells.iter().sum::<f64>());
            let sum = fine.iter().sum::<f64>() * count as f64 / pixels as f64;
            assert!((sum / coarse - 1.0).abs() < 1e-12, "{pixels} in {count}: {sum} of {coarse}");
            for (first, parts) in axis.parts() {
                assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12 && first + parts.len() <= count);
            }
        }
    }

    #[test]
    fn parabolas_are_met_exactly_and_smooth_curves_closely() {
        let (pixels, count) = (726, 50);
        let axis = Cells::new(pixels, count);
        let mean = |antiderivative: &dyn Fn(f64) -> f64, k: usize, n: usize| {
            let [low, high] = [k, k + 1].map(|k| k as f64 / n as f64);
            (antiderivative(high) - antiderivative(low)) * n as f64
        };
        let inner = pixels / 10..pixels - pixels / 10;
        let parabola = |x: f64| x + x * x / 2.0 - x * x * x;
        let bell = |x: f64| (8.0 * x).sin() / 8.0 + x;
        for (curve, bound) in [(&parabola as &dyn Fn(f64) -> f64, 1e-12), (&bell, 1e-4)] {
            let cells: Vec<f64> = (0..count).map(|k| mean(curve, k, count)).collect();
            let fine = apply(axis.interpolation(), &cells);
            for p in inner.clone() {
                let expected = mean(curve, p, pixels);
                assert!((fine[p] - expected).abs() < bound, "{p}: {} for {expected}", fine[p]);
            }
        }
    }
}
