//! Writing texts.

use std::io::Write as _;
use std::path::Path;

use crate::error::Result;
use crate::formats::file_error;
use crate::formats::replacement::Replacement;

/// Writes a text, as it is, in UTF-8.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    let mut file = Replacement::create(path)?;
    file.write_all(text.as_bytes()).map_err(|e| file_error(path, e))?;
    file.commit()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("text");
        write_text(&path, "½ voxel\n").unwrap();
        assert_eq!(std::fs::read_to_string(path).unwrap(), "½ voxel\n");
    }
}
