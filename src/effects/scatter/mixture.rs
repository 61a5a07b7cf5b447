//! A radial distribution as a sum of Gaussians.

use super::rings::Rings;

/// Smallest standard deviation, mm.
const NARROWEST_MM: f64 = 1.0;
/// From one standard deviation to the next.
const RATIO: f64 = 1.6;
/// Steps of the fit.
const STEPS: usize = 300;

/// Gaussians in the plane with fixed standard deviations, each of integral 1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gaussians {
    widths: Vec<f64>,
    /// Part of Gaussian g in ring k at `k*widths + g`.
    parts: Vec<f64>,
}

impl Gaussians {
    /// Those that describe distributions over `rings`.
    pub(super) fn over(rings: &Rings) -> Self {
        let width = |g: i32| NARROWEST_MM * RATIO.powi(g);
        let count = 1 + ((rings.outermost() / NARROWEST_MM).ln() / RATIO.ln()) as i32;
        let widths: Vec<f64> = (0..count).map(width).collect();
        let part = |[inner, outer]: [f64; 2], width: f64| {
            let beyond = |radius: f64| (-0.5 * (radius / width).powi(2)).exp();
            beyond(inner) - beyond(outer)
        };
        let parts =
            rings.bounds().flat_map(|ring| widths.iter().map(move |width| part(ring, *width))).collect();
        Self { widths, parts }
    }

    /// Standard deviations, mm.
    pub(super) fn widths(&self) -> &[f64] {
        &self.widths
    }

    /// What a mixture with these `amplitudes` has in each ring.
    pub(super) fn rings_of(&self, amplitudes: &[f64]) -> Vec<f64> {
        let ring = |parts: &[f64]| parts.iter().zip(amplitudes).map(|(part, a)| part * a).sum();
        self.parts.chunks(self.widths.len()).map(ring).collect()
    }

    /// Amplitudes, none negative, of the mixture that is most like `contents` of the rings, by the iteration of Shepp &
    /// Vardi (IEEE Trans Med Imaging 1, 113, 1982): after every step the rings of the mixture sum to those of `contents`.
    pub(super) fn fit(&self, contents: &[f64]) -> Vec<f64> {
        let count = self.widths.len();
        let total: f64 = contents.iter().sum();
        let column = |g: usize| self.parts.iter().skip(g).step_by(count);
        let inside: Vec<f64> = (0..count).map(|g| column(g).sum()).collect();
        let mut amplitudes: Vec<f64> = vec![total / inside.iter().sum::<f64>(); count];
        for _ in 0..STEPS {
            let model = self.rings_of(&amplitudes);
            let ratio = |(have, model): (&f64, &f64)| if *model > 0.0 { have / model } else { 0.0 };
            let ratios: Vec<f64> = contents.iter().zip(&model).map(ratio).collect();
            for (g, amplitude) in amplitudes.iter_mut().enumerate() {
                let back: f64 = column(g).zip(&ratios).map(|(part, ratio)| part * ratio).sum();
                *amplitude *= back / inside[g];
            }
        }
        amplitudes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_amplitude_is_kept() {
        let rings = Rings::up_to(900.0);
        let gaussians = Gaussians::over(&rings);
        // Scatter of a point 500 mm away: cos³ of the angle, with a noise of 10 %.
        let contents: Vec<f64> = rings
            .bounds()
            .zip([0.9, 1.1].into_iter().cycle())
            .map(|([inner, outer], noise)| {
                let within = |r: f64| (r / 500.0).hypot(1.0).recip();
                noise * (within(inner) - within(outer))
            })
            .collect();
        let amplitudes = gaussians.fit(&contents);
        assert!(amplitudes.iter().all(|a| *a >= 0.0));
        let (model, total) = (gaussians.rings_of(&amplitudes), contents.iter().sum::<f64>());
        assert!((model.iter().sum::<f64>() / total - 1.0).abs() < 1e-12);
        let smooth = |k: usize| 2.0 * contents[k] / if k.is_multiple_of(2) { 1.8 } else { 2.2 };
        let wrong = (0..rings.count()).map(|k| (model[k] - smooth(k)).abs()).sum::<f64>() / total;
        assert!(wrong < 0.03, "{wrong}");
    }
}
