//! Small symmetric systems that are positive definite.

/// Smallest pivot of a matrix with 1 on its diagonal that is told from rounding.
const SMALLEST_PIVOT: f64 = 1e-14;

/// L, lower triangular, with `L Lᵀ` = the matrix (Golub & Van Loan, Matrix Computations, 4th ed. 2013, §4.2.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cholesky<const N: usize> {
    lower: [[f64; N]; N],
}

impl<const N: usize> Cholesky<N> {
    /// Of a symmetric matrix whose diagonal is about 1 or larger; `None` where it is not positive definite in float64.
    pub(super) fn new(matrix: &[[f64; N]; N]) -> Option<Self> {
        let mut lower = [[0.0; N]; N];
        for j in 0..N {
            let dot = |a: &[f64; N], b: &[f64; N]| (0..j).map(|k| a[k] * b[k]).sum::<f64>();
            let pivot = matrix[j][j] - dot(&lower[j], &lower[j]);
            if !(pivot > SMALLEST_PIVOT) {
                return None;
            }
            lower[j][j] = pivot.sqrt();
            for i in j + 1..N {
                lower[i][j] = (matrix[i][j] - dot(&lower[i], &lower[j])) / lower[j][j];
            }
        }
        Some(Self { lower })
    }

    /// The x with `L Lᵀ x = right`.
    pub(super) fn solve(&self, right: [f64; N]) -> [f64; N] {
        let mut x = right;
        for i in 0..N {
            let known: f64 = (0..i).map(|k| self.lower[i][k] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i][i];
        }
        for i in (0..N).rev() {
            let known: f64 = (i + 1..N).map(|k| self.lower[k][i] * x[k]).sum();
            x[i] = (x[i] - known) / self.lower[i][i];
        }
        x
    }

    /// The matrix's inverse, by columns, which are its rows.
    pub(super) fn inverse(&self) -> [[f64; N]; N] {
        let unit = |k: usize| std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 });
        std::array::from_fn(|k| self.solve(unit(k)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATRIX: [[f64; 3]; 3] = [[1.0, 0.5, -0.25], [0.5, 1.5, 0.75], [-0.25, 0.75, 2.0]];

    #[test]
    fn a_system_is_solved() {
        let x = [2.0, -3.0, 0.5];
        let right = MATRIX.map(|row| (0..3).map(|k| row[k] * x[k]).sum());
        let found = Cholesky::new(&MATRIX).expect("positive definite").solve(right);
        assert!((0..3).all(|k| (found[k] - x[k]).abs() < 1e-14), "{found:?}");
    }

    #[test]
    fn the_inverse_is_one() {
        let inverse = Cholesky::new(&MATRIX).expect("positive definite").inverse();
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
            let product: f64 = (0..3).map(|k| MATRIX[i][k] * inverse[k][j]).sum();
            let unit = if i == j { 1.0 } else { 0.0 };
            assert!((product - unit).abs() < 1e-14, "({i}, {j}): {product}");
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_refused() {
        assert_eq!(Cholesky::new(&[[1.0, 1.0], [1.0, 1.0]]), None);
        assert_eq!(Cholesky::new(&[[1.0, 2.0], [2.0, 1.0]]), None);
        assert_eq!(Cholesky::new(&[[f64::NAN, 0.0], [0.0, 1.0]]), None);
    }
}
