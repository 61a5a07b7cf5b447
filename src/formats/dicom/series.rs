//! The one series that is read.

use std::collections::BTreeMap;
use std::path::Path;

use super::files::Found;
use super::object::Object;
use crate::error::Result;
use crate::formats::file_error;

/// Series of more than this are not all listed.
const MOST_LISTED: usize = 20;

/// The images of one series, none of which is a localizer.
#[derive(Debug)]
pub(super) struct Series {
    pub(super) objects: Vec<Object>,
    /// What was passed over, a sentence each.
    pub(super) notes: Vec<String>,
}

impl Series {
    /// The series with that UID, or the only one. Localizers are no slices, and passed over beside slices.
    pub(super) fn choose(found: Found, place: &Path, uid: Option<&str>) -> Result<Self> {
        let fail = |reason: String| Err(file_error(place, reason));
        let Found { objects, no_images, others, unreadable } = found;
        let counts = |series: &str| uid.is_none_or(|uid| uid == series);
        if let Some((_, path, reason)) = unreadable.into_iter().find(|(series, ..)| counts(series)) {
            return Err(file_error(&path, reason));
        }
        if objects.is_empty() {
            return fail(nothing(no_images, &others));
        }
        let mut series: BTreeMap<String, Vec<Object>> = BTreeMap::new();
        for object in objects {
            series.entry(object.series.clone()).or_default().push(object);
        }
        if let Some(uid) = uid {
            if !series.contains_key(uid) {
                return fail(format!("has no series {uid}; valid: {}", list(&series)));
            }
            series.retain(|own, _| own == uid);
        }
        let localizers: usize = series.values().flatten().filter(|object| object.localizer).count();
        if series.values().flatten().all(|object| object.localizer) {
            return fail(format!(
                "holds {localizers} localizer(s) (ImageType LOCALIZER), projections for planning and no slices; valid: \
                 the series that was planned on them: {}",
                list(&series)
            ));
        }
        for objects in series.values_mut() {
            objects.retain(|object| !object.localizer);
        }
        series.retain(|_, objects| !objects.is_empty());
        if series.len() > 1 {
            return fail(format!(
                "holds {} series; valid: one of them, chosen by its SeriesInstanceUID (--series):{}",
                series.len(),
                list(&series)
            ));
        }
        let mut notes = vec![];
        if localizers > 0 {
            notes.push(format!("{localizers} localizer(s) passed over"));
        }
        if no_images + others.len() > 0 {
            let mut modalities: Vec<_> = others.into_iter().map(|(modality, _)| modality).collect();
            modalities.sort();
            modalities.dedup();
            let files = format!("{no_images} file(s) without an image passed over");
            notes.push(match modalities.as_slice() {
                [] => files,
                some => format!("{files}, and images of {}", some.join(", ")),
            });
        }
        Ok(Self { objects: series.into_values().flatten().collect(), notes })
    }
}

/// Why there is no CT.
fn nothing(no_images: usize, others: &[(String, std::path::PathBuf)]) -> String {
    match others.first() {
        Some((modality, path)) => format!(
            "Modality is {modality} in {}, and no image of {} is a CT; valid: CT, whose voxels are HU",
            path.display(),
            others.len()
        ),
        None => format!("holds no DICOM image in {no_images} file(s); valid: a CT series"),
    }
}

/// A line for each series.
fn list(series: &BTreeMap<String, Vec<Object>>) -> String {
    let more = series.len().saturating_sub(MOST_LISTED);
    let more = (more > 0).then(|| format!("\n  and {more} more"));
    let listed = series.iter().take(MOST_LISTED).map(|(uid, objects)| line(uid, objects));
    listed.chain(more).collect()
}

fn line(uid: &str, objects: &[Object]) -> String {
    let slices: usize = objects.iter().map(|object| object.frames.len()).sum();
    let [columns, rows] = objects[0].size;
    let description = objects[0].description.as_deref().unwrap_or("without a description");
    let kind = if objects.iter().all(|object| object.localizer) { "localizer(s)" } else { "slice(s)" };
    format!(
        "\n  {uid}  {description}: {slices} {kind} of {columns} x {rows}, the first {}",
        objects[0].path.display()
    )
}
