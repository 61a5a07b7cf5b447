//! Implants: solids of known shape in the volume.

use glam::DVec3;

use crate::capi::memory;
use crate::effects::{Implant, ImplantShape, MAX_SCREW_SECTIONS, Section};
use crate::error::{Error, Result};

/// What an implant is: one of the DRR_IMPLANT constants. Other values are refused.
pub type DrrImplantShape = u32;

/// A circular cylinder: `position` is the middle of one end, `axes`[0 .. 3] goes from there to the middle of the other.
pub const DRR_IMPLANT_ROD: DrrImplantShape = 0;
/// Cylinders one after the other on one axis, as `sections` say: `position` is where the axis leaves the first one,
/// outside, and `axes`[0 .. 3] the unit vector, to 1e-6, from there along the axis.
pub const DRR_IMPLANT_SCREW: DrrImplantShape = 1;
/// A ball: `position` is the centre.
pub const DRR_IMPLANT_SPHERE: DrrImplantShape = 2;
/// A box: `position` is the centre, and each axis goes from there to the middle of a face; at right angles, to 1e-6.
pub const DRR_IMPLANT_BOX: DrrImplantShape = 3;

/// One cylinder of a screw. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrScrewSection {
    /// Its length along the axis, mm, 1e-6 to 1e6.
    pub length_mm: f64,
    /// Its radius, mm, 1e-6 to 1e6.
    pub radius_mm: f64,
}

/// A homogeneous solid that is there instead of the volume, sharper than voxels. World mm. What its shape does not need
/// is not read. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrImplant {
    /// One of the DRR_IMPLANT constants.
    pub shape: DrrImplantShape,
    /// What it is made of: one of the scene's materials, below material_count.
    pub material: u32,
    /// Mass density, g/cm³, 1e-6 to 30.
    pub density: f64,
    /// Where it is, as its shape says, -1e10 to 1e10 mm.
    pub position: [f64; 3],
    /// Vectors, mm, as its shape says: component i of axis n is at 3 × n + i. Lengths are 1e-6 to 1e6 mm.
    pub axes: [f64; 9],
    /// The radius of a rod or a ball, mm, 1e-6 to 1e6.
    pub radius_mm: f64,
    /// The cylinders of a screw, from its head on.
    pub sections: *const DrrScrewSection,
    /// Number of sections of a screw, 1 to 1024.
    pub section_count: usize,
}

/// Of the fields of shapes, which C's it is.
const FIELDS: [(&str, &str); 12] = [
    ("shape.ends[0]", "position"),
    ("shape.ends[1]", "position + axes[0 .. 3]"),
    ("shape.distance of ends", "axes[0 .. 3]'s length"),
    ("shape.head", "position"),
    ("shape.centre", "position"),
    ("shape.direction", "axes[0 .. 3]"),
    ("shape.half_axes[0]", "axes[0 .. 3]"),
    ("shape.half_axes[1]", "axes[3 .. 6]"),
    ("shape.half_axes[2]", "axes[6 .. 9]"),
    ("shape.half_axes", "axes"),
    ("shape.radius", "radius_mm"),
    ("shape.", ""),
];

impl DrrImplant {
    /// The implant, which is called `name`, of a scene with so many materials.
    ///
    /// # Safety
    /// `sections` is null or misaligned, or as its description says.
    pub(super) unsafe fn read(&self, name: &str, materials: usize) -> Result<Implant> {
        let refused = |_| {
            let valid = format!("one of the scene's materials, 0 … {}", materials - 1);
            Error::invalid(format!("{name}.material"), self.material, valid)
        };
        let implant = Implant {
            // SAFETY: the caller's promise is the same.
            shape: unsafe { self.shape(name)? },
            material: u8::try_from(self.material).map_err(refused)?,
            density: self.density,
        };
        let called = |error: Error| {
            let error = error.called("scene.effects.implants[0].", "");
            let lengths = error.called("shape.length of half_axes", "shape.half_axes");
            FIELDS.into_iter().fold(lengths, |error, (from, to)| error.called(from, to)).of(name)
        };
        implant.validate(materials, 0).map_err(called).map(|()| implant)
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn shape(&self, name: &str) -> Result<ImplantShape> {
        let position = DVec3::from(self.position);
        let axis = |n: usize| DVec3::from_slice(&self.axes[3 * n..3 * n + 3]);
        Ok(match self.shape {
            DRR_IMPLANT_ROD => {
                ImplantShape::Rod { ends: [position, position + axis(0)], radius: self.radius_mm }
            }
            DRR_IMPLANT_SCREW => ImplantShape::Screw {
                head: position,
                direction: axis(0),
                // SAFETY: the caller's promise is the same.
                sections: unsafe { self.screw_sections(name)? },
            },
            DRR_IMPLANT_SPHERE => ImplantShape::Sphere { centre: position, radius: self.radius_mm },
            DRR_IMPLANT_BOX => ImplantShape::Box { centre: position, half_axes: [0, 1, 2].map(axis) },
            shape => {
                let valid = "one of the DRR_IMPLANT constants, 0 … 3";
                return Err(Error::invalid(format!("{name}.shape"), shape, valid));
            }
        })
    }

    /// # Safety
    /// As for [`Self::read`].
    unsafe fn screw_sections(&self, name: &str) -> Result<Vec<Section>> {
        if !(1..=MAX_SCREW_SECTIONS).contains(&self.section_count) {
            let valid = format!("1 … {MAX_SCREW_SECTIONS}");
            return Err(Error::invalid(format!("{name}.section_count"), self.section_count, valid));
        }
        // SAFETY: by the caller's promise there are as many.
        let sections =
            unsafe { memory::read_array(&format!("{name}.sections"), self.sections, self.section_count)? };
        let section = |section: &DrrScrewSection| Section {
            length_mm: section.length_mm,
            radius_mm: section.radius_mm,
        };
        Ok(sections.iter().map(section).collect())
    }
}
