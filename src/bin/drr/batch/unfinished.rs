//! What a process has still to do.

use std::collections::{BTreeMap, HashSet};
use std::ffi::OsString;
use std::path::Path;

use anyhow::{Context as _, Result, bail};

use crate::batch::Batch;
use crate::batch::made_of::differing;
use crate::metadata::PREFIX;

/// The rows of a batch's shard whose files are missing.
///
/// # Errors
/// Where a view's file is there and was made of something else: it is not replaced.
pub(super) fn unfinished(batch: &Batch<'_>) -> Result<Vec<usize>> {
    let mut rows = Vec::new();
    for row in batch.shard.rows(batch.job.views.poses.len()) {
        if !is_finished(batch, row)? {
            rows.push(row);
        }
    }
    remove_begun(batch, &rows)?;
    Ok(rows)
}

/// Whether all files of a row are there; each that is there was made of what the row asks for.
fn is_finished(batch: &Batch<'_>, row: usize) -> Result<bool> {
    let output = batch.job.output;
    let view = batch.job.views.named(row);
    let at = || format!("--output {}", output.folder().display());
    let own = output.metadata.of(&view);
    let mut finished = true;
    for (format, path) in output.files(&view) {
        if !path.exists() {
            finished = false;
            continue;
        }
        let there: BTreeMap<_, _> = format.metadata(&path).with_context(at)?.into_iter().collect();
        if let Some((name, value)) = own.iter().find(|(name, value)| there.get(name) != Some(value)) {
            let plain = name.trim_start_matches(PREFIX);
            let differing = differing(plain, there.get(name), value, &format!("in row {row} of --views"));
            bail!(
                "--output: {} has {differing}; valid: another folder, or without that file",
                path.display()
            );
        }
    }
    // Raw layers are written before the others, but may not have been asked for then.
    Ok(finished && output.raw(&view, batch.is_reference()).iter().all(|path| path.exists()))
}

/// Removes what a process that was killed had begun of these rows, which nobody else makes.
fn remove_begun(batch: &Batch<'_>, rows: &[usize]) -> Result<()> {
    let file_name = |path: &Path| path.file_name().map(OsString::from);
    let files = |&row: &usize| {
        let view = batch.job.views.named(row);
        let mut files = batch.job.output.raw(&view, batch.is_reference());
        files.extend(batch.job.output.files(&view).into_iter().map(|(_, path)| path));
        files.into_iter().filter_map(|path| file_name(&path))
    };
    let expected: HashSet<_> = rows.iter().flat_map(files).collect();
    let folder = batch.job.output.folder();
    let at = || format!("--output {}", folder.display());
    for entry in std::fs::read_dir(folder).with_context(at)? {
        let entry = entry.with_context(at)?;
        let name = entry.file_name();
        // .FILE.PROCESS-NUMBER.part
        let begun =
            name.to_str().and_then(|name| name.strip_prefix('.')?.strip_suffix(".part")?.rsplit_once('.'));
        if begun.is_some_and(|(file, _)| expected.contains(&OsString::from(file))) {
            std::fs::remove_file(entry.path()).with_context(at)?;
        }
    }
    Ok(())
}
