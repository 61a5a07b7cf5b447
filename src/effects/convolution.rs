//! Blurring of an image, axis by axis.

use crate::allocation::reserved;
use crate::effects::{Plane, Taps};
use crate::error::Result;

/// `plane` blurred along its rows with `columns` (so that columns mix) and along its columns with `rows`. Outside of it, the
/// value at its edge holds: nothing is known to be there, and neither light nor dark is made up.
///
/// The same for any number of threads. Where all values under a kernel are the same, they stay as they are to the last
/// bit: what is added to a value is differences from it. A kernel that does nothing costs nothing.
///
/// # Errors
/// `OutOfMemory`.
pub(crate) fn convolved(plane: &Plane, columns: &Taps, rows: &Taps) -> Result<Plane> {
    match (columns.is_identity(), rows.is_identity()) {
        (true, true) => plane.copied(),
        (false, true) => along_rows(plane, columns),
        (true, false) => along_columns(plane, rows),
        (false, false) => along_columns(&along_rows(plane, columns)?, rows),
    }
}

fn along_rows(plane: &Plane, taps: &Taps) -> Result<Plane> {
    let width = plane.size()[0];
    let side = within(taps, width)?;
    let reach = side.len();
    Plane::of_rows(plane.size(), |j, row| {
        let values = plane.row(j);
        let mut wide = reserved(width + 2 * reach, "a row of an image")?;
        wide.extend(std::iter::repeat_n(values[0], reach));
        wide.extend(values);
        wide.extend(std::iter::repeat_n(values[width - 1], reach));
        row.copy_from_slice(values);
        for (weight, n) in side.iter().zip(1..) {
            add(row, *weight, values, [&wide[reach - n..], &wide[reach + n..]]);
        }
        Ok(())
    })
}

fn along_columns(plane: &Plane, taps: &Taps) -> Result<Plane> {
    let height = plane.size()[1];
    let side = within(taps, height)?;
    Plane::of_rows(plane.size(), |j, row| {
        let values = plane.row(j);
        row.copy_from_slice(values);
        for (weight, n) in side.iter().zip(1..) {
            let pair = [plane.row(j.saturating_sub(n)), plane.row((j + n).min(height - 1))];
            add(row, *weight, values, pair);
        }
        Ok(())
    })
}

/// The weights to either side, on an axis of `length` samples: what is as far away as its ends, or farther, has their values
/// whatever its distance.
fn within(taps: &Taps, length: usize) -> Result<Vec<f64>> {
    let count = taps.side().len().min(length.saturating_sub(1));
    let (near, far) = taps.side().split_at(count);
    let mut side = reserved(count, "a kernel")?;
    side.extend(near);
    if let Some(last) = side.last_mut() {
        *last += far.iter().rev().sum::<f64>();
    }
    Ok(side)
}

