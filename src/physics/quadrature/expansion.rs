//! The largest value that a sum of exponentials of either sign can have around a point.

use crate::least_squares::dot;

/// Widest exponent that is expanded. Beyond, the cell is to be cut.
const WIDEST: f64 = 8.0;

/// `Σ_k d_k e^{−δ·x_k}`, for all `|δ_m| ≤ 1`.
///
/// The columns `x_m` are nearly proportional (two or three effects make all attenuation), so they are first written
/// as `x_m = Σ_i α_mi z_i` with orthogonal `z_i`, scaled so that the new variables `y_i = Σ_m α_mi δ_m` are
/// again within ±1. Then each factor is a series in Chebyshev polynomials with modified Bessel functions,
/// `e^{−yz} = I_0(z) + 2 Σ_j (−1)^j I_j(z) T_j(y)`, and as `|T_j| ≤ 1` the sum is at most
/// `Σ_{j1, j2, …} |Σ_k d_k c_{j1}(z_1k) c_{j2}(z_2k) …|` with `c_0 = I_0`, `c_j = 2 I_j`. Terms so small that their
/// signs need not be known are added as `Σ_k |d_k| …`: the result stays an upper bound.
pub(super) struct Expansion {
    differences: Vec<f64>,
    directions: Vec<Direction>,
    /// Bound of what was left out so far.
    left_out: f64,
    /// Terms at most this large are left out.
    small: f64,
}

/// One `z_i`.
struct Direction {
    /// `c_j` by order j, one per bin.
    orders: Vec<Vec<f64>>,
    /// `Σ_{i ≥ j} |c_i|` times the largest value of the factors of all later directions, likewise.
    tails: Vec<Vec<f64>>,
}

impl Expansion {
    /// Of `differences` d and one column x of exponents per material. `masses` are any positive weights of the bins, for
    /// which the directions are orthogonal. `None` when an exponent is too wide.
    pub(super) fn new(differences: &[f64], columns: &[Vec<f64>], masses: &[f64], small: f64) -> Option<Self> {
        let exponent = |k: usize| columns.iter().map(|column| column[k].abs()).sum::<f64>();
        let bins = differences.len();
        let largest: Vec<f64> = (0..bins).map(|k| differences[k].abs() * exponent(k).exp()).collect();
        let kept: Vec<usize> = (0..bins).filter(|&k| !(largest[k] * bins as f64 <= small)).collect();
        let left_out = (0..bins).filter(|k| kept.binary_search(k).is_err()).map(|k| largest[k]).sum();
        let of_kept = |values: &[f64]| -> Vec<f64> { kept.iter().map(|&k| values[k]).collect() };
        let differences = of_kept(differences);
        let columns: Vec<_> = columns.iter().map(|column| of_kept(column)).collect();
        let mut expansion = Self { differences, directions: Vec::new(), left_out, small };
        let exponents = expansion.orthogonalise(columns, &of_kept(masses));
        let growth = |z: &Vec<f64>| z.iter().map(|z| z.abs().exp()).collect::<Vec<f64>>();
        let growths: Vec<Vec<f64>> = exponents.iter().map(growth).collect();
        // The largest size of each term before a direction's factor: that of d and of the directions before it.
        let mut sizes: Vec<f64> = expansion.differences.iter().map(|d| d.abs()).collect();
        for (i, z) in exponents.iter().enumerate() {
            let later = (0..kept.len()).map(|k| growths[i + 1..].iter().map(|growth| growth[k]).product());
            let direction = Direction::new(z, &growths[i], &sizes, &later.collect::<Vec<f64>>(), small)?;
            expansion.directions.push(direction);
            sizes.iter_mut().zip(&growths[i]).for_each(|(size, growth)| *size *= growth);
        }
        Some(expansion)
    }

