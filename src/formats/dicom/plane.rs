//! Where the pixels of an image are in the patient.

use dicom_dictionary_std::tags;
use glam::DVec3;

use super::attributes::{Attributes, missing, name};
use crate::formats::Checked;

/// How far directions that should be unit vectors at right angles may be from that: they are written as decimals, often
/// with four digits.
const DIRECTION_TOLERANCE: f64 = 1e-3;

/// The image plane module of a frame (part 3, C.7.6.2), mm in LPS. Pixel (i, j) is column i, row j.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    /// Centre of pixel (0, 0).
    pub(super) position: DVec3,
    /// From pixel (0, 0) to (1, 0), along a row.
    pub(super) i_step: DVec3,
    /// From pixel (0, 0) to (0, 1), along a column.
    pub(super) j_step: DVec3,
}

impl Plane {
    /// `find` gives the attributes that hold a given one for the frame.
    pub(super) fn new<'a>(find: impl Fn(dicom_core::Tag) -> Option<&'a Attributes>) -> Checked<Self> {
        fn decimals<const N: usize>(from: Option<&Attributes>, tag: dicom_core::Tag) -> Checked<[f64; N]> {
            let numbers = from.map(|attributes| attributes.decimals(tag)).transpose()?.flatten();
            numbers.ok_or_else(|| missing(tag))
        }
        let tag = tags::IMAGE_POSITION_PATIENT;
        let position = DVec3::from_array(decimals(find(tag), tag)?);
        let tag = tags::IMAGE_ORIENTATION_PATIENT;
        let [rx, ry, rz, cx, cy, cz] = decimals(find(tag), tag)?;
        let [row, column] = [DVec3::new(rx, ry, rz), DVec3::new(cx, cy, cz)];
        let off = [row.length() - 1.0, column.length() - 1.0, row.dot(column)];
        if off.iter().any(|off| off.abs() > DIRECTION_TOLERANCE) {
            return Err(format!("{} is {row}, {column}; valid: unit vectors at right angles", name(tag)));
        }
        // Distance of rows first, which is the step along a column.
        let tag = tags::PIXEL_SPACING;
        let [rows, columns]: [f64; 2] = decimals(find(tag), tag)?;
        if rows <= 0.0 || columns <= 0.0 {
            return Err(format!("{} is {rows}, {columns}; valid: above 0 mm", name(tag)));
        }
        Ok(Self { position, i_step: row.normalize() * columns, j_step: column.normalize() * rows })
    }

    /// The unit vector at right angles to rows and columns.
    pub(super) fn normal(&self) -> DVec3 {
        self.i_step.cross(self.j_step).normalize()
    }
}
