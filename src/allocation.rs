//! Memory whose size a caller decides: refused with an error, where `vec!` and `collect` would end the process.

use crate::error::{Error, Result};

/// An empty vector with room for `count` values; `what` is for the message.
pub(crate) fn reserved<T>(count: usize, what: &str) -> Result<Vec<T>> {
    let mut values = Vec::new();
    let bytes = count.saturating_mul(size_of::<T>());
    values.try_reserve_exact(count).map_err(|_| Error::OutOfMemory { what: what.to_owned(), bytes })?;
    Ok(values)
}

/// `count` times the same value.
pub(crate) fn filled<T: Clone>(count: usize, value: T, what: &str) -> Result<Vec<T>> {
    let mut values = reserved(count, what)?;
    values.resize(count, value);
    Ok(values)
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
    fn what_cannot_be_had_is_refused_with_its_size() {
        let refused = Error::OutOfMemory { what: "the images".into(), bytes: usize::MAX };
        assert_eq!(reserved::<u64>(usize::MAX, "the images"), Err(refused));
        assert_eq!(filled(3, 7_u8, "a few"), Ok(vec![7, 7, 7]));
        assert_eq!(collected([1, 2].into_iter(), "two"), Ok(vec![1, 2]));
    }
}
