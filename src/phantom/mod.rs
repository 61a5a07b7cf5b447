//! Analytic phantoms: solids with known HU whose line integrals are known in closed form, and their voxel volumes.
//!
//! World mm; most phantoms are centred on the origin. Material indices are those of the four-material model:
//! 0 air, 1 lung, 2 soft tissue, 3 bone.

mod catalogue;
mod coverage;
mod lengths;
mod row;
mod shape;
mod sweep;
mod thorax;
mod voxelise;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::geometry::Grid;

pub use catalogue::{Rod, rod_axes};
pub use shape::Shape;
pub(crate) use shape::{approach, intersection};

/// HU where no part is.
pub const BACKGROUND_HU: i16 = -1000;
/// Material where no part is.
pub const BACKGROUND_MATERIAL: u8 = 0;

/// A homogeneous solid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Where it is.
    pub shape: Shape,
    /// Its CT number, HU.
    pub hu: i16,
    /// Its material index; 0 is air.
    pub material: u8,
}

/// How `voxelise` decides about voxels on a surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// The mean over the voxel's box.
    PartialVolume,
    /// The value at the voxel's centre.
    Centre,
}

/// Solids in painter's order: where several contain a point, the last one counts.
#[derive(Debug, Clone, PartialEq)]
pub struct Phantom {
    name: String,
    parts: Vec<Part>,
    sampling: Sampling,
    noise: bool,
    extent: DVec3,
}

/// Half of the default grid: 360 × 360 × 332.5 mm.
const DEFAULT_EXTENT: DVec3 = DVec3::new(180.0, 180.0, 166.25);

impl Phantom {
    /// A phantom of any parts, voxelised with partial volumes and without noise.
    ///
    /// # Errors
    /// `InvalidArgument` when a shape is not valid.
    pub fn new(name: impl Into<String>, parts: Vec<Part>) -> Result<Self> {
        for part in &parts {
            part.shape.validate()?;
        }
        Ok(Self::of_valid_parts(name, parts))
    }

    fn of_valid_parts(name: impl Into<String>, parts: Vec<Part>) -> Self {
        let (sampling, noise) = (Sampling::PartialVolume, false);
        Self { name: name.into(), parts, sampling, noise, extent: DEFAULT_EXTENT }
    }

    /// The same phantom, voxelised with another rule for voxels on a surface.
    #[must_use]
    pub fn with_sampling(self, sampling: Sampling) -> Self {
        Self { sampling, ..self }
    }

    /// The same phantom; with `noise`, `voxelise` adds a fixed pseudo-random −15 … +16 HU (uniform) to every voxel
    /// whose centre lies in the first part. Line integrals never have noise.
    #[must_use]
    pub fn with_noise(self, noise: bool) -> Self {
        Self { noise, ..self }
    }

    /// One of `names`.
    ///
    /// # Errors
    /// `InvalidArgument` when there is no such phantom.
    pub fn named(name: &str) -> Result<Self> {
        match CATALOGUE.iter().find(|(known, _)| *known == name) {
            Some((_, make)) => Ok(make()),
            None => Err(Error::invalid("phantom", name, Self::names().join(", "))),
        }
    }

    /// The names that `named` knows.
    pub fn names() -> Vec<&'static str> {
        CATALOGUE.iter().map(|(name, _)| *name).collect()
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The parts, in painter's order.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Half the size, mm, of the box about the origin that the default grid covers.
    pub fn extent(&self) -> DVec3 {
        self.extent
    }

    /// The default grid at a resolution: `dimensions` voxels over ±`extent`.
    pub fn grid(&self, dimensions: [usize; 3]) -> Result<Grid> {
        Grid::centred(dimensions, 2.0 * self.extent / DVec3::from_array(dimensions.map(|n| n as f64)))
    }
}

type Constructor = fn() -> Phantom;

const CATALOGUE: [(&str, Constructor); 5] = [
    ("water_cylinder", Phantom::water_cylinder),
    ("rods", Phantom::rods),
    ("spheres", Phantom::spheres),
    ("boxes", Phantom::boxes),
    ("thorax", Phantom::thorax),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_a_valid_phantom_of_that_name() {
        for name in Phantom::names() {
            let phantom = Phantom::named(name).unwrap();
            assert_eq!(phantom.name(), name);
            assert_eq!(Phantom::new(name, phantom.parts().to_vec()).unwrap().parts(), phantom.parts());
            assert!(phantom.parts().iter().all(|part| part.material <= 3), "{name}");
        }
        let error = Phantom::named("nothing").unwrap_err().to_string();
        assert!(error.contains("nothing") && error.contains("water_cylinder"), "{error}");
    }

    #[test]
    fn default_grid_covers_the_extent() {
        let grid = Phantom::water_cylinder().grid([720, 720, 665]).unwrap();
        assert_eq!(grid, Grid::centred([720, 720, 665], DVec3::splat(0.5)).unwrap());
    }

    #[test]
    fn all_but_the_thorax_lie_inside_their_extent() {
        for name in ["water_cylinder", "rods", "spheres", "boxes"] {
            let phantom = Phantom::named(name).unwrap();
            for part in phantom.parts() {
                let [low, high] = part.shape.bounds();
                assert!(low.cmpgt(-phantom.extent()).all() && high.cmplt(phantom.extent()).all(), "{part:?}");
            }
        }
    }

    #[test]
    fn invalid_parts_are_refused() {
        let part = Part { shape: Shape::sphere(DVec3::ZERO, -1.0), hu: 0, material: 2 };
        assert!(matches!(Phantom::new("p", vec![part]), Err(Error::InvalidArgument { .. })));
    }
}
