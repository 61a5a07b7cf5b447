//! What is learned about the errors of prediction in each context.

/// A context of regular mode (A.6), or of a run's interruption (A.7.2).
#[derive(Debug, Clone, Copy)]
pub(super) struct Context {
    pub(super) a: i32,
    b: i32,
    pub(super) c: i32,
    pub(super) n: i32,
    /// Negative errors, of interruptions only.
    nn: i32,
}

impl Context {
    pub(super) fn new(range: i32) -> Self {
        Self { a: ((range + 32) / 64).max(2), b: 0, c: 0, n: 1, nn: 0 }
    }

    /// The Golomb parameter where the sum of errors is `sum`.
    pub(super) fn k(&self, sum: i32) -> u32 {
        (0..24).find(|k| self.n << k >= sum).unwrap_or(24)
    }

    /// The error of a mapped one in regular mode (A.5.2, inverted).
    pub(super) fn error(&self, mapped: i32, k: u32, near: i32) -> i32 {
        let half = mapped >> 1;
        let inverted = near == 0 && k == 0 && 2 * self.b <= -self.n;
        if (mapped & 1 == 1) == inverted { half } else { -half - 1 }
    }

    /// The error of a mapped one where a run is interrupted (A.7.2.2, inverted).
    pub(super) fn interrupting_error(&self, mapped: i32, k: u32, kind: i32) -> i32 {
        let both = mapped + kind;
        let odd = both & 1 == 1;
        let size = (both + 1) / 2;
        if (k != 0 || 2 * self.nn >= self.n) == odd { -size } else { size }
    }

    /// Learns from an error in regular mode (A.6.1, A.6.2).
    pub(super) fn learn(&mut self, error: i32, near: i32, reset: i32) {
        self.b += error * (2 * near + 1);
        self.a += error.abs();
        if self.n == reset {
            self.a >>= 1;
            self.b >>= 1;
            self.n >>= 1;
        }
        self.n += 1;
        if self.b <= -self.n {
            self.b = (self.b + self.n).max(1 - self.n);
            self.c = (self.c - 1).max(-128);
        } else if self.b > 0 {
            self.b = (self.b - self.n).min(0);
            self.c = (self.c + 1).min(127);
        }
    }

    /// Learns from an error where a run was interrupted (A.7.2.2).
    pub(super) fn learn_interruption(&mut self, error: i32, mapped: i32, kind: i32, reset: i32) {
        self.nn += i32::from(error < 0);
        self.a += (mapped + 1 - kind) >> 1;
        if self.n == reset {
            self.a >>= 1;
            self.n >>= 1;
            self.nn >>= 1;
        }
        self.n += 1;
    }
}
