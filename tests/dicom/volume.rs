//! A CT as a test sees it.

use std::path::Path;

use drr::formats::{CtReader, Slice, VoxelKind, open_ct};
use drr::geometry::Grid;
use libtest_mimic::Failed;

/// The volume of a CT: its grid, and HU, all slices one after the other.
pub(crate) struct Read {
    pub(crate) grid: Grid,
    pub(crate) kind: VoxelKind,
    pub(crate) hu: Vec<f64>,
    pub(crate) notes: Vec<String>,
}

pub(crate) fn read(ct: &mut dyn CtReader) -> Result<Read, Failed> {
    let mut hu = vec![];
    ct.read(&mut |_, slice| {
        match slice {
            Slice::Int16(voxels) => hu.extend(voxels.iter().map(|&hu| f64::from(hu))),
            Slice::Float32(voxels) => hu.extend(voxels.iter().map(|&hu| f64::from(hu))),
        }
        Ok(())
    })?;
    Ok(Read { grid: ct.header().grid, kind: ct.header().voxels, hu, notes: ct.notes() })
}

pub(crate) fn open(path: &Path) -> Result<Read, Failed> {
    read(open_ct(path, None)?.as_mut())
}

pub(crate) fn check(holds: bool, message: impl Into<String>) -> Result<(), Failed> {
    if holds { Ok(()) } else { Err(message.into().into()) }
}

/// Whether a CT is refused, and the message has these words.
pub(crate) fn refused(path: &Path, words: &[&str]) -> Result<(), Failed> {
    let Err(error) = open_ct(path, None) else { return Err("it is read".into()) };
    let message = error.to_string();
    words.iter().try_for_each(|word| check(message.contains(word), format!("no {word:?} in: {message}")))
}
