//! The energy bins of a sum, laid out for float32, eight at a time.

use crate::engine::cpu::level::{self, LANES, Level, load, store};
use crate::engine::cpu::path::ROUND;
use crate::physics::SpectralModel;

/// Energies summed side by side; the compiler makes vectors of them.
const WIDTH: usize = 8;

/// Terms that are summed in float32 before the sum goes to float64.
const BLOCK: usize = 16;

pub(crate) type Wide = [f32; WIDTH];

/// Taylor series of exp on |r| ≤ ln(2)/2, but its first term: what is left out is below 6e-9.
const SERIES: [f32; 7] = [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0];

/// Mass attenuation coefficients, and rows of weights to sum transmissions by.
#[derive(Debug, Clone)]
pub(crate) struct Bins {
    rows: Vec<Row>,
    /// cm²/g, by material.
    coefficients: Vec<Vec<Wide>>,
    vectors: usize,
}

/// The last bin is repeated with weight 0 to fill the last vector.
#[derive(Debug, Clone)]
struct Row {
    weights: Vec<Wide>,
    /// Their sum as rounded: an empty path has exactly none of them missing.
    sum: f64,
}

impl Bins {
    /// Those of a model, with its weights as the only row.
    pub(super) fn of(model: &SpectralModel) -> Self {
        Self::new(&[model.weights()], (0..model.materials()).map(|m| model.coefficients(m)))
    }

    /// One weight per bin in each row, which sum to 1, and one coefficient in each material's.
    pub(crate) fn new<'a>(rows: &[&[f64]], materials: impl Iterator<Item = &'a [f64]>) -> Self {
        let row = |weights: &&[f64]| {
            let weights = wide(weights, 0.0);
            Row { sum: weights.iter().flatten().copied().map(f64::from).sum(), weights }
        };
        let rows: Vec<_> = rows.iter().map(row).collect();
        let coefficients = materials.map(|values| wide(values, *values.last().unwrap_or(&0.0))).collect();
        Self { vectors: rows[0].weights.len(), rows, coefficients }
    }

    /// What passes areal densities (g/cm², by material), by the weights of each row: with `t` the least depth of any bin,
    /// which is the answer, `Σ_k w_k exp(t − τ_k)` goes to `passing`. Of an empty path everything does, exactly.
    pub(crate) fn pass(
        &self,
        areal_density: impl Iterator<Item = f64>,
        depth: &mut Vec<Wide>,
        passing: &mut [f64],
    ) -> f64 {
        depth.clear();
        depth.resize(self.vectors, [0.0; WIDTH]);
        let mut present = false;
        for (row, areal) in self.coefficients.iter().zip(areal_density) {
            let areal = areal as f32;
            if areal != 0.0 {
                present = true;
                for (depth, mu) in depth.iter_mut().zip(row) {
                    (0..WIDTH).for_each(|i| depth[i] += areal * mu[i]);
                }
            }
        }
        if !present {
            passing.fill(1.0);
            return 0.0;
        }
        let mut least = [f32::INFINITY; WIDTH];
        for depth in &*depth {
            (0..WIDTH).for_each(|i| least[i] = least[i].min(depth[i]));
        }
        let least = least.into_iter().fold(f32::INFINITY, f32::min);
        for depth in &mut *depth {
            *depth = exp_minus(&std::array::from_fn(|i| depth[i] - least));
        }
        for (passing, row) in passing.iter_mut().zip(&self.rows) {
            *passing = row.sum_of(depth) / row.sum;
        }
        f64::from(least)
    }
}

impl Bins {
    /// As [`Bins::pass`] by the first row, of 16 rays at once. Areal densities come with their materials.
    #[inline(always)]
    pub(super) fn pass_lanes<S: Level>(
        &self,
        simd: S,
        areal_densities: &[(usize, level::Wide)],
        depth: &mut Vec<level::Wide>,
    ) -> (level::Wide, [f64; LANES]) {
        let energies = self.vectors * WIDTH;
        depth.resize(energies, [0.0; LANES]);
        let mut least = [0.0; LANES];
        for n in (0..LANES).step_by(S::F32_LANES) {
            let mut lowest = simd.splat_f32s(f32::INFINITY);
            for (k, depth) in depth.iter_mut().enumerate() {
                let mut sum = simd.splat_f32s(0.0);
                for (material, areal) in areal_densities {
                    let mu = simd.splat_f32s(self.coefficients[*material][k / WIDTH][k % WIDTH]);
                    sum = simd.times_plus(load::<S>(&areal[n..]), mu, sum);
                }
                store::<S>(&mut depth[n..], sum);
                lowest = simd.min_f32s(lowest, sum);
            }
            store::<S>(&mut least[n..], lowest);
        }
        let weights = self.rows[0].weights.as_flattened();
        let mut passing = [0.0; LANES];
        for (depth, weights) in depth.chunks(BLOCK).zip(weights.chunks(BLOCK)) {
            let mut total = [0.0; LANES];
            for n in (0..LANES).step_by(S::F32_LANES) {
                let lowest = load::<S>(&least[n..]);
                let mut sum = simd.splat_f32s(0.0);
                for (depth, weight) in depth.iter().zip(weights) {
                    let passed = exp_minus_of(simd, simd.sub_f32s(load::<S>(&depth[n..]), lowest));
                    sum = simd.times_plus(simd.splat_f32s(*weight), passed, sum);
                }
                store::<S>(&mut total[n..], sum);
            }
            for n in 0..LANES {
                passing[n] += f64::from(total[n]);
            }
        }
        for passing in &mut passing {
            *passing /= self.rows[0].sum;
        }
        (least, passing)
    }
}

