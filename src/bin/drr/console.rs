//! What the user sees while the command runs.

use std::io::{ErrorKind, IsTerminal, Write};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Text to stdout and progress to stderr, unless the user wants it quiet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Console {
    quiet: bool,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
        Self { quiet }
    }

    /// The same, but silent: stdout is for something else.
    pub(crate) fn without_text(self, silent: bool) -> Self {
        Self { quiet: self.quiet || silent }
    }

    pub(crate) fn is_quiet(self) -> bool {
        self.quiet
    }

    pub(crate) fn say(self, text: impl std::fmt::Display) {
        if !self.quiet {
            Self::answer(text);
        }
    }

    /// Says that a result is probably not what was meant, also when quiet.
    pub(crate) fn warn(text: impl std::fmt::Display) {
        let _ = writeln!(std::io::stderr(), "warning: {text}");
    }

    /// Prints what was asked for, or ends the process. A reader that has gone away is no error of ours.
    pub(crate) fn answer(text: impl std::fmt::Display) {
        match writeln!(std::io::stdout(), "{text}") {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                let _ = writeln!(std::io::stderr(), "error: standard output: {error}");
                std::process::exit(1);
            }
            _ => (),
        }
    }

    /// A bar of `length` steps, shown when stderr is a terminal and removed when finished.
    pub(crate) fn bar(self, what: &'static str, length: usize) -> ProgressBar {
        if self.quiet || !std::io::stderr().is_terminal() {
            return ProgressBar::hidden();
        }
        let bar = ProgressBar::with_draw_target(Some(length as u64), ProgressDrawTarget::stderr_with_hz(10));
        if let Ok(style) = ProgressStyle::with_template("{msg:12} {wide_bar} {percent:>3} % {eta:>4}") {
            bar.set_style(style);
        }
        bar.with_message(what)
    }
}
