//! The one error type of the library.

/// What went wrong, in words a caller can act on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// An argument is outside its valid range. Nothing was written.
    #[error("{argument} is {value}; valid: {valid}")]
    InvalidArgument {
        /// The argument's name, as in the API (`scene.detector_width`).
        argument: String,
        /// The value that was given.
        value: String,
        /// The valid range, in words.
        valid: String,
    },
    /// The request is valid, but this build or this machine cannot serve it.
    #[error("{0}")]
    Unsupported(String),
    /// An allocation was refused.
    #[error("out of memory: {bytes} bytes for {what}")]
    OutOfMemory {
        /// What was to be allocated.
        what: String,
        /// Its size.
        bytes: usize,
    },
    /// A device or its driver failed during a call that was valid: it was lost, reset, or met an internal error.
    #[error("{0}")]
    Device(String),
    /// A progress report was answered with the wish to stop. Nothing was written.
    #[error("cancelled by the caller's progress function")]
    Cancelled,
    /// An earlier call panicked while it used this handle of the C ABI.
    #[error(
        "{argument} is poisoned: an earlier call with it met an internal error, and it is not used again"
    )]
    Poisoned {
        /// The argument's name, as in the API.
        argument: String,
    },
    /// A file could not be read or written, or is not what it claims to be.
    #[error("{path}: {reason}")]
    File {
        /// The file.
        path: String,
        /// The reason, including the underlying library's words.
        reason: String,
    },
}

/// Most characters of a number that is written without an exponent: every 64-bit integer has at most as many.
const MOST_CHARACTERS: usize = 20;

impl Error {
    /// An argument outside its range: its name, the value given, the valid range.
    pub fn invalid(
        argument: impl Into<String>,
        value: impl std::fmt::Display,
        valid: impl Into<String>,
    ) -> Self {
        let value = value.to_string();
        // The largest float has 309 digits; its exponent says more.
        let value = match value.parse::<f64>() {
            Ok(number) if value.len() > MOST_CHARACTERS => format!("{number:e}"),
            _ => value,
        };
        Self::InvalidArgument { argument: argument.into(), value, valid: valid.into() }
    }

    /// The same error about a part of `whole`: its argument is called `whole.argument`.
    #[must_use]
    pub fn of(self, whole: &str) -> Self {
        match self {
            Self::InvalidArgument { argument, value, valid } => {
                Self::InvalidArgument { argument: format!("{whole}.{argument}"), value, valid }
            }
            other => other,
        }
    }

    /// The same error to a caller who knows the argument `from`, or that which `from` begins, as `to`.
    #[must_use]
    pub(crate) fn called(self, from: &str, to: &str) -> Self {
        match self {
            Self::InvalidArgument { argument, value, valid } => {
                let argument = match argument.strip_prefix(from) {
                    Some(rest) => format!("{to}{rest}"),
                    None => argument,
                };
                Self::InvalidArgument { argument, value, valid }
            }
            other => other,
        }
    }
}

/// A result of this library.
pub type Result<T> = std::result::Result<T, Error>;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_in_full_until_that_hides_their_size() {
        let message = |value: &dyn std::fmt::Display| Error::invalid("n", value, "less").to_string();
        assert_eq!(message(&u64::MAX), "n is 18446744073709551615; valid: less");
        assert_eq!(message(&-0.300_000_000_000_000_04), "n is -0.30000000000000004; valid: less");
        assert_eq!(message(&f64::MAX), "n is 1.7976931348623157e308; valid: less");
        assert_eq!(message(&-1e-300), "n is -1e-300; valid: less");
        assert_eq!(message(&"not a number, but long"), "n is not a number, but long; valid: less");
    }

    #[test]
    fn an_argument_is_called_what_its_caller_calls_it() {
        let error = Error::invalid("spectrum[7]", -1, "at least 0");
        assert_eq!(error.clone().of("scene").to_string(), "scene.spectrum[7] is -1; valid: at least 0");
        assert_eq!(error.clone().called("spectrum", "lut").to_string(), "lut[7] is -1; valid: at least 0");
        assert_eq!(error.clone().called("trum", "lut"), error);
    }
}
