//! Least squares with few unknowns, none of them negative.

/// A matrix by columns.
#[derive(Debug, Clone)]
pub(crate) struct Columns {
    rows: usize,
    values: Vec<f64>,
}

impl Columns {
    /// Columns of `rows` numbers each, one after another.
    pub(crate) fn new(rows: usize, values: Vec<f64>) -> Self {
        Self { rows, values }
    }

    pub(crate) fn count(&self) -> usize {
        self.values.len() / self.rows
    }

    pub(crate) fn column(&self, index: usize) -> &[f64] {
        &self.values[index * self.rows..(index + 1) * self.rows]
    }

    /// `target − Σ_i x_i · column[support_i]`.
    pub(crate) fn residual(&self, support: &[usize], x: &[f64], target: &[f64]) -> Vec<f64> {
        let mut residual = target.to_vec();
        for (&index, &factor) in support.iter().zip(x) {
            subtract(&mut residual, factor, self.column(index));
        }
        residual
    }

    /// Some of the columns, each row multiplied by a factor.
    pub(crate) fn weighted(&self, support: &[usize], factors: &[f64]) -> Self {
        let column = |&k: &usize| self.column(k).iter().zip(factors).map(|(value, factor)| value * factor);
        Self::new(self.rows, support.iter().flat_map(column).collect())
    }

    /// The same least-squares problems on fewer rows: the columns, and the target as the last of them, in the basis of
    /// those columns that orthogonalisation with pivoting takes first. What no longer fits is shorter than `shortest`
    /// in every column. Sums of exponentials need some 15 rows for nine digits.
    pub(crate) fn compressed(&self, target: &[f64], shortest: f64) -> (Self, Vec<f64>) {
        let (mut left, count) = (self.values.clone(), self.count());
        left.extend(target);
        let mut rows: Vec<Vec<f64>> = Vec::new();
        while rows.len() < self.rows {
            let lengths = left.chunks(self.rows).map(|column| dot(column, column));
            let (pivot, square) = largest(lengths.take(count));
            if !(square.sqrt() > shortest) {
                break;
            }
            let direction = scaled(&left[pivot * self.rows..][..self.rows], 1.0 / square.sqrt());
            let row = left.chunks_mut(self.rows).map(|column| {
                let part = dot(column, &direction);
                subtract(column, part, &direction);
                part
            });
            rows.push(row.collect());
        }
        let column = |k: usize| rows.iter().map(move |row| row[k]);
        (Self::new(rows.len(), (0..count).flat_map(column).collect()), column(count).collect())
    }

    /// The `x` that minimises `|residual|`, by modified Gram–Schmidt with the target as last column, which is as stable as
    /// Householder's method (Björck, BIT 7, 1, 1967). A column that depends on those before it gets 0.
    pub(crate) fn solve(&self, support: &[usize], target: &[f64]) -> Vec<f64> {
        let count = support.len();
        let mut columns: Vec<Vec<f64>> = support.iter().map(|&index| self.column(index).to_vec()).collect();
        columns.push(target.to_vec());
        // r[i][j]: the part of column j along direction i; its last entry is the target's.
        let mut r = vec![vec![0.0; count + 1]; count];
        for i in 0..count {
            let (before, after) = columns.split_at_mut(i + 1);
            let direction = &mut before[i];
            let (length, original) = (dot(direction, direction).sqrt(), self.column(support[i]));
            if !(length > 1e-14 * dot(original, original).sqrt()) {
                continue;
            }
            for value in &mut *direction {
                *value /= length;
            }
            r[i][i] = length;
            for (j, column) in after.iter_mut().enumerate() {
                let part = dot(direction, column);
                subtract(column, part, direction);
                r[i][i + 1 + j] = part;
            }
        }
        let mut x = vec![0.0; count];
        for i in (0..count).rev().filter(|&i| r[i][i] > 0.0) {
            x[i] = (r[i][count] - dot(&r[i][i + 1..count], &x[i + 1..])) / r[i][i];
        }
        x
    }

