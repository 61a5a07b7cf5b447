//! What the tests give to the library: a context, a volume of 3×2×2 voxels, a scene of 2×2 pixels, two views.

use std::ffi::{CStr, c_char};
use std::mem::MaybeUninit;
use std::ptr::null_mut;

use drr::capi::context::*;
use drr::capi::effects::*;
use drr::capi::geometry::*;
use drr::capi::outputs::*;
use drr::capi::projector::*;
use drr::capi::reference::*;
use drr::capi::scene::*;
use drr::capi::status::*;
use drr::capi::volume::*;
use drr::shared::ProjectionUniforms;

pub(super) const DIMENSIONS: [usize; 3] = [3, 2, 2];
pub(super) const VOXELS: usize = 12;
pub(super) const SIZE: [usize; 2] = [2, 2];
pub(super) const VIEWS: usize = 2;
pub(super) const PIXELS: usize = VIEWS * SIZE[0] * SIZE[1];
pub(super) const MATERIALS: usize = 4;
/// keV 60 and 70: the built-in tables, which Miri is slow to parse, stay out of it.
pub(super) const ENERGIES: usize = 2;

pub(super) const HU: [i16; VOXELS] = [0, 40, -1000, 900, 1200, -32768, 0, -80, 300, 3071, -2048, 10];
pub(super) const LABELS: [u8; VOXELS] = [2, 2, 0, 3, 3, 0, 2, 1, 3, 3, 0, 2];
pub(super) const SPECTRUM: [f32; ENERGIES] = [0.25, 0.75];
pub(super) const ATTENUATION: [f32; MATERIALS * ENERGIES] = [0.19, 0.18, 0.20, 0.19, 0.21, 0.20, 0.31, 0.28];

pub(super) fn text(string: *const c_char) -> String {
    // SAFETY: what the library returns is not null, ends in NUL and lives long enough.
    unsafe { CStr::from_ptr(string) }.to_str().expect("UTF-8").to_owned()
}

pub(super) fn message() -> String {
    text(drr_last_error_message())
}

#[track_caller]
pub(super) fn ok(status: DrrStatus) {
    assert_eq!(status, DRR_STATUS_OK, "{}", message());
}

#[track_caller]
pub(super) fn refused(status: DrrStatus, words: &str) {
    assert_eq!(text(drr_status_name(status)), "DRR_STATUS_INVALID_ARGUMENT");
    assert!(message().contains(words), "{}", message());
}

/// What an initialiser fills, all of it.
pub(super) fn initialised<T>(init: unsafe extern "C" fn(*mut T) -> DrrStatus) -> T {
    let mut place = MaybeUninit::uninit();
    // SAFETY: a place for one struct, which a successful call fills.
    unsafe {
        ok(init(place.as_mut_ptr()));
        place.assume_init()
    }
}

pub(super) fn context(backend: DrrBackend, thread_count: u32) -> *mut DrrContext {
    let options = DrrContextOptions { backend, thread_count, ..initialised(drr_context_options_init) };
    let mut context = null_mut();
    // SAFETY: options and a place for a handle.
    ok(unsafe { drr_context_create(&raw const options, &raw mut context) });
    context
}

pub(super) fn descriptor() -> DrrVolumeDescriptor {
    DrrVolumeDescriptor { dimensions: DIMENSIONS, ..initialised(drr_volume_descriptor_init) }
}

pub(super) fn int16_labelled(context: *const DrrContext) -> *mut DrrVolume {
    let (descriptor, mut volume) = (descriptor(), null_mut());
    let (hu, labels) = (HU.as_ptr(), LABELS.as_ptr());
    // SAFETY: a live context, as many voxels and labels as the descriptor says, a place for a handle.
    ok(unsafe { drr_volume_create(context, &raw const descriptor, hu, labels, &raw mut volume) });
    volume
}

pub(super) fn float32_labelled(context: *const DrrContext) -> *mut DrrVolume {
    let (descriptor, mut volume) = (descriptor(), null_mut());
    let hu = HU.map(f32::from);
    // SAFETY: as above, and as many labels.
    let status = unsafe {
        drr_volume_create_float32(
            context,
            &raw const descriptor,
            hu.as_ptr(),
            LABELS.as_ptr(),
            &raw mut volume,
        )
    };
    ok(status);
    volume
}

pub(super) fn scene(algorithm: DrrAlgorithm) -> DrrScene {
    DrrScene {
        detector_width: SIZE[0],
        detector_height: SIZE[1],
        spectrum: SPECTRUM.as_ptr(),
        mass_attenuation: ATTENUATION.as_ptr(),
        energy_count: ENERGIES,
        first_energy_kev: 60.0,
        energy_step_kev: 10.0,
        effects: DRR_EFFECT_POLYENERGETIC | DRR_EFFECT_BONE_PATH,
        algorithm,
        ..initialised(drr_scene_init)
    }
}

