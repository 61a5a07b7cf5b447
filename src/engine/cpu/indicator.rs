//! Where the voxels of one label are.

use crate::engine::cpu::field::{ByCode, Field, Readable, WithField, per_code, per_label};
use crate::error::Result;
use crate::physics::MAX_MATERIALS;
use crate::volume::{Volume, Voxel, Voxels};

/// 1 for voxels of one label, 0 for all others.
pub(super) enum Indicator {
    Code(Box<[f32; 1 << 16]>),
    Label([f32; MAX_MATERIALS]),
}

/// Labels alone.
struct ByLabel<'a> {
    label: &'a [u8],
    unit: &'a [f32; MAX_MATERIALS],
}

impl Field<f32> for ByLabel<'_> {
    #[inline(always)]
    fn at(&self, index: u32) -> f32 {
        self.unit[usize::from(self.label[index as usize])]
    }

    #[inline(always)]
    fn touch(&self, index: u32) -> u32 {
        u32::from(self.label[index as usize])
    }
}

impl Indicator {
    /// Of the voxels of `volume` that have this label.
    pub(super) fn new(volume: &Volume, label: u8) -> Result<Self> {
        let indicate = |voxel: Voxel| if voxel.label == label { 1.0 } else { 0.0 };
        match volume.voxels() {
            Voxels::Coded { table, .. } => Ok(Self::Code(per_code(table, indicate)?)),
            Voxels::Dense { .. } => Ok(Self::Label(per_label(indicate))),
            Voxels::Texture { .. } => unreachable!("the plan refuses it"),
        }
    }
}

impl Readable<f32> for Indicator {
    fn read(&self, volume: &Volume, work: &mut impl WithField<f32>) {
        match (self, volume.voxels()) {
            (Self::Code(table), Voxels::Coded { codes, .. }) => work.run(&ByCode { codes, table }),
            (Self::Label(unit), Voxels::Dense { label, .. }) => work.run(&ByLabel { label, unit }),
            _ => unreachable!("an indicator is only used with the volume it was made for"),
        }
    }
}