/// Adds `weight` times the differences of a pair's values from `values`.
fn add(sum: &mut [f64], weight: f64, values: &[f64], pair: [&[f64]; 2]) {
    for (((sum, value), a), b) in sum.iter_mut().zip(values).zip(pair[0]).zip(pair[1]) {
        *sum += weight * ((a + b) - 2.0 * value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(size: [usize; 2]) -> Plane {
        Plane::of_points(size, |i, j| {
            (i as f64 * 12.9898 + j as f64 * 78.233).sin() * 43_758.545_3 % 1.0 + 1.5
        })
    }

    fn gaussian(sigma: f64) -> Taps {
        Taps::gaussian(sigma).expect("memory")
    }

    fn boxcar(width: f64) -> Taps {
        Taps::boxcar(width).expect("memory")
    }

    fn blurred(plane: &Plane, columns: &Taps, rows: &Taps) -> Plane {
        convolved(plane, columns, rows).expect("memory")
    }

    /// The sum as it is written in textbooks, over both axes at once.
    fn naive(plane: &Plane, columns: &Taps, rows: &Taps) -> Plane {
        let [width, height] = plane.size();
        let full = |taps: &Taps| -> Vec<f64> {
            let centre = 1.0 - 2.0 * taps.side().iter().sum::<f64>();
            taps.side().iter().rev().chain([&centre]).chain(taps.side()).copied().collect()
        };
        let (x, y) = (full(columns), full(rows));
        let near = |k: usize, n: usize, taps: &[f64], length: usize| {
            (k + n).saturating_sub(taps.len() / 2).min(length - 1)
        };
        Plane::of_points(plane.size(), |i, j| {
            let row = |j: usize| -> f64 {
                let value = |n: usize| plane.row(j)[near(i, n, &x, width)];
                x.iter().enumerate().map(|(n, weight)| weight * value(n)).sum()
            };
            y.iter().enumerate().map(|(m, weight)| weight * row(near(j, m, &y, height))).sum()
        })
    }

    fn difference(a: &Plane, b: &Plane) -> f64 {
        a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn it_is_the_sum_of_the_textbooks() {
        let kernels = [gaussian(0.0), gaussian(0.5), gaussian(2.3), boxcar(4.4), gaussian(30.0)];
        for size in [[1, 1], [1, 9], [17, 1], [13, 11], [40, 3]] {
            let plane = random(size);
            for (columns, rows) in kernels.iter().flat_map(|a| kernels.iter().map(move |b| (a, b))) {
                let error = difference(&blurred(&plane, columns, rows), &naive(&plane, columns, rows));
                assert!(error < 4e-15, "{size:?}: {error:e}");
            }
        }
    }

    #[test]
    fn what_is_the_same_everywhere_stays_to_the_last_bit() {
        let plane = Plane::filled([31, 7], 0.1 + 0.2).expect("memory");
        assert_eq!(blurred(&plane, &gaussian(3.7), &boxcar(5.2)), plane);
    }

    #[test]
    fn a_blurred_edge_is_an_error_function() {
        // Already softened, for samples to show all of it.
        let edge = |sigma: f64| {
            Plane::of_points([61, 4], |i, _| 0.5 * erfc((30.3 - i as f64) / (sigma * 2.0_f64.sqrt())))
        };
        let soft = edge(1.5);
        let error = difference(&blurred(&soft, &gaussian(2.0), &gaussian(9.0)), &edge(2.5));
        assert!(error < 2e-7, "{error:e}");
    }

    /// Abramowitz & Stegun 7.1.5 for the middle; far from it there is nothing left.
    fn erfc(x: f64) -> f64 {
        if x.abs() > 4.0 {
            return if x > 0.0 { 0.0 } else { 2.0 };
        }
        let (mut term, mut sum) = (x, x);
        for n in 1..150 {
            term *= -x * x / f64::from(n);
            sum += term / f64::from(2 * n + 1);
        }
        1.0 - sum * 2.0 / std::f64::consts::PI.sqrt()
    }

    #[test]
    fn energy_away_from_the_edges_is_kept_and_spread_evenly() {
        let (columns, rows) = (gaussian(1.7), boxcar(3.5));
        let mut point = Plane::filled([41, 31], 0.0).expect("memory");
        point.values_mut()[15 * 41 + 20] = 7.0;
        let spread = blurred(&point, &columns, &rows);
        assert!((spread.values().iter().sum::<f64>() - 7.0).abs() < 1e-14);
        let turned: Vec<f64> = spread.values().iter().rev().copied().collect();
        assert_eq!(spread.values(), turned);
        assert!(spread.values().iter().all(|value| *value >= 0.0));
    }

    #[test]
    fn axes_may_be_taken_in_any_order() {
        let (plane, columns, rows, none) = (random([53, 37]), gaussian(2.2), gaussian(0.7), gaussian(0.0));
        let columns_first = blurred(&blurred(&plane, &columns, &none), &none, &rows);
        let rows_first = blurred(&blurred(&plane, &none, &rows), &columns, &none);
        assert!(difference(&columns_first, &rows_first) < 1e-14);
        assert_eq!(blurred(&plane, &columns, &rows), columns_first);
    }
}
