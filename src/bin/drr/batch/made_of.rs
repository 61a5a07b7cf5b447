//! What all views of a folder are made of.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;

use anyhow::{Context as _, Result, bail};
use tempfile::Builder;

use crate::metadata::Metadata;

/// Where a folder says it.
const FILE: &str = "made_of.json";

/// Says it, or sees that the folder says the same: whichever process is first decides, so that none adds views of another
/// CT, scene or plan, also where machines would plan differently.
pub(super) fn claim(folder: &Path, metadata: &Metadata) -> Result<()> {
    let path = folder.join(FILE);
    if !path.exists() {
        let own: BTreeMap<_, _> = metadata.common().iter().map(|(name, value)| (*name, value)).collect();
        write_first(folder, &path, &serde_json::to_string_pretty(&own)?)
            .with_context(|| format!("--output {}", path.display()))?;
    }
    check(folder, metadata)
}

/// Sees that the folder does not say something else.
pub(super) fn check(folder: &Path, metadata: &Metadata) -> Result<()> {
    let path = folder.join(FILE);
    if !path.exists() {
        return Ok(());
    }
    let at = || format!("--output {}", path.display());
    let text = std::fs::read_to_string(&path).with_context(at)?;
    let other: BTreeMap<String, String> = serde_json::from_str(&text).with_context(at)?;
    let differs = metadata.common().iter().find(|(name, value)| other.get(*name) != Some(value));
    if let Some((name, value)) = differs {
        let differing = differing(name, other.get(*name), value, "here");
        bail!("{}: its views have {differing}; valid: another folder", at());
    }
    Ok(())
}

/// What differs, in words.
pub(super) fn differing(name: &str, other: Option<&String>, own: &str, whose: &str) -> String {
    match other {
        // Digits of which nobody sees where they come from.
        Some(_) if name == "made_of" => {
            format!("another CT, or other labels, tables or effects, than {whose}")
        }
        Some(other) => format!("{name} \"{other}\", but {whose} it is \"{own}\""),
        None => format!("no {name}, but {whose} it is \"{own}\""),
    }
}

/// The file is whole as soon as it has its name, and never replaces another's.
fn write_first(folder: &Path, path: &Path, text: &str) -> Result<()> {
    let mut builder = Builder::new();
    builder.prefix(".made_of.").suffix(".part");
    // As other files, and not for the owner alone.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder)?;
    writeln!(file, "{text}")?;
    match file.persist_noclobber(path) {
        Err(error) if !path.exists() => Err(error.error.into()),
        _ => Ok(()),
    }
}
