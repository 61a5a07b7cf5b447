//! The slices of a series in order, and the grid that they form.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::object::{Frame, Object};
use crate::formats::Checked;
use crate::geometry::Grid;

/// How far a slice may be from where even spacing puts it: 10 µm, or 1/1000 of the spacing. Many scanners write positions with
/// two decimals.
const JITTER_MM: f64 = 1e-2;
/// Below this, two slices are at one position.
const SAME_MM: f64 = 1e-3;
const RELATIVE_JITTER: f64 = 1e-3;
/// How far the steps between the pixels of two slices may differ, relative to their length: 0.05 mm over 500 mm.
const STEP_TOLERANCE: f64 = 1e-4;

/// Slice k of the volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) object: usize,
    pub(super) frame: usize,
}

/// The slices in order along their normal.
#[derive(Debug)]
pub(super) struct Stack {
    pub(super) grid: Grid,
    pub(super) places: Vec<Place>,
}

impl Stack {
    /// Sorts the slices and sees that they form a grid. A tilted gantry shears it.
    pub(super) fn new(objects: &[Object]) -> Checked<Self> {
        let mut slices: Vec<Slice<'_>> = vec![];
        for (object, content) in objects.iter().enumerate() {
            let frames = content.frames.iter().enumerate();
            slices.extend(frames.map(|(n, frame)| Slice {
                place: Place { object, frame: n },
                frame,
                content,
            }));
        }
        let first = *slices.first().ok_or("has no slices")?;
        let plane = first.frame.plane;
        for slice in &slices {
            check_alike(&first, slice)?;
        }
        if slices.len() == 1 {
            return Err(format!(
                "is a single slice ({}), which has no spacing; valid: the folder with all slices of the series",
                first.name()
            ));
        }
        let normal = plane.normal();
        slices.sort_by(|a, b| a.along(normal).total_cmp(&b.along(normal)));
        check_even(&slices, normal)?;
        let [start, end] = [&slices[0], &slices[slices.len() - 1]].map(|slice| slice.frame.plane.position);
        let step = (end - start) / (slices.len() - 1) as f64;
        check_straight(&slices, start, step)?;
        let [columns, rows] = first.content.size;
        let map =
            DAffine3 { matrix3: DMat3::from_cols(plane.i_step, plane.j_step, step), translation: start };
        let grid = Grid::new([columns, rows, slices.len()], map).map_err(|e| e.to_string())?;
        Ok(Self { grid, places: slices.iter().map(|slice| slice.place).collect() })
    }

    /// The angle between the normal of the slices and the line that they are stacked along, degrees: the tilt of the gantry.
    pub(super) fn tilt(&self) -> f64 {
        let DMat3 { x_axis, y_axis, z_axis } = self.grid.index_to_world().matrix3;
        let angle = x_axis.cross(y_axis).angle_between(z_axis).to_degrees();
        angle.min(180.0 - angle)
    }
}

/// A slice while its place is sought.
#[derive(Clone, Copy)]
struct Slice<'a> {
    place: Place,
    frame: &'a Frame,
    content: &'a Object,
}

impl Slice<'_> {
    fn along(&self, normal: DVec3) -> f64 {
        self.frame.plane.position.dot(normal)
    }

    /// The file, and the frame where there are several.
    fn name(&self) -> String {
        let path: &Path = &self.content.path;
        match self.content.frames.len() {
            1 => path.display().to_string(),
            _ => format!("{}, frame {}", path.display(), self.place.frame + 1),
        }
    }
}

fn check_alike(first: &Slice<'_>, slice: &Slice<'_>) -> Checked<()> {
    let differ = |what: &str, a: String, b: String| {
        Err(format!(
            "has slices of different {what}: {a} in {}, {b} in {}; valid: slices alike; put others into a folder of \
             their own",
            first.name(),
            slice.name()
        ))
    };
    let size = |slice: &Slice<'_>| {
        let [columns, rows] = slice.content.size;
        format!("{columns} x {rows}")
    };
    if first.content.size != slice.content.size {
        return differ("size", size(first), size(slice));
    }
    let frame = |slice: &Slice<'_>| slice.content.frame_of_reference.clone();
    if let (Some(own), Some(other)) = (frame(first), frame(slice))
        && own != other
    {
        return differ("FrameOfReferenceUID", own, other);
    }
    let [a, b] = [first, slice].map(|slice| slice.frame.plane);
    for (own, other) in [(a.i_step, b.i_step), (a.j_step, b.j_step)] {
        if (own.length() - other.length()).abs() > STEP_TOLERANCE * own.length() {
            return differ("pixel spacing", format!("{} mm", own.length()), format!("{} mm", other.length()));
        }
        let [own, other] = [own, other].map(DVec3::normalize);
        if (own - other).length() > STEP_TOLERANCE {
            return differ("orientation", own.to_string(), other.to_string());
        }
    }
    Ok(())
}

/// Whether slices, in order, are at equal distances. Says where they are not.
fn check_even(slices: &[Slice<'_>], normal: DVec3) -> Checked<()> {
    let distances: Vec<f64> =
        slices.windows(2).map(|pair| pair[1].along(normal) - pair[0].along(normal)).collect();
    let mut sorted = distances.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = sorted[(sorted.len() - 1) / 2];
    let same: Vec<_> = (0..distances.len()).filter(|&n| distances[n] <= SAME_MM).collect();
    if let Some(&n) = same.first() {
        return Err(format!(
            "has {} slice(s) at the position of another, the first {} and {}; valid: one slice at each position; put \
             repeated scans, phases and reconstructions into folders of their own",
            same.len(),
            slices[n].name(),
            slices[n + 1].name()
        ));
    }
    // Both ends of a distance may be off.
    let tolerance = 2.0 * JITTER_MM.max(RELATIVE_JITTER * usual);
    let off = |n: &usize| (distances[*n] - usual).abs();
    let worst = (0..distances.len()).max_by(|a, b| off(a).total_cmp(&off(b)));
    if let Some(n) = worst.filter(|n| off(n) > tolerance) {
        let missing = (distances[n] / usual).round() - 1.0;
        let missing = if missing >= 1.0 { format!(": about {missing} missing") } else { String::new() };
        return Err(format!(
            "has slices at uneven distances: {:.4} mm between {} and {}, elsewhere {usual:.4} mm{missing}; valid: equal \
             distances; add what is missing, or resample",
            distances[n],
            slices[n].name(),
            slices[n + 1].name()
        ));
    }
    Ok(())
}

/// Whether slices lie on a line, where their number puts them.
fn check_straight(slices: &[Slice<'_>], start: DVec3, step: DVec3) -> Checked<()> {
    let tolerance = JITTER_MM.max(RELATIVE_JITTER * step.length());
    for (k, slice) in slices.iter().enumerate() {
        let off = (slice.frame.plane.position - (start + k as f64 * step)).length();
        if off > tolerance {
            return Err(format!(
                "has slices that are not on a line: {} is {off:.4} mm from where its neighbours put it; valid: at most \
                 {tolerance:.4} mm",
                slice.name()
            ));
        }
    }
    Ok(())
}
