//! Values in 16 bits.

/// Values as samples of 16 bits, from which they come back: value = `offset` + `scale` × sample.
#[derive(Debug, Clone, PartialEq)]
pub struct SixteenBits {
    /// The value of sample 0: 0, or the least value where that is below.
    pub offset: f64,
    /// From one sample to the next: the largest value has sample 65535.
    pub scale: f64,
    /// As many as values; a finite value comes back within half of `scale`. Of +∞ it is 65535, of −∞ and NaN 0.
    pub samples: Vec<u16>,
}

impl SixteenBits {
    /// The finest steps that reach from 0 to every finite value.
    pub fn of(values: &[f32]) -> Self {
        let finite = values.iter().copied().filter(|value| value.is_finite()).map(f64::from);
        let (least, most) = finite.fold((0.0, 0.0), |(a, b): (f64, f64), value| (a.min(value), b.max(value)));
        let scale = if most > least { (most - least) / f64::from(u16::MAX) } else { 1.0 };
        // A cast takes what is beyond the ends to them, and NaN to 0.
        let sample = |&value: &f32| ((f64::from(value) - least) / scale).round() as u16;
        Self { offset: least, scale, samples: values.iter().map(sample).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_within_half_a_step() {
        let rows: [&[f32]; 4] = [&[0.0, 1e-3, 7.25, 3.3], &[-0.5, 0.0, 12.0], &[3e38, 1.0], &[1e-40, 4e-41]];
        for values in rows {
            let SixteenBits { offset, scale, samples } = SixteenBits::of(values);
            for (value, sample) in values.iter().zip(&samples) {
                let back = offset + scale * f64::from(*sample);
                assert!((back - f64::from(*value)).abs() <= 0.500_000_1 * scale, "{value}: {back}");
            }
            assert_eq!(samples.iter().max(), Some(&u16::MAX), "every step is used");
        }
        // Zero is black, and stays zero, unless values are below it.
        assert_eq!(SixteenBits::of(&[2.0, 4.0]).offset, 0.0);
        assert_eq!(SixteenBits::of(&[-2.0, 4.0]).samples, [0, u16::MAX]);
    }

    #[test]
    fn what_is_not_finite_does_not_move_the_scale() {
        let plain = SixteenBits::of(&[1.0, 2.0]);
        let other = SixteenBits::of(&[1.0, 2.0, f32::INFINITY, f32::NEG_INFINITY, f32::NAN]);
        assert_eq!((other.offset, other.scale), (plain.offset, plain.scale));
        assert_eq!(other.samples[2..], [u16::MAX, 0, 0]);
        assert_eq!(
            SixteenBits::of(&[0.0, f32::NAN]),
            SixteenBits { offset: 0.0, scale: 1.0, samples: vec![0; 2] }
        );
        assert!(SixteenBits::of(&[]).samples.is_empty());
    }
}
