//! How far the colours of a picture of changes reach.

/// The part of a picture's pixels that are beyond its colours.
const BEYOND: f64 = 0.02;
/// A change that is none.
const ROUNDING: f32 = 1e-5;

/// Where the colours end: a round number that few changes are beyond; `None` where nothing changes beyond rounding.
pub(crate) fn colour_range(changes: &[f32]) -> Option<f64> {
    let mut sizes: Vec<f32> =
        changes.iter().map(|c| c.abs()).filter(|c| c.is_finite() && *c > ROUNDING).collect();
    let rank = ((1.0 - BEYOND) * sizes.len().checked_sub(1)? as f64) as usize;
    let most = f64::from(*sizes.select_nth_unstable_by(rank, f32::total_cmp).1);
    let decade = 10_f64.powi(most.log10().floor() as i32);
    let round = [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0].into_iter().map(|step| step * decade);
    let round = round.into_iter().find(|step| *step >= most);
    // Without the digits of a power's rounding.
    Some(round.map_or(most, |round| format!("{round:.1e}").parse().unwrap_or(round)))
}
