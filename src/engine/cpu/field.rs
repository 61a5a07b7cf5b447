//! The voxels as the march reads them: lanes of partial density.

use crate::allocation::collected;
use crate::engine::cpu::lanes::Lanes;
use crate::error::Result;
use crate::physics::MAX_MATERIALS;
use crate::volume::{Volume, Voxel, Voxels};

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
    pub(super) fn densities(volume: &Volume, lane_of: &[Option<usize>; MAX_MATERIALS]) -> Result<Self> {
        let lanes = |voxel: Voxel| L::single(lane_of[usize::from(voxel.label)], voxel.density as f32);
        match volume.voxels() {
            Voxels::Coded { table, .. } => Ok(Self::Code(per_code(table, lanes)?)),
            Voxels::Dense { .. } => Ok(Self::Density(per_label(lanes))),
            Voxels::Texture { .. } => unreachable!("the plan refuses it"),
        }
    }
}

impl<L: Lanes> Readable<L> for Table<L> {
    fn read(&self, volume: &Volume, work: &mut impl WithField<L>) {
        match (self, volume.voxels()) {
            (Self::Code(table), Voxels::Coded { codes, .. }) => work.run(&ByCode { codes, table }),
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
