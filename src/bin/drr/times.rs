//! The middle and the ends of repeated measurements.

/// The middle one, or the mean of the two in the middle.
pub(crate) fn median(times: &[f64]) -> f64 {
    let sorted = sorted(times);
    let middle = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[middle] } else { 0.5 * (sorted[middle - 1] + sorted[middle]) }
}

/// The least and the most.
pub(crate) fn spread(times: &[f64]) -> [f64; 2] {
    let sorted = sorted(times);
    [sorted[0], sorted[sorted.len() - 1]]
}

fn sorted(times: &[f64]) -> Vec<f64> {
    let mut sorted = times.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}
