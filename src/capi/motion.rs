//! Parameters of rigid motions, which C passes as an array.

use crate::error::Error;

/// The same error about parameters that begin at `first` of the array: three angles, and a translation at the places and of
/// the name that are given.
pub(super) fn in_array(error: Error, first: usize, translation: &str) -> Error {
    let angles = ["alpha", "beta", "phi"].into_iter().enumerate();
    let error = angles
        .fold(error, |error, (n, name)| error.called(name, &format!("parameters[{}], {name},", first + n)));
    error.called("translation", &format!("parameters{translation},"))
}
