//! The part of a pixel that detects.

use crate::allocation::collected;
use crate::effects::Plane;
use crate::error::{Error, Result};

/// The smallest part.
const LEAST: f64 = 0.01;

/// The active part of a pixel's area: a centred square of side `√fill` of the pitch. The rest, electronics and gaps, detects
/// nothing.
///
/// Along an axis its MTF is |sinc(√fill · f · pitch)| (Boreman, Modulation Transfer Function in Optical and
/// Electro-Optical Systems, SPIE 2001, ch. 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FillFactor(f64);

impl FillFactor {
    /// All of the pixel.
    pub const FULL: Self = Self(1.0);

    /// A part of the area from 0.01 to 1.
    ///
    /// # Errors
    /// `InvalidArgument` outside of that.
    pub fn new(fill: f64) -> Result<Self> {
        let new = Self(fill);
        new.validate().map(|()| new)
    }

    /// Checks the range.
    pub fn validate(self) -> Result<()> {
        if !(LEAST..=1.0).contains(&self.0) {
            return Err(Error::invalid("scene.effects.fill_factor", self.0, "0.01 … 1"));
        }
        Ok(())
    }

    /// The active part of the area.
    pub fn part(self) -> f64 {
        self.0
    }

    /// What pixels collect from `n` × `n` rays each, of which every one stands for the cell of 1/n × 1/n pixels around
    /// it: the mean over the active square times its area in pixels. Where all rays of a pixel have the value c, it is the
    /// product of the fill factor and c to the last bit.
    ///
    /// # Errors
    /// `InvalidArgument` when the rays are not `n` × `n` per pixel. `OutOfMemory`.
    pub(crate) fn collected(self, rays: &Plane, n: usize) -> Result<Plane> {
        let [width, height] = rays.size();
        if n == 0 || width % n != 0 || height % n != 0 {
            let valid = format!("multiples of {n}, the rays per pixel along each axis");
            return Err(Error::invalid("rays", format!("{width} × {height}"), valid));
        }
        let shares = collected((0..n).map(|k| self.share(k, n)), "rays of a pixel")?;
        Plane::of_rows([width / n, height / n], |j, pixels| {
            for (i, pixel) in pixels.iter_mut().enumerate() {
                let row = |l: usize| &rays.row(j * n + l)[i * n..][..n];
                // Differences from one of the rays leave what all of them have as it is to the last bit.
                let first = row(n / 2)[n / 2];
                let sum = |l: usize| -> f64 {
                    row(l).iter().zip(&shares).map(|(value, share)| share * (value - first)).sum()
                };
                let mean = first + shares.iter().enumerate().map(|(l, share)| share * sum(l)).sum::<f64>();
                *pixel = self.0 * mean;
            }
            Ok(())
        })
    }

