//! Root mean squares, in float64.

/// Root mean square of values.
pub(crate) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (count, squares) =
        values.into_iter().fold((0_usize, 0.0), |(n, sum), value| (n + 1, sum + value * value));
    (squares / count as f64).sqrt()
}

/// Root mean square difference, of values that are subtracted in float64.
pub(crate) fn rmse(own: &[f32], other: &[f32]) -> f64 {
    rms(own.iter().zip(other).map(|(own, other)| f64::from(*own) - f64::from(*other)))
}