impl Row {
    fn sum_of(&self, transmitted: &[Wide]) -> f64 {
        let mut total = 0.0;
        for (weights, transmitted) in self.weights.chunks(BLOCK).zip(transmitted.chunks(BLOCK)) {
            let mut sum = [0.0; WIDTH];
            for (weight, transmitted) in weights.iter().zip(transmitted) {
                (0..WIDTH).for_each(|i| sum[i] += weight[i] * transmitted[i]);
            }
            total += sum.into_iter().map(f64::from).sum::<f64>();
        }
        total
    }
}

fn wide(values: &[f64], filler: f64) -> Vec<Wide> {
    let filled = |chunk: &[f64]| std::array::from_fn(|i| *chunk.get(i).unwrap_or(&filler) as f32);
    values.chunks(WIDTH).map(filled).collect()
}

/// exp(−x) for x ≥ 0, relative error below 2e-7 + x·1e-7; 0 below 2⁻¹²⁶. The second term is harmless here: such a
/// term of the sum is itself smaller by exp(−x), and sums without any larger one go to float64.
#[inline(always)]
fn exp_minus(x: &Wide) -> Wide {
    let (mut power, mut r, mut scale) = ([1.0 / 5040.0; WIDTH], [0.0; WIDTH], [0.0; WIDTH]);
    for i in 0..WIDTH {
        let y = x[i] * -std::f32::consts::LOG2_E;
        let kept = if y > -126.0 { y } else { -126.0 };
        let shifted = kept + ROUND;
        r[i] = (kept - (shifted - ROUND)) * std::f32::consts::LN_2;
        let exponent = f32::from_bits(shifted.to_bits().wrapping_add(127) << 23);
        scale[i] = if y < -126.0 { 0.0 } else { exponent };
    }
    for coefficient in SERIES {
        for i in 0..WIDTH {
            power[i] = power[i] * r[i] + coefficient;
        }
    }
    std::array::from_fn(|i| power[i] * scale[i])
}

/// As [`exp_minus`], in vectors of any width.
#[inline(always)]
fn exp_minus_of<S: Level>(simd: S, x: S::f32s) -> S::f32s {
    let y = simd.mul_f32s(x, simd.splat_f32s(-std::f32::consts::LOG2_E));
    let kept = simd.max_f32s(y, simd.splat_f32s(-126.0));
    let shifted = simd.add_f32s(kept, simd.splat_f32s(ROUND));
    let whole = simd.sub_f32s(shifted, simd.splat_f32s(ROUND));
    let r = simd.mul_f32s(simd.sub_f32s(kept, whole), simd.splat_f32s(std::f32::consts::LN_2));
    let mut power = simd.splat_f32s(1.0 / 5040.0);
    for coefficient in SERIES {
        power = simd.times_plus(power, r, simd.splat_f32s(coefficient));
    }
    let bits = simd.add_u32s(simd.transmute_u32s_f32s(shifted), simd.splat_u32s(127));
    let scale = simd.transmute_f32s_u32s(simd.wrapping_dyn_shl_u32s(bits, simd.splat_u32s(23)));
    let under = simd.less_than_f32s(y, simd.splat_f32s(-126.0));
    simd.mul_f32s(power, simd.select_f32s(under, simd.splat_f32s(0.0), scale))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_accurate_and_underflows_to_zero() {
        for k in 0..200_000 {
            let x = k as f32 * 4.3e-4;
            let exact = f64::from(-x).exp();
            let relative = (f64::from(exp_minus(&[x; WIDTH])[0]) / exact - 1.0).abs();
            assert!(relative < 2e-7 + 1e-7 * f64::from(x), "x = {x}: {relative}");
        }
        assert_eq!(
            exp_minus(&[0.0, 88.0, f32::INFINITY, 0.0, 1e30, 0.0, 0.0, 0.0]),
            [1., 0., 0., 1., 0., 1., 1., 1.]
        );
    }
}
