//! Which files are looked at.

use std::path::{Path, PathBuf};

use super::file::is_dicom;
use super::object::Content;
use crate::error::Result;
use crate::formats::{file_error, has_ending};

/// Deepest folder that is looked into; studies on disks are three or four deep.
const DEEPEST: usize = 16;
/// The index that stands beside the folders of a disk (part 10, section 8.6).
const INDEX: &str = "DICOMDIR";

/// What was found: images of CT, and what was passed over.
#[derive(Debug, Default)]
pub(super) struct Found {
    pub(super) objects: Vec<super::object::Object>,
    /// Files that are not DICOM, or hold no image.
    pub(super) no_images: usize,
    /// The modality and the path of every image of another one.
    pub(super) others: Vec<(String, PathBuf)>,
    /// Images of CT that are not read: series, path and reason.
    pub(super) unreadable: Vec<(String, PathBuf, String)>,
}

/// The files of a folder and of those in it, by name, but hidden ones; a file itself. The index of a disk stands for its folder.
pub(super) fn list(path: &Path) -> Result<Vec<PathBuf>> {
    let fail = |e: std::io::Error| file_error(path, e);
    let index = path.file_name().is_some_and(|name| name.eq_ignore_ascii_case(INDEX));
    let folder = if index { path.parent().unwrap_or(path) } else { path };
    if !std::fs::metadata(path).map_err(fail)?.is_dir() && !index {
        return Ok(vec![path.to_owned()]);
    }
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let mut files = vec![];
    let mut folders = vec![(folder.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let fail = |e: std::io::Error| file_error(&folder, e);
        for entry in std::fs::read_dir(&folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            // What a Mac keeps beside files has their ending.
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            // A folder behind a link is not followed: it may lead back here. What is no file, such as a pipe, is not opened.
            if entry.file_type().map_err(fail)?.is_dir() {
                if depth < DEEPEST {
                    folders.push((entry.path(), depth + 1));
                }
            } else if entry.path().is_file() {
                files.push(entry.path());
            }
        }
    }
    files.sort();
    Ok(files)
}

/// Reads the headers of files. One that is not DICOM is passed over, unless it is said to be.
pub(super) fn read(files: &[PathBuf]) -> Result<Found> {
    let mut found = Found::default();
    for path in files {
        let fail = |reason: String| file_error(path, reason);
        // What ends before byte 132 isn't DICOM.
        if !is_dicom(path).map_err(|e| fail(e.to_string()))? {
            if files.len() == 1 || has_ending(path, &[".dcm", ".dicom"]) {
                return Err(fail("is not DICOM: it has no \"DICM\" at byte 128".to_owned()));
            }
            found.no_images += 1;
            continue;
        }
        match Content::read(path).map_err(fail)? {
            Content::NoImage => found.no_images += 1,
            Content::Other(modality) => found.others.push((modality, path.clone())),
            Content::Ct(object) => found.objects.push(object),
            Content::Unreadable(series, reason) => found.unreadable.push((series, path.clone(), reason)),
        }
    }
    Ok(found)
}
