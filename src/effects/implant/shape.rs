//! The shapes of implants: where they meet a line, in closed form.

use glam::{DMat3, DVec3};

use crate::error::{Error, Result};
use crate::geometry::check_coordinates;
use crate::phantom::{Shape, approach, intersection};

/// Lengths of implants and their parts, mm.
const SIZES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
/// Most cylinders of one screw.
pub const MAX_SCREW_SECTIONS: usize = 1024;
/// What vectors may be off from unit length or right angles, relative: float32 has it.
const STRAIGHT: f64 = 1e-6;

/// The shape of an implant, in world mm. Coordinates are within ±1e10 mm, lengths 1e-6 … 1e6 mm. The surface belongs to
/// it.
#[derive(Debug, Clone, PartialEq)]
pub enum ImplantShape {
    /// A circular cylinder.
    Rod {
        /// The middles of both end faces.
        ends: [DVec3; 2],
        /// The radius, mm.
        radius: f64,
    },
    /// Cylinders one after the other on one axis: head, neck, shaft, tip.
    Screw {
        /// Where the axis leaves the first cylinder, on the outside.
        head: DVec3,
        /// From there along the axis: a unit vector to 1e-6. What is left of its length does not count.
        direction: DVec3,
        /// From the head on; 1 … 1024 of them.
        sections: Vec<Section>,
    },
    /// A ball.
    Sphere {
        /// The centre.
        centre: DVec3,
        /// The radius, mm.
        radius: f64,
    },
    /// A box in any orientation.
    Box {
        /// The centre.
        centre: DVec3,
        /// From the centre to the middles of three faces that meet: at right angles to 1e-6.
        half_axes: [DVec3; 3],
    },
}

/// One cylinder of a screw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Its length along the axis, mm.
    pub length_mm: f64,
    /// Its radius, mm.
    pub radius_mm: f64,
}

impl ImplantShape {
    /// Checks every range.
    ///
    /// # Errors
    /// `InvalidArgument` with the name of the field, to which the caller adds which implant it is.
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Rod { ends, radius } => {
                check_coordinates("ends[0]", ends[0])?;
                check_coordinates("ends[1]", ends[1])?;
                check_size("distance of ends", ends[0].distance(ends[1]))?;
                check_size("radius", *radius)
            }
            Self::Screw { head, direction, sections } => {
                check_coordinates("head", *head)?;
                if !((direction.length() - 1.0).abs() <= STRAIGHT) {
                    return Err(Error::invalid(
                        "direction",
                        direction,
                        format!("a unit vector, to {STRAIGHT:e}"),
                    ));
                }
                check_sections(sections)
            }
            Self::Sphere { centre, radius } => {
                check_coordinates("centre", *centre)?;
                check_size("radius", *radius)
            }
            Self::Box { centre, half_axes } => {
                check_coordinates("centre", *centre)?;
                for (k, axis) in half_axes.iter().enumerate() {
                    check_coordinates(&format!("half_axes[{k}]"), *axis)?;
                    check_size(&format!("length of half_axes[{k}]"), axis.length())?;
                }
                let [a, b, c] = half_axes.map(DVec3::normalize);
                let cosine = a.dot(b).abs().max(b.dot(c).abs()).max(c.dot(a).abs());
                if !(cosine <= STRAIGHT) {
                    let value = format!("{} {} {}", half_axes[0], half_axes[1], half_axes[2]);
                    return Err(Error::invalid(
                        "half_axes",
                        value,
                        format!("at right angles, to {STRAIGHT:e}"),
                    ));
                }
                Ok(())
            }
        }
    }

    /// Whether the point (mm) lies inside or on the surface.
    pub fn contains(&self, point: DVec3) -> bool {
        match self {
            Self::Rod { ends, radius } => rod(*ends, *radius).contains(point),
            Self::Screw { head, direction, sections } => {
                let axis = direction.normalize();
                let (offset, mut start) = (point - head, 0.0);
                let along = offset.dot(axis);
                let across = (offset - along * axis).length();
                sections.iter().any(|section| {
                    let first = start;
                    start += section.length_mm;
                    (first..=start).contains(&along) && across <= section.radius_mm
                })
            }
            Self::Sphere { centre, radius } => Shape::sphere(*centre, *radius).contains(point),
            Self::Box { centre, half_axes } => {
                let (cuboid, turn) = upright(half_axes);
                cuboid.contains(turn * (point - centre))
            }
        }
    }

    /// Where the line `origin + t * direction` is inside, in t: disjoint, ascending, none of no length.
    pub(super) fn intervals(&self, origin: DVec3, direction: DVec3) -> Vec<[f64; 2]> {
        let one = match self {
            Self::Rod { ends, radius } => rod(*ends, *radius).interval(origin, direction),
            Self::Screw { head, direction: axis, sections } => {
                return crossings(*head, axis.normalize(), sections, origin, direction);
            }
            Self::Sphere { centre, radius } => Shape::sphere(*centre, *radius).interval(origin, direction),
            // Turned after the approach: a far origin costs no digits.
            Self::Box { centre, half_axes } => {
                approach(*centre, origin, direction).and_then(|(nearest, near)| {
                    let (cuboid, turn) = upright(half_axes);
                    let chord = cuboid.interval(turn * near, turn * direction);
                    chord.map(|ends| ends.map(|t| nearest + t))
                })
            }
        };
        one.filter(|[enter, leave]| enter < leave).into_iter().collect()
    }
}

