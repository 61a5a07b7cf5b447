//! How a ray's samples are added.

use crate::engine::cpu::lanes::Lanes;
use crate::physics::MAX_MATERIALS;

/// A ray's sum, from block to block. Additions return the new sum, so that it stays in registers.
pub(super) trait Sum<L: Lanes>: Copy {
    /// The sum of nothing.
    const ZERO: Self;

    /// One sample more.
    fn plus(self, sample: L) -> Self;

    /// Some samples more, which were taken side by side.
    #[inline(always)]
    fn plus_all(self, samples: impl Iterator<Item = L>) -> Self {
        samples.fold(self, Self::plus)
    }

    /// At the end of a block: makes `integral` that of the ray so far, in `unit`s, and returns what the next block adds to.
    fn carried(self, unit: f64, integral: &mut [f64; MAX_MATERIALS]) -> Self;
}

/// A float32 sum within the block; blocks are added in float64.
#[derive(Clone, Copy)]
pub(super) struct Blocked<L>(L);

impl<L: Lanes> Sum<L> for Blocked<L> {
    const ZERO: Self = Self(L::ZERO);

    #[inline(always)]
    fn plus(self, sample: L) -> Self {
        Self(self.0 + sample)
    }

    /// They are summed on their own first.
    #[inline(always)]
    fn plus_all(self, samples: impl Iterator<Item = L>) -> Self {
        Self(self.0 + samples.fold(L::ZERO, |sum, sample| sum + sample))
    }

    #[inline(always)]
    fn carried(self, unit: f64, integral: &mut [f64; MAX_MATERIALS]) -> Self {
        integral.iter_mut().zip(widened(self.0)).for_each(|(sum, x)| *sum += x * unit);
        Self::ZERO
    }
}

/// One float32 sum from end to end.
#[derive(Clone, Copy)]
pub(super) struct Naive<L>(L);

impl<L: Lanes> Sum<L> for Naive<L> {
    const ZERO: Self = Self(L::ZERO);

    #[inline(always)]
    fn plus(self, sample: L) -> Self {
        Self(self.0 + sample)
    }

    #[inline(always)]
    fn carried(self, unit: f64, integral: &mut [f64; MAX_MATERIALS]) -> Self {
        *integral = widened(self.0).map(|x| x * unit);
        self
    }
}

/// One float32 sum from end to end, and by how much rounding has made it too large (Kahan, CACM 8(1), 40, 1965).
#[derive(Clone, Copy)]
pub(super) struct Compensated<L> {
    sum: L,
    excess: L,
}

impl<L: Lanes> Sum<L> for Compensated<L> {
    const ZERO: Self = Self { sum: L::ZERO, excess: L::ZERO };

    /// Rust's floats are not reassociated: the excess is not simplified to 0.
    #[inline(always)]
    fn plus(self, sample: L) -> Self {
        let wanted = sample - self.excess;
        let sum = self.sum + wanted;
        Self { sum, excess: (sum - self.sum) - wanted }
    }

    #[inline(always)]
    fn carried(self, unit: f64, integral: &mut [f64; MAX_MATERIALS]) -> Self {
        *integral = widened(self.sum).map(|x| x * unit);
        self
    }
}

/// The lanes in float64; those that there are not are 0.
fn widened<L: Lanes>(lanes: L) -> [f64; MAX_MATERIALS] {
    let mut wide = [0.0; MAX_MATERIALS];
    lanes.add_to(&mut wide);
    wide
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of 64 samples, in eights.
    fn total<S: Sum<f32>>(samples: &[f32]) -> f64 {
        let mut integral = [0.0; MAX_MATERIALS];
        let block = |sum: S, block: &[f32]| {
            let sum = block.chunks(8).fold(sum, |sum, eight| sum.plus_all(eight.iter().copied()));
            sum.carried(0.5, &mut integral)
        };
        samples.chunks(64).fold(S::ZERO, block);
        2.0 * integral[0]
    }

    #[test]
    fn each_sum_rounds_as_its_name_says() {
        // 2²⁴ + 1 is no float32.
        let mut samples = vec![1.0; 1 << 12];
        samples[0] = 16_777_216.0;
        let exact = f64::from(16_777_216 + (1 << 12) - 1);
        assert_eq!(total::<Naive<f32>>(&samples), 16_777_216.0);
        assert!((total::<Compensated<f32>>(&samples) - exact).abs() <= 1.0);
        // The first block's 63 ones are summed by eights, of which the first meets the large one.
        assert_eq!(total::<Blocked<f32>>(&samples), exact - 7.0);
    }

    #[test]
    fn the_naive_sum_is_of_one_sample_after_the_other() {
        let samples: Vec<f32> = (0..1000_u16).map(|i| 1.0 / (1.0 + f32::from(i))).collect();
        assert_eq!(total::<Naive<f32>>(&samples), f64::from(samples.iter().sum::<f32>()));
    }
}
