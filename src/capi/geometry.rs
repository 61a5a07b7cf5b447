//! Detector poses, and the uniforms made from them.

use glam::DVec3;

use crate::capi::boundary::guard;
use crate::capi::memory;
use crate::capi::status::DrrStatus;
use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, MAX_COORDINATE, Projection, check_coordinates};
use crate::scene::MAX_DETECTOR;
use crate::shared::ProjectionUniforms;

/// Smallest length of a C-arm that is not 0, mm: what is made from it does not underflow.
const MIN_LENGTH: f64 = 1e-12;

/// A point source and a flat detector, world mm. The centre of pixel (i, j), i = column, is at
/// first_pixel + i × column_step + j × row_step. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct DrrDetectorPose {
    /// The source, off the detector's plane.
    pub source: [f64; 3],
    /// Centre of pixel (0, 0).
    pub first_pixel: [f64; 3],
    /// From the centre of pixel (0, 0) to that of pixel (1, 0).
    pub column_step: [f64; 3],
    /// From the centre of pixel (0, 0) to that of pixel (0, 1).
    pub row_step: [f64; 3],
}

impl From<&DrrDetectorPose> for DetectorPose {
    fn from(pose: &DrrDetectorPose) -> Self {
        Self {
            source: pose.source.into(),
            first_pixel: pose.first_pixel.into(),
            column_step: pose.column_step.into(),
            row_step: pose.row_step.into(),
        }
    }
}

impl From<DetectorPose> for DrrDetectorPose {
    fn from(pose: DetectorPose) -> Self {
        Self {
            source: pose.source.into(),
            first_pixel: pose.first_pixel.into(),
            column_step: pose.column_step.into(),
            row_step: pose.row_step.into(),
        }
    }
}

fn detector(width: usize, height: usize) -> Result<[usize; 2]> {
    for (name, n) in [("width", width), ("height", height)] {
        if !(1..=MAX_DETECTOR).contains(&n) {
            return Err(Error::invalid(name, n, format!("1 … {MAX_DETECTOR} pixels")));
        }
    }
    Ok([width, height])
}

/// The cone-beam uniforms of a pose, for a detector of `width` × `height` pixels: no early exit, the scene's own
/// tables.
///
/// The matrix is rounded to float32, so that a ray may miss its pixel by about 1e-7 of the distances of source and
/// detector from each other and from the world's origin, and by more where the steps are nearly parallel;
/// drr_projector_project_poses does not round. Writes `*uniforms` on success only. Fails with
/// DRR_STATUS_INVALID_ARGUMENT, also when the pose does not survive the rounding. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_uniforms_cone(
    pose: *const DrrDetectorPose,
    width: usize,
    height: usize,
    uniforms: *mut ProjectionUniforms,
) -> DrrStatus {
    guard(|| {
        memory::check("uniforms", uniforms, 1)?;
        // SAFETY: the C caller passes one pose.
        let pose = unsafe { &memory::read_array("pose", pose, 1)?[0] };
        let projection = Projection::from_pose(&pose.into(), detector(width, height)?)
            .map_err(|error| error.of("pose"))?;
        let rounded = ProjectionUniforms::from(&projection);
        Projection::from(&rounded).validate().map_err(|error| error.of("pose in float32"))?;
        // SAFETY: not null, aligned; the C caller passes a place for one struct.
        unsafe { uniforms.write(rounded) };
        Ok(())
    })
}

/// The pose of a C-arm that looks at `centre` (3 values, world mm): at 0 degrees the source is at -y, columns run
/// along +x, rows along +z; `angle_degrees` turns source and detector about the z axis. The specification's stereo
/// pair is -6 and +6.
///
/// `source_axis_mm` is from the source to `centre`, 0 to 1e10; `source_detector_mm` from the source to the detector,
/// 1e-12 to 1e10; `pixel_mm` the side of a pixel, 1e-12 to 1e10. The detector of `width` × `height` pixels is
/// centred on the central ray. Writes `*pose` on success only. Fails with DRR_STATUS_INVALID_ARGUMENT. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_pose_c_arm(
    centre: *const f64,
    angle_degrees: f64,
    source_axis_mm: f64,
    source_detector_mm: f64,
    pixel_mm: f64,
    width: usize,
    height: usize,
    pose: *mut DrrDetectorPose,
) -> DrrStatus {
    guard(|| {
        memory::check("pose", pose, 1)?;
        // SAFETY: the C caller passes three numbers.
        let centre = DVec3::from_slice(unsafe { memory::read_array("centre", centre, 3)? });
        check_coordinates("centre", centre)?;
        for (name, value, least) in [
            ("source_axis_mm", source_axis_mm, 0.0),
            ("source_detector_mm", source_detector_mm, MIN_LENGTH),
            ("pixel_mm", pixel_mm, MIN_LENGTH),
        ] {
            if !(least..=MAX_COORDINATE).contains(&value) {
                let least = if least > 0.0 { format!("{least:e}") } else { "0".to_owned() };
                return Err(Error::invalid(name, value, format!("{least} … {MAX_COORDINATE:e} mm")));
            }
        }
        if !angle_degrees.is_finite() {
            return Err(Error::invalid("angle_degrees", angle_degrees, "a finite number"));
        }
        let size = detector(width, height)?;
        let arm =
            DetectorPose::c_arm(centre, angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, size);
        arm.validate().map_err(|error| error.of("pose"))?;
        // SAFETY: not null, aligned; the C caller passes a place for one struct.
        unsafe { pose.write(arm.into()) };
        Ok(())
    })
}
