//! Sums over the rays of a least-squares problem in few unknowns: what a step of Gauss and Newton needs.

/// Of residuals `r_i` with derivatives `J_ik = ∂r_i/∂θ_k`, N unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalEquations<const N: usize> {
    /// ½ Σ r².
    pub loss: f64,
    /// `Jᵀr`, which is ∂loss/∂θ.
    pub gradient: [f64; N],
    /// `JᵀJ`, symmetric: the loss's second derivatives but for those of the residuals, which is Gauss and Newton's
    /// approximation of them (Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, §10.3).
    pub hessian: [[f64; N]; N],
    /// Number of residuals.
    pub rays: usize,
}

impl<const N: usize> Default for NormalEquations<N> {
    fn default() -> Self {
        Self { loss: 0.0, gradient: [0.0; N], hessian: [[0.0; N]; N], rays: 0 }
    }
}

impl<const N: usize> NormalEquations<N> {
    /// One residual more, with its derivatives.
    pub fn add(&mut self, residual: f64, row: &[f64; N]) {
        self.loss += 0.5 * residual * residual;
        self.rays += 1;
        for k in 0..N {
            self.gradient[k] += row[k] * residual;
            for l in 0..N {
                self.hessian[k][l] += row[k] * row[l];
            }
        }
    }

    /// The residuals of `other` too.
    pub fn merge(&mut self, other: &Self) {
        self.loss += other.loss;
        self.rays += other.rays;
        for k in 0..N {
            self.gradient[k] += other.gradient[k];
            for l in 0..N {
                self.hessian[k][l] += other.hessian[k][l];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_matrix() {
        let rows = [[1.0, 2.0], [-3.0, 0.5], [0.0, 4.0]];
        let residuals = [2.0, -1.0, 0.5];
        let sum = |range: std::ops::Range<usize>| {
            let mut sum = NormalEquations::default();
            range.for_each(|i| sum.add(residuals[i], &rows[i]));
            sum
        };
        let mut all = sum(0..1);
        all.merge(&sum(1..3));
        assert_eq!(all.loss, 0.5 * (4.0 + 1.0 + 0.25));
        assert_eq!(all.gradient, [5.0, 4.0 - 0.5 + 2.0]);
        assert_eq!(all.hessian, [[10.0, 0.5], [0.5, 20.25]]);
        assert_eq!(all.rays, 3);
    }
}