    /// The `z_i` that matter; the bound of the others' effect goes to `left_out`.
    fn orthogonalise(&mut self, mut columns: Vec<Vec<f64>>, masses: &[f64]) -> Vec<Vec<f64>> {
        let product = |a: &[f64], b: &[f64]| -> f64 {
            masses.iter().zip(a).zip(b).map(|((mass, a), b)| mass * a * b).sum()
        };
        let mut exponents: Vec<Vec<f64>> = Vec::new();
        loop {
            let effect = self.effect(&exponents, &columns);
            if effect <= self.small || columns.is_empty() {
                self.left_out += effect;
                return exponents;
            }
            let longer = |&a: &usize, &b: &usize| {
                product(&columns[a], &columns[a]).total_cmp(&product(&columns[b], &columns[b]))
            };
            let pivot = (0..columns.len()).max_by(longer).unwrap_or(0);
            let direction = columns.swap_remove(pivot);
            let square = product(&direction, &direction);
            let mut range = 1.0;
            for column in columns.iter_mut().filter(|_| square > 0.0) {
                let part = product(column, &direction) / square;
                range += part.abs();
                column.iter_mut().zip(&direction).for_each(|(value, z)| *value -= part * z);
            }
            exponents.push(direction.into_iter().map(|z| z * range).collect());
        }
    }

    /// Bound of `|Σ_k d_k e^{−y·z_k} (e^{−δ·x_k} − 1)|` for what is left of the columns.
    fn effect(&self, exponents: &[Vec<f64>], columns: &[Vec<f64>]) -> f64 {
        let width = |of: &[Vec<f64>], k: usize| of.iter().map(|column| column[k].abs()).sum::<f64>();
        // |e^{−b} − 1| ≤ |b| e^{|b|}
        let of_bin = |(k, d): (usize, &f64)| {
            let left = width(columns, k);
            d.abs() * left * (width(exponents, k) + left).exp()
        };
        self.differences.iter().enumerate().map(of_bin).sum()
    }

    /// The bound; above `enough` it is any number above `enough`.
    pub(super) fn bound(&self, enough: f64) -> f64 {
        let mut bound = self.left_out;
        self.add(0, &self.differences, &mut bound, enough);
        bound
    }

    fn add(&self, index: usize, terms: &[f64], bound: &mut f64, enough: f64) {
        let Some(direction) = self.directions.get(index) else {
            *bound += terms.iter().sum::<f64>().abs();
            return;
        };
        let sizes: Vec<f64> = terms.iter().map(|term| term.abs()).collect();
        let last = index + 1 == self.directions.len();
        for (order, tail) in direction.orders.iter().zip(&direction.tails) {
            let rest = dot(&sizes, tail);
            if !(rest > self.small) {
                *bound += rest;
                return;
            }
            if last {
                *bound += dot(terms, order).abs();
            } else {
                let next: Vec<f64> = terms.iter().zip(order).map(|(term, factor)| term * factor).collect();
                self.add(index + 1, &next, bound, enough);
            }
            if *bound > enough {
                return;
            }
        }
        // Smaller than rounding, but not small.
        *bound = f64::INFINITY;
    }

    /// Multiplications that a bound takes, roughly.
    pub(super) fn work(&self) -> usize {
        let products =
            self.directions.iter().map(|direction| direction.orders.len()).take(2).product::<usize>();
        self.differences.len() * products.max(1)
    }
}

impl Direction {
    /// Bessel functions by their ratios, `I_{j+1}/I_j = z / (2(j+1) + z I_{j+2}/I_{j+1})`, from the highest order down,
    /// and `I_0 + 2 Σ_j I_j = e^z` (Abramowitz & Stegun 1964, 9.6.26 and 9.6.37). `growth`: `e^{|z|}`;
    /// `later`: the largest value of the factors of later directions. Ends with the
    /// order whose tail is `small` for any terms up to `sizes`.
    fn new(z: &[f64], growth: &[f64], sizes: &[f64], later: &[f64], small: f64) -> Option<Self> {
        let widest = z.iter().fold(0.0, |widest: f64, z| widest.max(z.abs()));
        if !(widest <= WIDEST) {
            return None;
        }
        let highest = highest_order(widest);
        let mut ratios = vec![vec![0.0; z.len()]; highest + 1];
        // Σ_{i ≥ j} I_i / I_j
        let mut sums = vec![vec![1.0; z.len()]; highest + 1];
        for j in (0..highest).rev() {
            let twice_order = 2.0 * (j + 1) as f64;
            let (ratio, above) = ratios.split_at_mut(j + 1);
            for ((ratio, above), z) in ratio[j].iter_mut().zip(&above[0]).zip(z) {
                *ratio = z / (twice_order + z * above);
            }
            let (sum, above) = sums.split_at_mut(j + 1);
            for ((sum, above), ratio) in sum[j].iter_mut().zip(&above[0]).zip(&ratios[j]) {
                *sum += ratio.abs() * above;
            }
        }
        let first = growth.iter().zip(&sums[0]).map(|(growth, sum)| growth / (2.0 * sum - 1.0));
        let mut order: Vec<f64> = first.collect();
        let whole = growth.iter().zip(later).map(|(growth, later)| growth * later).collect();
        let mut direction = Self { orders: Vec::new(), tails: vec![whole] };
        for (ratios, sums) in ratios.iter().zip(&sums[1..]) {
            let doubled = if direction.orders.is_empty() { 2.0 } else { 1.0 };
            let next: Vec<f64> =
                order.iter().zip(ratios).map(|(value, ratio)| doubled * value * ratio).collect();
            let tail =
                next.iter().zip(sums).zip(later).map(|((value, sum), later)| value.abs() * sum * later);
            direction.tails.push(tail.collect());
            direction.orders.push(std::mem::replace(&mut order, next));
            if direction.tails.last().is_some_and(|tail| dot(tail, sizes) <= small) {
                break;
            }
        }
        direction.orders.push(order);
        Some(direction)
    }
}

