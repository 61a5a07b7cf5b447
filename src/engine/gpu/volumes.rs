//! The volumes that a device holds, which projectors share.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use crate::error::Result;
use crate::volume::Volume;

type Held<D> = Vec<(Weak<Volume>, Weak<D>)>;

/// Volumes, and how the device holds them as long as a projector needs them there.
pub(crate) struct Volumes<D>(Mutex<Held<D>>);

impl<D> Default for Volumes<D> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<D> Volumes<D> {
    /// A volume as the device holds it, brought there if it is new.
    pub(crate) fn get(&self, volume: &Arc<Volume>, bring: impl FnOnce() -> Result<D>) -> Result<Arc<D>> {
        if let Some(known) = known(&mut self.locked(), volume) {
            return Ok(known);
        }
        // Not under the lock: what brings it there runs on threads that may be given another call of this function.
        let brought = Arc::new(bring()?);
        let mut volumes = self.locked();
        // Another thread may have been faster.
        Ok(known(&mut volumes, volume).unwrap_or_else(|| {
            volumes.push((Arc::downgrade(volume), Arc::downgrade(&brought)));
            brought
        }))
    }

    fn locked(&self) -> MutexGuard<'_, Held<D>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn known<D>(volumes: &mut Held<D>, volume: &Arc<Volume>) -> Option<Arc<D>> {
    volumes.retain(|(_, on_device)| on_device.strong_count() > 0);
    let known = volumes.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(volume)));
    known.and_then(|(_, on_device)| on_device.upgrade())
}
