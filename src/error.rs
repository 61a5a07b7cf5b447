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
    /// A progress report was answered with the wish to stop. Nothing was written.
    #[error("cancelled by the caller's progress function")]
    Cancelled,
    /// An earlier call panicked while it used this handle of the C ABI.
    #[error(
        "{argument} is poisoned: an earlier call with it met an internal error, and it can only be destroyed"
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

impl Error {
    /// An argument outside its range: its name, the value given, the valid range.
    pub fn invalid(
        argument: impl Into<String>,
        value: impl std::fmt::Display,
        valid: impl Into<String>,
    ) -> Self {
        Self::InvalidArgument { argument: argument.into(), value: value.to_string(), valid: valid.into() }
    }
}

impl Error {
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
}

/// A result of this library.
pub type Result<T> = std::result::Result<T, Error>;
