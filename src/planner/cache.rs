//! Plans that were measured, to be had again for nothing.

use std::sync::{Arc, Mutex, PoisonError, Weak};

use crate::error::Result;
use crate::plan::Plan;
use crate::scene::Scene;
use crate::volume::Volume;

/// Plans that are kept.
const MOST: usize = 16;

struct Entry {
    volume: Weak<Volume>,
    scene: Scene,
    plan: Plan,
}

/// The latest plans of one context.
#[derive(Default)]
pub(crate) struct Cache(Mutex<Vec<Entry>>);

impl Cache {
    /// The plan of the same scene and volume if it is known; else the one that `make` makes. Two threads may make the same.
    pub(super) fn get_or_make(
        &self,
        volume: &Arc<Volume>,
        scene: &Scene,
        make: impl FnOnce() -> Result<Plan>,
    ) -> Result<Plan> {
        let same = |entry: &Entry| entry.volume.as_ptr() == Arc::as_ptr(volume) && entry.scene == *scene;
        if let Some(entry) = self.entries().iter().find(|entry| same(entry)) {
            return Ok(entry.plan.clone());
        }
        let plan = make()?;
        let mut entries = self.entries();
        // A weak pointer keeps the address taken: no other volume can have it.
        entries.retain(|entry| entry.volume.strong_count() > 0);
        if entries.len() == MOST {
            entries.remove(0);
        }
        entries.push(Entry { volume: Arc::downgrade(volume), scene: scene.clone(), plan: plan.clone() });
        Ok(plan)
    }

    fn entries(&self) -> std::sync::MutexGuard<'_, Vec<Entry>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
