//! Memory whose size a caller decides: refused with an error, where `vec!` and `collect` would end the process.

use std::collections::TryReserveError;

use crate::error::{Error, Result};

/// The error for `count` values of `T` that cannot be had; `what` they are is for the message.
pub(crate) fn refused<T>(count: usize, what: &str) -> impl FnOnce(TryReserveError) -> Error {
    let bytes = count.saturating_mul(size_of::<T>());
    move |_| Error::OutOfMemory { what: what.to_owned(), bytes }
}

/// An empty vector with room for `count` values; `what` is for the message.
pub(crate) fn reserved<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(refused::<T>(count, what))?;
    Ok(values)
}

/// `count` times the same value.
pub(crate) fn filled<T: Clone>(count: usize, value: T, what: &str) -> Result<Vec<T>> {
    let mut values = Vec::new();
    grow(&mut values, count, value, what)?;
    Ok(values)
}

/// Lengthens `values` with `value` until there are `count`.
pub(crate) fn grow<T: Clone>(values: &mut Vec<T>, count: usize, value: T, what: &str) -> Result<()> {
    let count = count.max(values.len());
    values.try_reserve_exact(count - values.len()).map_err(refused::<T>(count, what))?;
    values.resize(count, value);
    Ok(())
}

/// The values of an iterator that knows its length.
pub(crate) fn collected<T>(values: impl ExactSizeIterator<Item = T>, what: &str) -> Result<Vec<T>> {
    let mut vector = reserved(values.len(), what)?;
    vector.extend(values);
    Ok(vector)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_stays() {
        let mut values = vec![1, 2];
        for (count, grown) in [(4, [1, 2, 7, 7]), (3, [1, 2, 7, 7])] {
            assert_eq!(grow(&mut values, count, 7, "a few"), Ok(()));
            assert_eq!(values, grown);
        }
        assert!(grow(&mut values, usize::MAX, 7, "many").is_err());
        assert_eq!(values, [1, 2, 7, 7]);
    }

    #[test]
    fn what_cannot_be_had_is_refused_with_its_size() {
        let refused = Error::OutOfMemory { what: "the images".into(), bytes: usize::MAX };
        assert_eq!(reserved::<u64>(usize::MAX, "the images"), Err(refused));
        assert_eq!(filled(3, 7_u8, "a few"), Ok(vec![7, 7, 7]));
        assert_eq!(collected([1, 2].into_iter(), "two"), Ok(vec![1, 2]));
    }
}
