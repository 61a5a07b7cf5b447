//! Bytes as a file, for readers that take a path.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

thread_local! {
    static FOLDER: RefCell<Option<TempDir>> = const { RefCell::new(None) };
}

/// A file with that name and content, in a folder of this thread that is used again and again.
pub(crate) fn with_content(name: &str, bytes: &[u8]) -> PathBuf {
    FOLDER.with_borrow_mut(|folder| {
        let folder = folder.get_or_insert_with(|| {
            let memory = Path::new("/dev/shm");
            let made = if memory.is_dir() { TempDir::new_in(memory) } else { TempDir::new() };
            made.expect("a folder can be made")
        });
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("a file can be written");
        path
    })
}
