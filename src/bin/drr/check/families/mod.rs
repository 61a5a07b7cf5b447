//! The hard cases, by family. The families' numbers are those of README.md, one folder up.

mod detectors;
mod determinism;
mod directions;
mod effects;
mod ends;
mod faces;
mod grids;
mod inputs;
mod spectra;

use super::case::Case;

/// By axis.
const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// What each family is about; the number is the place.
pub(crate) const TITLES: [&str; 28] = [
    "axis-parallel rays",
    "negative zero",
    "rays in a face",
    "rays along an edge",
    "rays through corners",
    "grazing rays",
    "source inside",
    "detector inside or in front",
    "misses",
    "the volume's outer faces",
    "anisotropy",
    "far sources",
    "far volumes",
    "thin volumes",
    "awkward matrices",
    "detectors",
    "opaque paths",
    "no signal",
    "early exit",
    "long sums",
    "not a number",
    "denormals",
    "extreme CT numbers",
    "files",
    "derivatives",
    "spectra at their limits",
    "determinism",
    "bone path",
];

/// Every case.
pub(crate) fn all() -> Vec<Case> {
    [
        directions::cases(),
        faces::cases(),
        ends::cases(),
        grids::cases(),
        detectors::cases(),
        spectra::cases(),
        effects::cases(),
        inputs::cases(),
        determinism::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
