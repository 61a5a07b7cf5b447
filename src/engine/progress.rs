//! How far a job is, and whether its result is still wanted.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

/// What a caller's report function looks like: it is called from any thread, also from several at once, with the
/// number of rays finished since its last call, also none, and answers whether to go on.
pub type Report<'a> = &'a (dyn Fn(usize) -> ControlFlow<()> + Sync);

/// Hears nothing and never cancels.
pub const SILENT: Report<'static> = &|_rays| ControlFlow::Continue(());

/// A job's progress.
pub struct Progress<'a> {
    report: Report<'a>,
    cancelled: AtomicBool,
}

impl<'a> Progress<'a> {
    /// Nothing done yet.
    pub fn new(report: Report<'a>) -> Self {
        Self { report, cancelled: AtomicBool::new(false) }
    }

    /// `rays` more rays are finished. Once a [`ControlFlow::Break`] is seen, no thread reports again; reports that begin
    /// meanwhile are still made.
    ///
    /// # Errors
    /// `Cancelled` once a report has been answered with `Break`, in whatever thread.
    pub fn finished(&self, rays: usize) -> Result<()> {
        if self.cancelled.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        if (self.report)(rays).is_break() {
            self.cancelled.store(true, Ordering::Relaxed);
            return Err(Error::Cancelled);
        }
        Ok(())
    }
}
