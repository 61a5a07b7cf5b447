//! Volume, detector and steps of a parallel beam.

use glam::DVec3;

use crate::capi::boundary::guard;
use crate::capi::options;
use crate::capi::status::DrrStatus;
use crate::error::{Error, Result};
use crate::parallel::{MAX_STEPS, ParallelGeometry, Quadrature};

/// How a parallel ray is integrated: one of the DRR_PARALLEL constants. Other values are refused.
pub type DrrParallelQuadrature = u32;

/// Samples of the trilinear field at equal steps, times the step.
pub const DRR_PARALLEL_STEPS: DrrParallelQuadrature = 0;
/// The trilinear field integrated exactly. Needs no step.
pub const DRR_PARALLEL_EXACT: DrrParallelQuadrature = 1;

/// Volume, detector and steps of a parallel beam, which runs along +y. Fill it with drr_parallel_geometry_init, then set
/// `dimensions`, the detector's columns and rows, and what else should differ.
///
/// World x and z are along the detector's columns and rows: pixel (u, v), u = column, sees x = detector_centre[0] +
/// (u - (detector_columns - 1) / 2) × pixel[0], and z likewise from v. Step k is at y = centre[1] + (k - (steps - 1) / 2) ×
/// step. Beyond the outermost voxel centres the field falls to 0 within one voxel.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrParallelGeometry {
    /// Set by drr_parallel_geometry_init.
    pub struct_size: usize,
    /// Voxels along i, j, k: each 1 to 32768, at most 2^32 in all. Voxel (i, j, k) is at
    /// (k × dimensions[1] + j) × dimensions[0] + i. Default 0, which is refused.
    pub dimensions: [usize; 3],
    /// Distances of voxel centres along x, y, z, mm, 1e-9 to 1e6. Default 1.
    pub spacing: [f64; 3],
    /// The volume's centre before it moves, mm, up to 1e10. Default 0.
    pub centre: [f64; 3],
    /// Pixels per row, 1 to 32768. Default 0, which is refused.
    pub detector_columns: usize,
    /// Rows, 1 to 32768. Default 0, which is refused.
    pub detector_rows: usize,
    /// Distances of pixel centres along a row and from row to row, mm, 1e-9 to 1e6. Default 1.
    pub pixel: [f64; 2],
    /// x and z of the detector's centre, mm, up to 1e10. Default 0.
    pub detector_centre: [f64; 2],
    /// From one sample of a ray to the next, mm, 1e-9 to 1e6; not read for DRR_PARALLEL_EXACT. Default 0: spacing[1].
    pub step: f64,
    /// Samples of a ray, at most 2^20; not read for DRR_PARALLEL_EXACT. Default 0: as many as cover the volume's height,
    /// dimensions[1] × spacing[1] / step, rounded up.
    pub steps: u32,
    /// Default DRR_PARALLEL_STEPS.
    pub quadrature: DrrParallelQuadrature,
}

const GEOMETRY_SIZE: usize = size_of::<[usize; 6]>() + size_of::<[f64; 11]>() + 8;

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl options::Options for DrrParallelGeometry {
    const SIZES: &'static [usize] = &[GEOMETRY_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            dimensions: [0; 3],
            spacing: [1.0; 3],
            centre: [0.0; 3],
            detector_columns: 0,
            detector_rows: 0,
            pixel: [1.0; 2],
            detector_centre: [0.0; 2],
            step: 0.0,
            steps: 0,
            quadrature: DRR_PARALLEL_STEPS,
        }
    }
}

const _: () = assert!(size_of::<DrrParallelGeometry>() == GEOMETRY_SIZE);

impl DrrParallelGeometry {
    /// A geometry that is valid.
    pub(super) fn read(&self) -> Result<(ParallelGeometry, Quadrature)> {
        let quadrature = match self.quadrature {
            DRR_PARALLEL_STEPS => Quadrature::Steps,
            DRR_PARALLEL_EXACT => Quadrature::Exact,
            code => {
                let valid = "one of the DRR_PARALLEL constants, 0 … 1";
                return Err(Error::invalid("geometry.quadrature", code, valid));
            }
        };
        let detector = [self.detector_columns, self.detector_rows];
        let spacing = DVec3::from_array(self.spacing);
        let mut geometry = ParallelGeometry::new(self.dimensions, spacing, detector, self.pixel);
        if quadrature == Quadrature::Steps {
            if self.step != 0.0 {
                geometry = geometry.with_step(self.step);
            }
            if self.steps != 0 {
                geometry.steps = self.steps as usize;
            } else if geometry.steps > MAX_STEPS && self.step > 0.0 {
                let valid = format!("mm, of which the volume's height has at most {MAX_STEPS}");
                return Err(Error::invalid("geometry.step", self.step, valid));
            }
        }
        geometry.centre = self.centre.into();
        geometry.detector_centre = self.detector_centre;
        let in_c = |error: Error| error.called("detector ", "detector_").of("geometry");
        geometry.validate().map_err(in_c).map(|()| (geometry, quadrature))
    }
}

/// Fills `*geometry` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_parallel_geometry_init(geometry: *mut DrrParallelGeometry) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("geometry", geometry) })
}