fn check_size(argument: &str, mm: f64) -> Result<()> {
    if SIZES.contains(&mm) {
        return Ok(());
    }
    Err(Error::invalid(argument, mm, format!("{:e} … {:e} mm", SIZES.start(), SIZES.end())))
}

fn check_sections(sections: &[Section]) -> Result<()> {
    if sections.is_empty() || sections.len() > MAX_SCREW_SECTIONS {
        let value = format!("{} cylinders", sections.len());
        return Err(Error::invalid("sections", value, format!("1 … {MAX_SCREW_SECTIONS}")));
    }
    for (k, section) in sections.iter().enumerate() {
        check_size(&format!("sections[{k}].length_mm"), section.length_mm)?;
        check_size(&format!("sections[{k}].radius_mm"), section.radius_mm)?;
    }
    Ok(())
}

fn rod([a, b]: [DVec3; 2], radius: f64) -> Shape {
    let along = b - a;
    Shape::Cylinder {
        centre: a + 0.5 * along,
        axis: along.normalize(),
        radius,
        half_length: 0.5 * along.length(),
    }
}

/// The box about the origin with its edges along the coordinate axes, and the turn that takes offsets from the centre
/// there.
fn upright(half_axes: &[DVec3; 3]) -> (Shape, DMat3) {
    let half = DVec3::from_array(half_axes.map(DVec3::length));
    let [a, b, c] = half_axes.map(DVec3::normalize);
    (Shape::Cuboid { minimum: -half, maximum: half }, DMat3::from_cols(a, b, c).transpose())
}

/// Where a line is in a screw. Each cylinder is that part of one as long as the screw that lies between two planes;
/// neighbours have one number for the plane they share, so that nothing is left between them.
fn crossings(
    head: DVec3,
    axis: DVec3,
    sections: &[Section],
    origin: DVec3,
    direction: DVec3,
) -> Vec<[f64; 2]> {
    let half_length = 0.5 * sections.iter().map(|section| section.length_mm).sum::<f64>();
    let Some((nearest, near)) = approach(head + half_length * axis, origin, direction) else {
        return Vec::new();
    };
    let (position, speed) = (near.dot(axis) + half_length, direction.dot(axis));
    let mut start = 0.0;
    let mut found: Vec<[f64; 2]> = Vec::new();
    for section in sections {
        let (first, last) = (start, start + section.length_mm);
        start = last;
        let radius = section.radius_mm;
        let long = Shape::Cylinder { centre: DVec3::ZERO, axis, radius, half_length };
        let between = if speed == 0.0 {
            (first..=last).contains(&position).then_some([f64::NEG_INFINITY, f64::INFINITY])
        } else {
            let [a, b] = [first, last].map(|plane| (plane - position) / speed);
            Some([a.min(b), a.max(b)])
        };
        let chord = between.zip(long.interval(near, direction)).and_then(|(a, b)| intersection(a, b));
        found.extend(chord.filter(|[enter, leave]| enter < leave));
    }
    merged(found).into_iter().map(|ends| ends.map(|t| nearest + t)).filter(|[a, b]| a < b).collect()
}

/// The same points in ascending intervals that do not touch.
fn merged(mut intervals: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    intervals.sort_by(|a, b| a[0].total_cmp(&b[0]));
    intervals.into_iter().fold(Vec::new(), |mut done, next| {
        match done.last_mut() {
            Some(last) if next[0] <= last[1] => last[1] = last[1].max(next[1]),
            _ => done.push(next),
        }
        done
    })
}
