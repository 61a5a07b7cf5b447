//! How voxels are stored: two bytes each when HU are integers, five otherwise; or not here at all.

use std::any::Any;
use std::sync::Arc;

/// Density and material of one voxel.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Voxel {
    /// g/cm³, never negative.
    pub density: f64,
    /// Material label.
    pub label: u8,
}

/// The voxels of a volume, x fastest.
#[derive(Debug)]
pub enum Voxels {
    /// One 16-bit code per voxel and the meaning of each code that occurs. Exact for integer HU: nothing is rounded,
    /// and the input's two bytes per voxel stay two bytes.
    Coded {
        /// One code per voxel.
        codes: Vec<u16>,
        /// Meaning of each code; 65536 entries, those of codes that do not occur are empty.
        table: Vec<Voxel>,
    },
    /// Density and label apart, for HU that are not integers.
    Dense {
        /// g/cm³.
        density: Vec<f32>,
        /// Material labels.
        label: Vec<u8>,
    },
    /// Integer HU in a texture of a GPU, which the host does not read: any CT number may occur.
    Texture {
        /// Meaning of each code, as for `Coded` without labels.
        table: Vec<Voxel>,
        /// The texture, known to the engine whose GPU it is on.
        texture: Arc<dyn Any + Send + Sync>,
    },
}

impl Voxels {
    /// The voxel at a flat index.
    ///
    /// # Panics
    /// When the voxels are in a texture.
    pub fn get(&self, index: usize) -> Voxel {
        match self {
            Self::Coded { codes, table } => table[usize::from(codes[index])],
            Self::Dense { density, label } => {
                Voxel { density: f64::from(density[index]), label: label[index] }
            }
            Self::Texture { .. } => unreachable!("engines that read voxels have refused the volume"),
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        match self {
            Self::Coded { codes, table } => size_of_val(&codes[..]) + size_of_val(&table[..]),
            Self::Dense { density, label } => size_of_val(&density[..]) + size_of_val(&label[..]),
            Self::Texture { table, .. } => size_of_val(&table[..]),
        }
    }
}