/// The first order whose Bessel function, about `(z/2)^j / j!`, is below rounding.
fn highest_order(z: f64) -> usize {
    let (mut order, mut value) = (1, 0.5 * z);
    while value > 1e-18 && order < 64 {
        order += 1;
        value *= 0.5 * z / order as f64;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(k: usize) -> f64 {
        (k as f64 * 0.618_033_988_749_895).fract()
    }

    /// `Σ_k d_k e^{−δ·x_k}`
    fn sum(differences: &[f64], columns: &[Vec<f64>], at: &[f64]) -> f64 {
        let exponent = |k: usize| columns.iter().zip(at).map(|(column, y)| column[k] * y).sum::<f64>();
        differences.iter().enumerate().map(|(k, d)| d * (-exponent(k)).exp()).sum()
    }

    #[test]
    fn no_value_in_the_cell_is_above_the_bound() {
        for (scale, materials) in [(0.01, 1), (0.5, 1), (0.5, 2), (1.0, 3), (2.5, 3), (0.3, 8)] {
            let differences: Vec<f64> = (0..30).map(|k| even(k * k) - 0.5).collect();
            // The third column is nearly the first, as lung is nearly tissue.
            let entry = |m: usize, k: usize| {
                scale * (2.0 * even(7 * (m % 2) + (m + 1) * k) - 1.0) + 0.01 * even(k * m)
            };
            let columns: Vec<Vec<f64>> = (0..materials)
                .map(|m| (0..30).map(|k| entry(if m == 2 { 0 } else { m }, k)).collect())
                .collect();
            let bound =
                Expansion::new(&differences, &columns, &[1.0; 30], 1e-6).unwrap().bound(f64::INFINITY);
            let at = |i: usize, m: usize| (3.0 * (2.0 * even(i * (m + 3) + m) - 1.0)).clamp(-1.0, 1.0);
            let values = (0..5000).map(|i| {
                let at: Vec<f64> = (0..materials).map(|m| at(i, m)).collect();
                sum(&differences, &columns, &at).abs()
            });
            let largest = values.fold(0.0, f64::max);
            assert!(largest <= bound, "{scale}, {materials}: {largest} above {bound}");
            if materials < 8 {
                assert!(bound <= 8.0 * largest, "{scale}, {materials}: {bound} far above {largest}");
            }
        }
    }

    #[test]
    fn one_term_is_largest_on_the_edge() {
        for z in [1e-12, 1e-3, -0.7, 2.0, -8.0] {
            let bound = Expansion::new(&[-3.0], &[vec![z]], &[1.0], 1e-12).unwrap().bound(f64::INFINITY);
            let largest = 3.0 * z.abs().exp();
            assert!((bound / largest - 1.0).abs() < 1e-12, "{z}: {bound}, not {largest}");
        }
        assert!(Expansion::new(&[1.0], &[vec![8.1]], &[1.0], 1e-9).is_none());
    }

    #[test]
    fn terms_that_cancel_are_seen_to_cancel() {
        // Second differences: what is left is (h x)²/2-like.
        let bound = Expansion::new(&[1.0, -2.0, 1.0], &[vec![-1e-3, 0.0, 1e-3]], &[1.0; 3], 1e-12).unwrap();
        assert!((bound.bound(1.0) / 1e-6 - 1.0).abs() < 1e-5);
    }
}
