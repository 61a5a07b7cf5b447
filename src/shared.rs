//! The structs that C programs, GPU kernels and Rust share, byte for byte.
//!
//! `include/DRR_Shared.h` is generated from this file and from `capi/`; the same sizes and offsets are asserted there
//! for every compiler that reads it.

#![allow(clippy::doc_markdown, reason = "the doc comments are the C header's")]

use std::mem::offset_of;

use glam::{DMat4, DVec3, Vec3};

use crate::geometry::Projection;

/// A 4×4 matrix, column-major: `columns[c][r]`. `simd_float4x4` on Apple, `metal::float4x4` in Metal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct DrrFloat4x4 {
    /// Columns.
    pub columns: [[f32; 4]; 4],
}

/// A vector of three in 16 bytes. `simd_float3` on Apple, `metal::float3` in Metal.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct DrrFloat3 {
    /// First component.
    pub x: f32,
    /// Second component.
    pub y: f32,
    /// Third component.
    pub z: f32,
}

/// An address as 64 bits: a host pointer for engines on the CPU, a GPU virtual address for engines on a GPU.
pub type DrrAddress = u64;

/// A C `bool`. C code can leave any byte there, which a Rust `bool` must not hold: every byte but 0 is true.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[repr(transparent)]
pub struct DrrBool(pub u8);

impl DrrBool {
    /// Whether it is true: any byte but 0.
    pub fn get(self) -> bool {
        self.0 != 0
    }
}

/// One view of a projection: the specification's struct, 112 bytes aligned to 16.
///
/// Clip space is Metal's: the centre of pixel (i, j), i = column, of a width × height detector is at
/// x = (2i+1)/width - 1, y = 1 - (2j+1)/height, depth 0 to 1. drr_uniforms_cone makes one from a detector pose.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
#[allow(non_snake_case, reason = "the specification's names")]
#[allow(clippy::pub_underscore_fields, reason = "the specification's names")]
pub struct ProjectionUniforms {
    /// World (mm) to clip space, column-major.
    pub modelViewProjectionMatrix: DrrFloat4x4,
    /// The X-ray source, world mm. Must be the point that the matrix sends to (0, 0, *, 0). Not read for a parallel
    /// beam, which is a matrix whose last row is (0, 0, 0, w).
    pub sourcePosition: DrrFloat3,
    /// Photons per energy bin for this view alone: energy_count floats. 0: the scene's own spectrum.
    pub spectrumLutAddress: DrrAddress,
    /// Mass attenuation coefficients for this view alone, cm²/g, 0 to 1e9: material_count × energy_count floats,
    /// material-major. 0: the scene's own.
    pub muLutAddress: DrrAddress,
    /// Whether a ray may stop once every energy bin is attenuated below exp(-15). Any byte but 0 is true.
    pub enableEarlyExit: DrrBool,
    /// Not read.
    pub _padding: f32,
}

const _: () = {
    assert!(size_of::<DrrFloat4x4>() == 64 && align_of::<DrrFloat4x4>() == 16);
    assert!(size_of::<DrrFloat3>() == 16 && align_of::<DrrFloat3>() == 16);
    assert!(size_of::<DrrBool>() == 1);
    assert!(size_of::<ProjectionUniforms>() == 112 && align_of::<ProjectionUniforms>() == 16);
    assert!(offset_of!(ProjectionUniforms, modelViewProjectionMatrix) == 0);
    assert!(offset_of!(ProjectionUniforms, sourcePosition) == 64);
    assert!(offset_of!(ProjectionUniforms, spectrumLutAddress) == 80);
    assert!(offset_of!(ProjectionUniforms, muLutAddress) == 88);
    assert!(offset_of!(ProjectionUniforms, enableEarlyExit) == 96);
    assert!(offset_of!(ProjectionUniforms, _padding) == 100);
};

impl From<&ProjectionUniforms> for Projection {
    fn from(uniforms: &ProjectionUniforms) -> Self {
        let DrrFloat3 { x, y, z } = uniforms.sourcePosition;
        let columns = uniforms.modelViewProjectionMatrix.columns.map(|column| column.map(f64::from));
        Self { matrix: DMat4::from_cols_array_2d(&columns), source: DVec3::new(x.into(), y.into(), z.into()) }
    }
}

/// Rounded to float32; no early exit, the scene's own tables.
impl From<&Projection> for ProjectionUniforms {
    fn from(projection: &Projection) -> Self {
        let Vec3 { x, y, z } = projection.source.as_vec3();
        Self {
            modelViewProjectionMatrix: DrrFloat4x4 {
                columns: projection.matrix.as_mat4().to_cols_array_2d(),
            },
            sourcePosition: DrrFloat3 { x, y, z },
            spectrumLutAddress: 0,
            muLutAddress: 0,
            enableEarlyExit: DrrBool(0),
            _padding: 0.0,
        }
    }
}
