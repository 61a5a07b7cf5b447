//! The reader of detector poses: any text is poses that a projector takes, or an error.

use drr::formats::GeometryFile;

use crate::file;

/// Whether the file was accepted.
pub(crate) fn check(bytes: &[u8]) -> bool {
    let path = file::with_content("geometry.json", bytes);
    let Ok(geometry) = GeometryFile::read(&path) else { return false };
    assert!(!geometry.views.is_empty());
    for pose in &geometry.views {
        pose.validate().expect("what was read is valid");
    }
    let copy = path.with_file_name("copy.json");
    geometry.write(&copy).expect("what was read can be written");
    assert_eq!(GeometryFile::read(&copy).as_ref(), Ok(&geometry), "what was written is what was read");
    true
}