pub(super) fn projector(volume: *const DrrVolume, scene: &DrrScene) -> *mut DrrProjector {
    let mut projector = null_mut();
    // SAFETY: a live volume, a scene whose tables are static, a place for a handle.
    ok(unsafe { drr_projector_create(volume, scene, &raw mut projector) });
    projector
}

pub(super) fn poses() -> [DrrDetectorPose; VIEWS] {
    [0.0, 60.0].map(|angle| {
        let mut pose = MaybeUninit::uninit();
        // SAFETY: three numbers, a place for one pose, which a successful call fills.
        unsafe {
            ok(drr_pose_c_arm(
                [1.0, 0.5, 0.5].as_ptr(),
                angle,
                20.0,
                30.0,
                1.5,
                SIZE[0],
                SIZE[1],
                pose.as_mut_ptr(),
            ));
            pose.assume_init()
        }
    })
}

pub(super) fn uniforms() -> [ProjectionUniforms; VIEWS] {
    poses().map(|pose| {
        let mut view = MaybeUninit::uninit();
        // SAFETY: one pose, a place for one struct, which a successful call fills.
        unsafe {
            ok(drr_uniforms_cone(&raw const pose, SIZE[0], SIZE[1], view.as_mut_ptr()));
            view.assume_init()
        }
    })
}

/// A place for every layer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Images<T> {
    pub(super) intensity: [T; PIXELS],
    pub(super) line_integral: [T; PIXELS],
    pub(super) areal_density: [T; MATERIALS * PIXELS],
    pub(super) bone_path_mm: [T; PIXELS],
}

impl<T: Copy> Images<T> {
    pub(super) fn filled(value: T) -> Self {
        Self {
            intensity: [value; PIXELS],
            line_integral: [value; PIXELS],
            areal_density: [value; MATERIALS * PIXELS],
            bone_path_mm: [value; PIXELS],
        }
    }
}

impl Images<f32> {
    pub(super) fn places(&mut self) -> DrrOutputs {
        DrrOutputs {
            intensity: self.intensity.as_mut_ptr(),
            line_integral: self.line_integral.as_mut_ptr(),
            areal_density: self.areal_density.as_mut_ptr(),
            bone_path_mm: self.bone_path_mm.as_mut_ptr(),
            ..initialised(drr_outputs_init)
        }
    }

    pub(super) fn of_poses(projector: *const DrrProjector) -> Self {
        let mut images = Self::filled(f32::NAN);
        let (poses, outputs) = (poses(), images.places());
        // SAFETY: a live projector, poses and images of its size.
        ok(unsafe { drr_projector_project_poses(projector, poses.as_ptr(), VIEWS, &raw const outputs) });
        images
    }

    pub(super) fn of_uniforms(projector: *const DrrProjector, views: &[ProjectionUniforms; VIEWS]) -> Self {
        let mut images = Self::filled(f32::NAN);
        let outputs = images.places();
        // SAFETY: a live projector, views whose tables live, images of its size.
        ok(unsafe { drr_projector_project(projector, views.as_ptr(), VIEWS, &raw const outputs) });
        images
    }
}

impl Images<f64> {
    pub(super) fn of_reference(projector: *const DrrProjector, algorithm: DrrAlgorithm) -> Self {
        let mut images = Self::filled(f64::NAN);
        let outputs = DrrReferenceOutputs {
            intensity: images.intensity.as_mut_ptr(),
            line_integral: images.line_integral.as_mut_ptr(),
            areal_density: images.areal_density.as_mut_ptr(),
            bone_path_mm: images.bone_path_mm.as_mut_ptr(),
            ..initialised(drr_reference_outputs_init)
        };
        let poses = poses();
        // SAFETY: a live projector, poses and images of its size.
        let status =
            unsafe { drr_reference_project(projector, algorithm, poses.as_ptr(), VIEWS, &raw const outputs) };
        ok(status);
        images
    }
}

#[track_caller]
pub(super) fn assert_close(images: &[f32], reference: &[f64]) {
    for (value, truth) in images.iter().zip(reference) {
        assert!((f64::from(*value) - truth).abs() <= 1e-6 + 1e-5 * truth.abs(), "{value} is not {truth}");
    }
}

/// Gives up what may be null.
pub(super) fn destroy(projector: *mut DrrProjector, volume: *mut DrrVolume, context: *mut DrrContext) {
    // SAFETY: live handles or null, not used again.
    unsafe {
        ok(drr_projector_destroy(projector));
        ok(drr_volume_destroy(volume));
        ok(drr_context_destroy(context));
    }
}
