//! Kernels that have been compiled, which projectors share.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::Result;

/// Kernels by what was compiled.
pub(crate) struct Programs<K, P>(Mutex<HashMap<K, Arc<P>>>);

impl<K, P> Default for Programs<K, P> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: Clone + Eq + Hash, P> Programs<K, P> {
    /// A kernel, compiled if it is new.
    pub(crate) fn get(&self, key: &K, compile: impl FnOnce() -> Result<P>) -> Result<Arc<P>> {
        // A panic leaves the map whole: kernels are made before they are put in.
        let mut programs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(program) = programs.get(key) {
            return Ok(program.clone());
        }
        let program = Arc::new(compile()?);
        programs.insert(key.clone(), program.clone());
        Ok(program)
    }
}
