//! What the host tells the kernels of parallel beams: `shaders/parallel_wire.h`, byte for byte.

use crate::engine::gpu::wire::{Affine, Twofold};

/// How samples move with one parameter, in voxels.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Motion {
    /// By axis: offset, per column, per row; of the middle step.
    pub at: [[f32; 3]; 3],
    /// Per step.
    pub step: [f32; 3],
}

/// Where the samples of one view are, in voxels from the first one of the field's border, and how they move.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct View {
    /// Of the middle step.
    pub at: [Affine; 3],
    /// From a step to the next.
    pub step: [Twofold; 3],
    /// With α, β, φ, Δx, Δz.
    pub motion: [Motion; 5],
}

/// The steps of a ray that count, and which part of the first and the last one does.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Interval {
    pub first: u32,
    pub end: u32,
    pub first_part: f32,
    pub last_part: f32,
}

/// The field, the detector and the steps.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C)]
pub(crate) struct Launch {
    /// Of the field with its border.
    pub cells: [u32; 3],
    /// From a voxel to the next along x, along y.
    pub stride: [u32; 2],
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    pub views: u32,
    pub steps: u32,
    /// Of a step, mm.
    pub length: f32,
    /// Rays that one thread sums over.
    pub part: u32,
}

const _: () = {
    assert!(size_of::<View>() == 336 && align_of::<View>() == 4);
    assert!(size_of::<Interval>() == 16 && align_of::<Interval>() == 4);
    assert!(size_of::<Launch>() == 44 && align_of::<Launch>() == 4);
};