    /// One step of Lawson and Hanson's non-negative least squares (Solving Least Squares Problems, 1974, ch. 23): the
    /// column along which the residual falls fastest joins the support `(columns, x > 0)`, and those that would turn
    /// negative leave it. Whether there was such a column.
    pub(crate) fn grow(&self, support: &mut (Vec<usize>, Vec<f64>), target: &[f64]) -> bool {
        let residual = self.residual(&support.0, &support.1, target);
        let slopes = (0..self.count()).map(|k| {
            let column = self.column(k);
            let slope = dot(column, &residual) / dot(column, column).sqrt();
            if support.0.contains(&k) { 0.0 } else { slope }
        });
        let (next, slope) = largest(slopes);
        if !(slope > 1e-12 * dot(&residual, &residual).sqrt()) {
            return false;
        }
        support.0.push(next);
        support.1.push(0.0);
        loop {
            let solution = self.solve(&support.0, target);
            let to_zero = solution.iter().zip(&support.1).filter(|(new, _)| **new <= 0.0);
            let step = to_zero.map(|(new, old)| old / (old - new)).fold(1.0, f64::min);
            let moved = solution.iter().zip(&support.1).map(|(new, old)| old + step * (new - old));
            // What limits the step is 0 up to rounding.
            let kept: Vec<(usize, f64)> =
                support.0.iter().copied().zip(moved).filter(|(_, x)| *x > 1e-15).collect();
            let all = kept.len() == solution.len();
            *support = kept.into_iter().unzip();
            if all && step == 1.0 || support.0.is_empty() {
                return support.0.contains(&next);
            }
            if all {
                // A step that takes nothing to 0 is the rounding of one that does.
                return false;
            }
        }
    }
}

/// Index and value of the largest number; NaN counts as none.
fn largest(values: impl Iterator<Item = f64>) -> (usize, f64) {
    let over = |best: (usize, f64), next: (usize, f64)| if next.1 > best.1 { next } else { best };
    values.enumerate().fold((0, f64::NEG_INFINITY), over)
}

fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|value| value * factor).collect()
}

fn subtract(from: &mut [f64], factor: f64, values: &[f64]) {
    from.iter_mut().zip(values).for_each(|(value, other)| *value -= factor * other);
}

/// Four sums side by side, for the compiler to make vectors of.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.iter().zip(b) {
        (0..4).for_each(|i| sums[i] += a[i] * b[i]);
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Powers of 0 … 1 as columns.
    fn powers(rows: usize, count: usize) -> Columns {
        let value = |row: usize, power: usize| (row as f64 / (rows - 1) as f64).powi(power as i32);
        Columns::new(rows, (0..count).flat_map(|power| (0..rows).map(move |row| value(row, power))).collect())
    }

    fn of(columns: &Columns, support: &[usize], x: &[f64]) -> Vec<f64> {
        let zero = vec![0.0; columns.rows];
        columns.residual(support, x, &zero).iter().map(|value| -value).collect()
    }

    #[test]
    fn a_polynomial_is_found_again() {
        let columns = powers(40, 8);
        let (support, x) = ([1, 0, 4, 7], [3.0, 0.5, -2.0, 1.0]);
        let solution = columns.solve(&support, &of(&columns, &support, &x));
        assert!(solution.iter().zip(x).all(|(a, b)| (a - b).abs() < 1e-11), "{solution:?}");
    }

    #[test]
    fn residuals_are_at_right_angles_to_the_columns() {
        let columns = powers(40, 6);
        let target: Vec<f64> = (0..40).map(|row| (0.2 * f64::from(row)).sin()).collect();
        let (compressed, short) = columns.compressed(&target, 1e-12);
        assert_eq!(compressed.rows, 6);
        let support = [0, 2, 5];
        let x = columns.solve(&support, &target);
        let residual = columns.residual(&support, &x, &target);
        assert!(support.iter().all(|&k| dot(columns.column(k), &residual).abs() < 1e-13));
        let same = compressed.solve(&support, &short);
        assert!(x.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-10), "{x:?} and {same:?}");
    }

    #[test]
    fn a_dependent_column_gets_nothing() {
        let columns = Columns::new(2, vec![4.0, 0.0, 2.0, 0.0]);
        assert_eq!(columns.solve(&[0, 1], &[12.0, 1.0]), [3.0, 0.0]);
    }

    #[test]
    fn nothing_turns_negative() {
        let columns = powers(40, 6);
        // Best without a bound: 1 and −1.
        let target = of(&columns, &[0, 3], &[1.0, -1.0]);
        let mut support = (Vec::new(), Vec::new());
        let steps = (0..20).take_while(|_| columns.grow(&mut support, &target)).count();
        assert!(steps < 20 && support.1.iter().all(|x| *x > 0.0), "{support:?}");
        // The conditions of Karush, Kuhn and Tucker: no column would make the residual shorter.
        let residual = columns.residual(&support.0, &support.1, &target);
        assert!((0..6).all(|k| dot(columns.column(k), &residual) < 1e-12));
    }
}
