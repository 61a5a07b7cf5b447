//! Telling the caller how far a projection is, and hearing whether to go on.

use std::ffi::c_void;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::capi::outputs::DrrProgress;
use crate::error::{Error, Result};

/// Calls a [`DrrProgress`] as its description promises: one call at a time, with growing fractions, none after false.
pub(super) struct Monitor {
    function: DrrProgress,
    user_data: *mut c_void,
    /// Rays of the projection.
    total: u64,
    finished: AtomicU64,
    said: Mutex<Said>,
}

/// What has passed between the library and the caller.
#[derive(Default)]
struct Said {
    /// Rays in the last call.
    rays: u64,
    cancelled: bool,
}

// SAFETY: `user_data` is only handed to `function`, which may be called from any thread by the promise to `new`.
unsafe impl Sync for Monitor {}

impl Monitor {
    /// For a projection of `total` rays.
    ///
    /// # Safety
    /// While the monitor lives, any thread may call `function` with `user_data`, one at a time.
    pub(super) unsafe fn new(function: DrrProgress, user_data: *mut c_void, total: u64) -> Self {
        Self { function, user_data, total, finished: AtomicU64::new(0), said: Mutex::default() }
    }

    /// `rays` more rays are finished.
    pub(super) fn report(&self, rays: usize) -> ControlFlow<()> {
        self.finished.fetch_add(rays as u64, Ordering::Relaxed);
        // A slow function holds up the thread that is in it and no other: the next call tells of all rays.
        match self.said.try_lock() {
            Ok(mut said) => self.tell(&mut said),
            Err(_) => ControlFlow::Continue(()),
        }
    }

    /// All rays are finished. Says so, if no report has yet.
    pub(super) fn complete(&self) -> Result<()> {
        match self.tell(&mut self.said.lock().unwrap_or_else(PoisonError::into_inner)) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Error::Cancelled),
        }
    }

    fn tell(&self, said: &mut Said) -> ControlFlow<()> {
        let rays = self.finished.load(Ordering::Relaxed);
        if let Some(function) = self.function
            && !said.cancelled
            && rays > said.rays
        {
            said.rays = rays;
            // SAFETY: by the promise to `new`; whoever calls holds `said`, so nobody else is in the function.
            said.cancelled = unsafe { !function(self.user_data, rays as f64 / self.total as f64).get() };
        }
        if said.cancelled { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shared::DrrBool;

    /// Notes the fraction, and answers with a byte that no C compiler makes of `true`.
    unsafe extern "C" fn note(fractions: *mut c_void, fraction: f64) -> DrrBool {
        // SAFETY: the test passes its vector, which it does not touch meanwhile.
        let fractions = unsafe { &mut *fractions.cast::<Vec<f64>>() };
        fractions.push(fraction);
        DrrBool(if fractions.len() == 3 { 0 } else { 0x80 })
    }

    #[test]
    fn fractions_grow_to_one_and_end_with_false() {
        let mut fractions = Vec::<f64>::new();
        let place = (&raw mut fractions).cast();
        // SAFETY: one thread, and `fractions` outlives both monitors.
        let monitor = unsafe { Monitor::new(Some(note), place, 40) };
        assert_eq!([10, 10].map(|rays| monitor.report(rays)), [ControlFlow::Continue(()); 2]);
        assert_eq!([10, 10].map(|rays| monitor.report(rays)), [ControlFlow::Break(()); 2]);
        assert_eq!(monitor.complete(), Err(Error::Cancelled));
        assert_eq!(fractions, [0.25, 0.5, 0.75], "not called again after false");

        fractions.clear();
        // SAFETY: as above.
        let monitor = unsafe { Monitor::new(Some(note), (&raw mut fractions).cast(), 40) };
        let busy = monitor.said.lock().expect("nobody panicked");
        assert_eq!(monitor.report(40), ControlFlow::Continue(()), "does not wait for who is in the function");
        drop(busy);
        assert_eq!(monitor.complete(), Ok(()));
        assert_eq!(fractions, [1.0], "the end is told in any case");
    }
}