    /// The part of the active square's side that lies in cell `k` of `n`.
    fn share(self, k: usize, n: usize) -> f64 {
        let side = self.0.sqrt();
        let (from, to) = (0.5 * (1.0 - side), 0.5 * (1.0 + side));
        let cell = [k as f64 / n as f64, (k + 1) as f64 / n as f64];
        (cell[1].min(to) - cell[0].max(from)).max(0.0) / side
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const FILLS: [f64; 5] = [0.01, 0.3, 0.49, 0.81, 1.0];

    fn collected_by(fill: f64, rays: &Plane, n: usize) -> Plane {
        FillFactor::new(fill).expect("valid").collected(rays, n).expect("valid")
    }

    #[test]
    fn of_the_same_everywhere_a_pixel_collects_its_part() {
        for (fill, n) in FILLS.into_iter().flat_map(|fill| [1, 2, 3, 7, 16].map(|n| (fill, n))) {
            let rays = Plane::filled([3 * n, 2 * n], 0.1 + 0.2).expect("memory");
            let expected = Plane::filled([3, 2], fill * (0.1 + 0.2)).expect("memory");
            assert_eq!(collected_by(fill, &rays, n), expected, "{fill}, {n}");
        }
    }

    #[test]
    fn the_parts_of_the_active_square_are_all_of_it() {
        for (fill, n) in FILLS.into_iter().flat_map(|fill| [1, 2, 3, 7, 16].map(|n| (fill, n))) {
            let sum: f64 = (0..n).map(|k| FillFactor(fill).share(k, n)).sum();
            assert!((sum - 1.0).abs() < 1e-14, "{fill}, {n}: {sum}");
        }
    }

    #[test]
    fn with_all_of_the_pixel_it_is_the_mean_and_energy_is_kept() {
        let rays = Plane::of_points([12, 9], |i, j| (i * i + 3 * j) as f64);
        let pixels = collected_by(1.0, &rays, 3);
        let (all, seen): (f64, f64) = (rays.values().iter().sum(), pixels.values().iter().sum());
        assert!((9.0 * seen / all - 1.0).abs() < 1e-14, "{seen} of {all}");
        let block = (3..6).flat_map(|j| (6..9).map(move |i| f64::from(i * i + 3 * j))).sum::<f64>();
        assert!((pixels.row(1)[2] - block / 9.0).abs() < 1e-13);
    }

    #[test]
    fn one_ray_stands_for_all_of_its_pixel() {
        let rays = Plane::of_points([4, 3], |i, j| (i + 4 * j) as f64);
        let half = Plane::of_points([4, 3], |i, j| 0.5 * (i + 4 * j) as f64);
        assert_eq!(collected_by(0.5, &rays, 1), half);
    }

    #[test]
    fn cells_count_with_the_area_that_is_active() {
        // A side of 0.6: from 0.2 to 0.8, so that the outer thirds have 2/15 and the middle one 1/3.
        let sides = [2.0 / 15.0, 1.0 / 3.0, 2.0 / 15.0];
        for (k, l) in (0..3).flat_map(|l| (0..3).map(move |k| (k, l))) {
            let rays = Plane::of_points([3, 3], |i, j| f64::from(u8::from((i, j) == (k, l))));
            let seen = collected_by(0.36, &rays, 3).values()[0];
            assert!((seen - sides[k] * sides[l]).abs() < 1e-15, "{k}, {l}: {seen}");
        }
        // A side of 0.3 lies in the middle third.
        let rays = Plane::of_points([3, 3], |i, j| if (i, j) == (1, 1) { 2.0 } else { 1e9 });
        assert_eq!(collected_by(0.09, &rays, 3).values(), [0.18]);
    }

    #[test]
    fn its_mtf_is_a_sinc() {
        let n = 16;
        for (fill, frequency) in [(1.0, 0.3), (1.0, 0.5), (0.64, 0.4), (0.3, 0.5)] {
            // Cosine and sine give the amplitude wherever the pixels lie.
            let wave = |shift: f64| {
                let x = |i: usize| (i as f64 + 0.5) / n as f64;
                let rays = Plane::of_points([5 * n, n], |i, _| (2.0 * PI * frequency * x(i) + shift).cos());
                collected_by(fill, &rays, n).row(0)[3] / fill
            };
            let amplitude = wave(0.0).hypot(wave(0.5 * PI));
            let argument = PI * frequency * fill.sqrt();
            let sinc = argument.sin() / argument;
            // A ray in place of its cell: (πf/n)²/6, at most 1.6e-3, and as much again where the active square cuts cells.
            assert!((amplitude / sinc - 1.0).abs() < 3.2e-3, "{fill}, {frequency}: {amplitude} for {sinc}");
        }
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        for fill in [f64::NAN, 0.0, 0.009, 1.001, -1.0] {
            let message = FillFactor::new(fill).expect_err("invalid").to_string();
            assert!(message.starts_with("scene.effects.fill_factor is "), "{message}");
        }
        let rays = Plane::filled([4, 6], 1.0).expect("memory");
        assert!([0, 3, 4].iter().all(|n| FillFactor::FULL.collected(&rays, *n).is_err()));
    }
}
