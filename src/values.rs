//! Checks of arrays that a caller hands over.

use crate::error::{Error, Result};
use crate::real::Real;

/// Refuses another number of values than `count`, of which there is one per `what`.
pub(crate) fn check_count(name: &str, length: usize, count: usize, what: &str) -> Result<()> {
    if length == count {
        return Ok(());
    }
    let possessive = if name.ends_with('s') { "'" } else { "'s" };
    Err(Error::invalid(format!("{name}{possessive} length"), length, format!("{count}, one per {what}")))
}

/// Refuses values that are not finite.
pub(crate) fn check_finite<T: Real>(name: &str, values: &[T]) -> Result<()> {
    check_each(name, values, |_, value| value.is_finite(), "finite numbers")
}

/// Refuses values that are not finite at pixels that count; the others may be anything.
pub(crate) fn check_finite_where<T: Real>(
    name: &str,
    values: &[T],
    counts: impl Fn(usize) -> bool,
) -> Result<()> {
    let good = |pixel: usize, value: f64| value.is_finite() || !counts(pixel);
    check_each(name, values, good, "finite numbers where pixels count")
}

/// Refuses values that are not `good` at their index; `valid` says what is.
pub(crate) fn check_each<T: Real>(
    name: &str,
    values: &[T],
    good: impl Fn(usize, f64) -> bool,
    valid: &str,
) -> Result<()> {
    let mut each = values.iter().enumerate().map(|(n, &value)| (n, value.into()));
    match each.find(|&(n, value)| !good(n, value)) {
        Some((n, value)) => Err(Error::invalid(format!("{name}[{n}]"), value, valid)),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(checked: Result<()>) -> String {
        checked.expect_err("refused").to_string()
    }

    #[test]
    fn lengths_are_said_in_english() {
        assert_eq!(check_count("mask", 3, 3, "pixel"), Ok(()));
        assert_eq!(
            message(check_count("mask", 2, 3, "pixel")),
            "mask's length is 2; valid: 3, one per pixel"
        );
        assert_eq!(
            message(check_count("images", 4, 3, "pixel")),
            "images' length is 4; valid: 3, one per pixel"
        );
    }

    #[test]
    fn the_first_value_that_counts_and_is_not_finite_is_named() {
        let values = [1.0_f32, f32::NAN, f32::INFINITY];
        assert_eq!(check_finite("start", &values[..1]), Ok(()));
        assert_eq!(message(check_finite("start", &values)), "start[1] is NaN; valid: finite numbers");
        assert_eq!(check_finite_where("measured", &values, |n| n == 0), Ok(()));
        let second = message(check_finite_where("measured", &values, |n| n != 1));
        assert_eq!(second, "measured[2] is inf; valid: finite numbers where pixels count");
    }
}
