//! What of the kernel text is compiled: definitions that the plan, the volume and the job decide. What is off is not in
//! the kernel that runs.

use crate::engine::Layers;
use crate::engine::gpu::voxels::{Density, DeviceVoxels};
use crate::plan::Plan;
use crate::scene::Algorithm;

/// Where the voxels are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// 16-bit codes in a buffer.
    Coded,
    /// Densities and labels in buffers.
    Dense,
    /// HU in the caller's texture.
    Texture,
}

/// Definitions by name. Equal definitions make equal kernels.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Definitions(Vec<(&'static str, u32)>);

impl Definitions {
    /// What the plan and the volume decide.
    pub(super) fn of(plan: &Plan, materials: usize, voxels: &DeviceVoxels, layout: Layout) -> Self {
        let labels = plan.materials.iter().fold(0, |labels, material| labels | 1 << material.label);
        let mut all = vec![
            (
                "DRR_ALGORITHM",
                match plan.algorithm {
                    Algorithm::Joseph => 0,
                    Algorithm::March { .. } => 1,
                    Algorithm::Siddon => 2,
                    Algorithm::Exact => unreachable!("the plan refuses it"),
                },
            ),
            ("DRR_LABELS", labels),
            ("DRR_MATERIALS", materials as u32),
            ("DRR_SUPERSAMPLING", plan.supersampling as u32),
            (
                "DRR_VOXELS",
                match layout {
                    Layout::Coded => 0,
                    Layout::Dense => 1,
                    Layout::Texture => 2,
                },
            ),
            (
                "DRR_DENSITY",
                match voxels.density() {
                    None | Some(Density::Line { .. }) => 0,
                    Some(Density::Kink { .. }) => 1,
                    Some(Density::Table(_)) => 2,
                },
            ),
        ];
        if voxels.one_label {
            all.push(("DRR_ONE_LABEL", 1));
        }
        Self(all)
    }

    /// And what a job decides: its layers, the label of bone if its path is wanted, whether any ray may stop early, and
    /// the driving axis of all rays.
    pub(super) fn for_job(
        &self,
        layers: Layers,
        bone: Option<u8>,
        early_exit: bool,
        axis: Option<usize>,
    ) -> Self {
        let mut all = self.0.clone();
        let flags = [
            ("DRR_INTENSITY", layers.intensity),
            ("DRR_LINE_INTEGRAL", layers.line_integral),
            ("DRR_AREAL_DENSITY", layers.areal_density),
            ("DRR_EARLY_EXIT", early_exit),
        ];
        all.extend(flags.into_iter().filter(|(_, on)| *on).map(|(name, _)| (name, 1)));
        all.extend(bone.map(|label| ("DRR_BONE_PATH", u32::from(label))));
        all.extend(axis.map(|axis| ("DRR_AXIS", axis as u32)));
        Self(all)
    }

    /// Names and values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (&'static str, u32)> {
        self.0.iter().copied()
    }
}
