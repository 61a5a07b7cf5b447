//! A file that replaces another one only when it is complete.

use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::Result;
use crate::formats::file_error;

/// Written under a temporary name in the destination's folder; `commit` renames it, dropping it removes it.
pub(super) struct Replacement {
    file: BufWriter<File>,
    temporary: PathBuf,
    destination: PathBuf,
    committed: bool,
}

impl Replacement {
    pub(super) fn create(path: &Path) -> Result<Self> {
        static COUNTER: AtomicU64 = AtomicU64::new(0);
        // Through a link, the file it points to is replaced and not the link.
        let destination = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        // A rename would replace a device such as /dev/null by a file.
        if fs::metadata(&destination).is_ok_and(|m| !m.is_file()) {
            return Err(file_error(path, "exists and is not a regular file"));
        }
        let name = destination.file_name().ok_or_else(|| file_error(path, "has no file name"))?;
        let (file, temporary) = loop {
            let number = COUNTER.fetch_add(1, Ordering::Relaxed);
            let temporary = destination.with_file_name(format!(
                ".{}.{}-{number}.part",
                name.to_string_lossy(),
                std::process::id()
            ));
            match OpenOptions::new().write(true).create_new(true).open(&temporary) {
                // Of a process with the same number, on another machine or killed.
                Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
                made => {
                    let failed = |e| file_error(path, format!("cannot write {}: {e}", temporary.display()));
                    break (made.map_err(failed)?, temporary);
                }
            }
        };
        Ok(Self { file: BufWriter::with_capacity(1 << 16, file), temporary, destination, committed: false })
    }

    /// Flushes and gives the file its name.
    pub(super) fn commit(mut self) -> Result<()> {
        let done = self.file.flush().and_then(|()| fs::rename(&self.temporary, &self.destination));
        done.map_err(|e| file_error(&self.destination, e))?;
        self.committed = true;
        Ok(())
    }
}

impl Write for Replacement {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Replacement {
    fn seek(&mut self, position: SeekFrom) -> std::io::Result<u64> {
        self.file.seek(position)
    }
}

impl Drop for Replacement {
    fn drop(&mut self) {
        if !self.committed {
            // Nothing can be done about a failure here; the name says that the file is partial.
            let _ = fs::remove_file(&self.temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn an_abandoned_file_leaves_the_old_one_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image");
        fs::write(&path, "old").unwrap();
        let mut file = Replacement::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(names(folder.path()).len(), 2);
        drop(file);
        assert_eq!(names(folder.path()), ["image"]);
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }

    #[test]
    fn a_committed_file_replaces_the_old_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image");
        fs::write(&path, "old").unwrap();
        let mut file = Replacement::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        file.commit().unwrap();
        assert_eq!(names(folder.path()), ["image"]);
        assert_eq!(fs::read(&path).unwrap(), b"new");
    }

    #[test]
    fn what_a_killed_process_with_the_same_number_left_is_in_nobody_s_way() {
        let folder = tempfile::tempdir().unwrap();
        let own = std::process::id();
        // Tests run side by side: the counter is anywhere below.
        for number in 0..1000 {
            fs::write(folder.path().join(format!(".image.{own}-{number}.part")), "left").unwrap();
        }
        let path = folder.path().join("image");
        let mut file = Replacement::create(&path).unwrap();
        file.write_all(b"new").unwrap();
        file.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::read(folder.path().join(format!(".image.{own}-0.part"))).unwrap(), b"left");
    }

    #[test]
    fn folders_are_not_replaced_and_missing_folders_are_named() {
        let folder = tempfile::tempdir().unwrap();
        assert!(Replacement::create(folder.path()).is_err());
        let message = Replacement::create(&folder.path().join("absent/image")).err().unwrap().to_string();
        assert!(message.contains("absent"), "{message}");
    }
}
