//! Certificates: how wrong a projector's images are.

use crate::accuracy::{Certificate, Estimate};
use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::handle;
use crate::capi::memory;
use crate::capi::options::{self, Options};
use crate::capi::outputs::check_views;
use crate::capi::projector::{DrrProjector, requests};
use crate::capi::status::DrrStatus;
use crate::geometry::View;

/// The measured error of a projector in some views, against the exact integral of the interpolated voxels with every
/// energy: some thousand rays, cast again in float64. Fill it with drr_certificate_init, hand it to
/// drr_projector_certify. NaN where no ray says anything.
///
/// HU are HU-equivalents of the line integral, 1000 (p - p_exact) / p_exact, over rays with p_exact above `floor`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrCertificate {
    /// Set by drr_certificate_init.
    pub struct_size: usize,
    /// Rays that were cast again.
    pub rays: usize,
    /// A twentieth of the largest p among them.
    pub floor: f64,
    /// The confidence that is aimed at, 0.99: that root mean squares over all rays are below the bounds. Where few rays
    /// have most of the error it is less.
    pub confidence: f64,
    /// Root mean square error over the rays that were looked at, HU.
    pub rmse_hu: f64,
    /// What that over all rays is below.
    pub rmse_hu_bound: f64,
    /// Largest error among the rays that were looked at, HU.
    pub max_hu: f64,
    /// Displacement of edges that would explain the error where the image is steepest, root mean square, mm near the
    /// volume's centre.
    pub rmse_mm: f64,
    /// What that over all rays is below.
    pub rmse_mm_bound: f64,
    /// Root mean square error against the same algorithm in float64 with every energy, HU: rounding, and few energies.
    pub rounding_rmse_hu: f64,
    /// |p - p_exact| / |p_exact|, Euclidean norms over all rays.
    pub relative_l2: f64,
    /// Largest error of the intensity, as a part of that of a ray that meets nothing.
    pub max_intensity: f64,
}

const SIZE: usize = size_of::<[usize; 2]>() + 80;

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl Options for DrrCertificate {
    const SIZES: &'static [usize] = &[SIZE];
    fn defaults() -> Self {
        let unknown = f64::NAN;
        Self {
            struct_size: size_of::<Self>(),
            rays: 0,
            floor: unknown,
            confidence: unknown,
            rmse_hu: unknown,
            rmse_hu_bound: unknown,
            max_hu: unknown,
            rmse_mm: unknown,
            rmse_mm_bound: unknown,
            rounding_rmse_hu: unknown,
            relative_l2: unknown,
            max_intensity: unknown,
        }
    }
}

const _: () = assert!(size_of::<DrrCertificate>() == SIZE);

impl From<Certificate> for DrrCertificate {
    fn from(made: Certificate) -> Self {
        let part = |estimate: Option<Estimate>, part: fn(Estimate) -> f64| estimate.map_or(f64::NAN, part);
        Self {
            struct_size: size_of::<Self>(),
            rays: made.rays,
            floor: made.floor,
            confidence: made.confidence,
            rmse_hu: part(made.total.hu, |e| e.rms),
            rmse_hu_bound: part(made.total.hu, |e| e.rms_high),
            max_hu: part(made.total.hu, |e| e.max),
            rmse_mm: part(made.total.mm, |e| e.rms),
            rmse_mm_bound: part(made.total.mm, |e| e.rms_high),
            rounding_rmse_hu: part(made.rounding, |e| e.rms),
            relative_l2: made.total.relative_l2,
            max_intensity: made.total.max_intensity,
        }
    }
}

/// Fills `*certificate` with its size, and NaN for what is not known yet. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_certificate_init(certificate: *mut DrrCertificate) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("certificate", certificate) })
}

/// Measures the error of what drr_projector_project_poses gives for the `view_count` `poses`, 1 to DRR_MAX_VIEWS; of
/// more than 64, some are looked at. Of a scene with effects it is the rays' error, without the effects and in the
/// first detector layer. Takes about as long as the projection of a few thousand rays in float64.
///
/// `poses` are only read during the call. Writes `*certificate`, which drr_certificate_init has filled, on success
/// only. The same call gives the same numbers. Fails with DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_OUT_OF_MEMORY,
/// DRR_STATUS_DEVICE, or DRR_STATUS_UNSUPPORTED for a volume in a texture. Any thread, also with one projector from
/// many at once.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_projector_certify(
    projector: *const DrrProjector,
    poses: *const DrrDetectorPose,
    view_count: usize,
    certificate: *mut DrrCertificate,
) -> DrrStatus {
    guard(|| {
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let value = unsafe { handle::borrow("projector", projector)? };
        // SAFETY: the C caller passes a struct of the size that it says.
        unsafe { options::read("certificate", certificate)? };
        check_views(view_count)?;
        // SAFETY: the C caller passes `view_count` poses.
        let poses = unsafe { memory::read_array("poses", poses, view_count)? };
        let requests = requests("poses", poses, |pose| Ok(View::Pose(pose.into()).into()))?;
        let views: Vec<View> = requests.into_iter().map(|request| request.view).collect();
        let made = value.projector.certify(&views)?;
        // SAFETY: `read` has seen that there is a struct of today's size.
        unsafe { certificate.write(made.into()) };
        Ok(())
    })
}
