//! A CT volume: density and material of every voxel. Immutable once made.

mod builder;
mod byte_voxels;
mod coarser;
mod code_ranges;
mod levels;
mod matter;
mod occupancy;
mod occupied;
mod partition;
mod seen;
mod voxels;

use std::any::Any;
use std::sync::{Arc, OnceLock};

use builder::Code;
pub use builder::{Classification, VolumeBuilder};
pub(crate) use byte_voxels::ByteVoxels;
pub use matter::Matter;
pub use occupancy::Occupancy;
pub(crate) use occupancy::{BRICK, bricks};
pub(crate) use occupied::Level;
pub use occupied::Occupied;
pub use voxels::{Voxel, Voxels};

use crate::allocation::reserved;
use crate::error::{Error, Result};
use crate::geometry::Grid;
use crate::physics::MAX_MATERIALS;

/// A CT volume. Voxel (i, j, k) is at `(k*n1 + j)*n0 + i`.
#[derive(Debug)]
pub struct Volume {
    grid: Grid,
    voxels: Voxels,
    materials: [MaterialStatistics; MAX_MATERIALS],
    /// What the labels mean, when thresholds made them.
    classes: Option<Vec<String>>,
    /// Made when first asked for, and kept as long as the volume: one byte more per voxel.
    byte_voxels: OnceLock<ByteVoxels>,
    /// Made when first asked for, too: 0.01 bytes per voxel.
    occupancy: OnceLock<Occupancy>,
    /// What made voxels of CT numbers.
    how: Classification,
}

/// What a volume holds of one material.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct MaterialStatistics {
    /// Whether any voxel carries the label.
    pub labelled: bool,
    /// Largest density of a voxel of this material, g/cm³; 0 means that the material cannot attenuate.
    pub max_density: f64,
}

impl MaterialStatistics {
    fn note(&mut self, voxel: Voxel) {
        self.labelled = true;
        self.max_density = self.max_density.max(voxel.density);
    }
}

impl Volume {
    /// A volume from int16 HU, x fastest, and optionally a material label per voxel; without labels the
    /// classification's thresholds decide.
    ///
    /// # Errors
    /// `InvalidArgument` when a length differs from the grid's, or a label is 8 or more; `OutOfMemory`.
    pub fn from_int16(grid: Grid, hu: &[i16], labels: Option<&[u8]>, how: &Classification) -> Result<Self> {
        let mut builder = VolumeBuilder::int16(grid, how, labels.is_some())?;
        builder.push_int16(hu, labels)?;
        builder.finish()
    }

    /// A volume from float32 HU; see [`Volume::from_int16`].
    ///
    /// # Errors
    /// As `from_int16`, and `InvalidArgument` for a voxel that is NaN or infinite.
    pub fn from_float32(grid: Grid, hu: &[f32], labels: Option<&[u8]>, how: &Classification) -> Result<Self> {
        let mut builder = VolumeBuilder::float32(grid, how)?;
        builder.push_float32(hu, labels)?;
        builder.finish()
    }

    /// A volume whose int16 HU are in a texture of a GPU and stay there. Nothing is known of them: every material of the
    /// classification is taken to occur, up to the largest density that the calibration gives it.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub fn from_texture(
        grid: Grid,
        texture: Arc<dyn Any + Send + Sync>,
        how: &Classification,
    ) -> Result<Self> {
        let mut table = reserved(1 << 16, "the volume's table")?;
        table.extend((0..=u16::MAX).map(|code| Code::Hu.meaning(code, how)));
        let mut materials = [MaterialStatistics::default(); MAX_MATERIALS];
        for &voxel in &table {
            materials[usize::from(voxel.label)].note(voxel);
        }
        let classes = Some(how.thresholds.materials().to_vec());
        let voxels = Voxels::Texture { table, texture };
        Ok(Self::made(grid, voxels, materials, classes, how.clone()))
    }

    /// Of what is known; the rest is made when it is asked for.
    fn made(
        grid: Grid,
        voxels: Voxels,
        materials: [MaterialStatistics; MAX_MATERIALS],
        classes: Option<Vec<String>>,
        how: Classification,
    ) -> Self {
        let (byte_voxels, occupancy) = (OnceLock::new(), OnceLock::new());
        Self { grid, voxels, materials, classes, byte_voxels, occupancy, how }
    }

    /// Dimensions and place in the world.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The voxels as stored.
    pub fn voxels(&self) -> &Voxels {
        &self.voxels
    }

    /// The voxels of [`Voxels::Coded`] in one byte each, for all projectors of the volume.
    ///
    /// # Errors
    /// `Unsupported` for other voxels; `OutOfMemory`.
    pub(crate) fn byte_voxels(&self) -> Result<&ByteVoxels> {
        if let Some(made) = self.byte_voxels.get() {
            return Ok(made);
        }
        let Voxels::Coded { codes, table } = &self.voxels else {
            return Err(Error::Unsupported("8-bit voxels are made of integer HU only".into()));
        };
        // Not while others wait: a thread of the pool that makes it could be given a projector's creation that waits.
        let made = ByteVoxels::new(codes, table)?;
        Ok(self.byte_voxels.get_or_init(|| made))
    }

    /// Where the volume holds what, brick by brick: made when first asked for, in one pass over the voxels, and kept.
    ///
    /// # Errors
    /// `Unsupported` for voxels in a texture; `OutOfMemory`.
    pub fn occupancy(&self) -> Result<&Occupancy> {
        if let Some(made) = self.occupancy.get() {
            return Ok(made);
        }
        // Not while others wait, as above.
        let made = Occupancy::new(self.grid.dimensions(), &self.voxels)?;
        Ok(self.occupancy.get_or_init(|| made))
    }

    /// What the volume holds of each material, by label.
    pub fn materials(&self) -> &[MaterialStatistics; MAX_MATERIALS] {
        &self.materials
    }

    /// The materials that the labels stand for, when thresholds made them; `None` when the caller gave the labels.
    pub fn classes(&self) -> Option<&[String]> {
        self.classes.as_deref()
    }

    /// What a code of [`Voxels::Coded`] means, whether it occurs or not.
    pub(crate) fn meaning(&self, code: u16) -> Voxel {
        self.code().meaning(code, &self.how)
    }

    fn code(&self) -> Code {
        if self.classes.is_some() { Code::Hu } else { Code::LabelAndHu }
    }

    /// The CT number behind a code of [`Voxels::Coded`] or [`Voxels::Texture`].
    pub(crate) fn hu_of(&self, code: u16) -> i32 {
        self.code().hu(code)
    }

    /// Bytes held for the voxels, with those of [`Storage::Byte`](crate::Storage) and of [`Volume::occupancy`] once they have
    /// been asked for.
    pub fn bytes(&self) -> usize {
        self.voxels.bytes()
            + self.byte_voxels.get().map_or(0, |bytes| bytes.levels.len())
            + self.occupancy.get().map_or(0, Occupancy::bytes)
    }
}
