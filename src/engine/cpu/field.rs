//! The voxels as the march reads them: lanes of partial density.

use crate::allocation::collected;
use crate::engine::cpu::lanes::Lanes;
use crate::error::Result;
use crate::method::Storage;
use crate::physics::MAX_MATERIALS;
use crate::volume::{ByteVoxels, Volume, Voxel, Voxels};

/// A readable volume.
pub(super) trait Field<L: Lanes>: Sync {
    /// The lanes of the voxel at a flat index.
    fn at(&self, index: u32) -> L;
    /// Reads what is stored at a flat index, only to have it in cache.
    fn touch(&self, index: u32) -> u32;
}

/// Codes looked up in a table. The codes of one scan are few, so the part of the table in use stays in cache.
pub(super) struct ByCode<'a, L> {
    pub codes: &'a [u16],
    pub table: &'a [L; 1 << 16],
}

impl<L: Lanes> Field<L> for ByCode<'_, L> {
    #[inline(always)]
    fn at(&self, index: u32) -> L {
        self.table[usize::from(self.codes[index as usize])]
    }

    #[inline(always)]
    fn touch(&self, index: u32) -> u32 {
        u32::from(self.codes[index as usize])
    }
}

/// Levels looked up in a table that first-level cache holds.
struct ByByte<'a, L> {
    levels: &'a [u8],
    table: &'a [L; 1 << 8],
}

impl<L: Lanes> Field<L> for ByByte<'_, L> {
    #[inline(always)]
    fn at(&self, index: u32) -> L {
        self.table[usize::from(self.levels[index as usize])]
    }

    #[inline(always)]
    fn touch(&self, index: u32) -> u32 {
        u32::from(self.levels[index as usize])
    }
}

/// Densities times the unit lane of the label.
struct ByDensity<'a, L> {
    density: &'a [f32],
    label: &'a [u8],
    unit: &'a [L; MAX_MATERIALS],
}

impl<L: Lanes> Field<L> for ByDensity<'_, L> {
    #[inline(always)]
    fn at(&self, index: u32) -> L {
        self.unit[usize::from(self.label[index as usize])] * self.density[index as usize]
    }

    #[inline(always)]
    fn touch(&self, index: u32) -> u32 {
        self.density[index as usize].to_bits() ^ u32::from(self.label[index as usize])
    }
}

/// What each voxel of a volume contributes to each lane.
pub(super) enum Table<L> {
    Code(Box<[L; 1 << 16]>),
    Byte(Box<[L; 1 << 8]>),
    Density([L; MAX_MATERIALS]),
}

/// Something to be done with a field, whatever its storage.
pub(super) trait WithField<L: Lanes> {
    fn run<F: Field<L>>(&mut self, field: &F);
}

/// What a field can be made of, given the volume.
pub(super) trait Readable<L: Lanes> {
    /// Runs `work` on the volume that `self` was made for.
    fn read(&self, volume: &Volume, work: &mut impl WithField<L>);
}

impl<L: Lanes> Table<L> {
    /// Each voxel's density, in the lane of its label; labels without a lane contribute nothing.
    pub(super) fn densities(
        volume: &Volume,
        storage: Storage,
        lane_of: &[Option<usize>; MAX_MATERIALS],
    ) -> Result<Self> {
        let lanes = |voxel: Voxel| L::single(lane_of[usize::from(voxel.label)], voxel.density as f32);
        match (volume.voxels(), storage) {
            (Voxels::Coded { table, .. }, Storage::Exact) => Ok(Self::Code(per_code(table, lanes)?)),
            (_, Storage::Byte) => {
                let voxels = &volume.byte_voxels()?.table;
                let level = |level: usize| voxels.get(level).map_or(L::ZERO, |&voxel| lanes(voxel));
                Ok(Self::Byte(Box::new(std::array::from_fn(level))))
            }
            (Voxels::Dense { .. }, Storage::Exact) => Ok(Self::Density(per_label(lanes))),
            (Voxels::Texture { .. }, _) => unreachable!("the plan refuses it"),
        }
    }
}

impl<L: Lanes> Readable<L> for Table<L> {
    fn read(&self, volume: &Volume, work: &mut impl WithField<L>) {
        match (self, volume.voxels()) {
            (Self::Code(table), Voxels::Coded { codes, .. }) => work.run(&ByCode { codes, table }),
            (Self::Byte(table), Voxels::Coded { .. }) => match volume.byte_voxels() {
                Ok(ByteVoxels { levels, .. }) => work.run(&ByByte { levels, table }),
                Err(_) => unreachable!("they were made for the table"),
            },
            (Self::Density(unit), Voxels::Dense { density, label }) => {
                work.run(&ByDensity { density, label, unit });
            }
            _ => unreachable!("a table is only used with the volume it was made for"),
        }
    }
}

/// A value for each 16-bit code.
pub(super) fn per_code<L: Lanes>(table: &[Voxel], lanes: impl Fn(Voxel) -> L) -> Result<Box<[L; 1 << 16]>> {
    let lanes = collected(table.iter().map(|&voxel| lanes(voxel)), "the table of densities")?;
    let table = lanes.into_boxed_slice().try_into();
    Ok(table.unwrap_or_else(|_| unreachable!("there is one entry per 16-bit code")))
}

/// A value for each label, at a density of 1 g/cm³.
pub(super) fn per_label<L: Lanes>(lanes: impl Fn(Voxel) -> L) -> [L; MAX_MATERIALS] {
    std::array::from_fn(|label| lanes(Voxel { density: 1.0, label: label as u8 }))
}
