//! Interactions of photons of 15 … 150 keV with tissues: how likely each kind is, and where a scattered photon goes.
//!
//! Likelihoods are tabulated (Elam, Ravel & Sieber 2002, as XCOM within 0.05 %). Directions are those of free electrons
//! for incoherent scattering (Klein and Nishina) and of atoms with a form factor of one parameter for coherent scattering,
//! which is such that its integral is the tabulated one. The binding of electrons, which takes some of the incoherent
//! scattering at small angles, and the order of a liquid's molecules, which does so with the coherent scattering below
//! 0.1 Å⁻¹, are left out; both act within some degrees of the direction of flight.

mod coefficients;
mod coherent;
mod incoherent;

pub(crate) use coefficients::{Coefficients, Interactions};
pub(crate) use coherent::Coherent;
pub(crate) use incoherent::Incoherent;

/// Square of the classical electron radius, cm²: `r_e` = 2.817 940 3205e-15 m (CODATA 2022, NIST SP 961).
const SQUARE_ELECTRON_RADIUS: f64 = 2.817_940_320_5e-13 * 2.817_940_320_5e-13;
/// Electrons or atoms per mole: the Avogadro constant (SI Brochure, 9th ed. 2019, exact).
const AVOGADRO: f64 = 6.022_140_76e23;
/// Energy of an electron at rest, keV (CODATA 2022, NIST SP 961).
const ELECTRON_REST_KEV: f64 = 510.998_950_69;

#[cfg(test)]
mod tests {
    /// ∫ over all directions of a density per steradian that depends on the cosine of the polar angle: Simpson's rule in
    /// √(1 − cosine), which resolves the forward peak.
    pub(super) fn over_directions(density: impl Fn(f64) -> f64) -> f64 {
        let intervals = 4000;
        let step = 2.0_f64.sqrt() / f64::from(intervals);
        let term = |i: i32| {
            let root = f64::from(i) * step;
            let weight = if i == 0 || i == intervals { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
            weight * density(1.0 - root * root) * 2.0 * root
        };
        (0..=intervals).map(term).sum::<f64>() * step / 3.0 * std::f64::consts::TAU
    }

    /// Uniform numbers in [0, 1) for tests of samplers: splitmix64 (Steele, Lea & Flood, OOPSLA 2014).
    pub(super) fn uniform(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
        }
    }

    /// χ² per degree of freedom of sampled cosines against a density per steradian, in 40 bins of equal width in
    /// √(1 − cosine); bins that expect fewer than ten are left out.
    pub(super) fn chi_square(mut sample: impl FnMut() -> f64, density: impl Fn(f64) -> f64) -> f64 {
        let (bins, draws, width) = (40, 200_000, 2.0_f64.sqrt() / 40.0);
        let mut counts = vec![0.0; bins];
        for _ in 0..draws {
            counts[(((1.0 - sample()).sqrt() / width) as usize).min(bins - 1)] += 1.0;
        }
        let expected = |bin: usize| {
            let inside = |cosine: f64| {
                let root = (1.0 - cosine).sqrt() / width;
                if root >= bin as f64 && root < (bin + 1) as f64 { density(cosine) } else { 0.0 }
            };
            // 100 intervals per bin; the jumps of `inside` cost Simpson's rule up to a third of a step on either side.
            over_directions(inside) * f64::from(draws)
        };
        let terms: Vec<f64> = (0..bins)
            .map(|bin| (counts[bin], expected(bin)))
            .filter(|(_, expected)| *expected >= 10.0)
            .map(|(count, expected)| (count - expected).powi(2) / expected)
            .collect();
        assert!(terms.len() > 9, "{} bins", terms.len());
        terms.iter().sum::<f64>() / terms.len() as f64
    }
}
