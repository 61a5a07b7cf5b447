//! Exposures, developed as they were made and by another scene.

use drr::capi::exposure::{
    DrrExposure, drr_exposure_create, drr_exposure_create_poses, drr_exposure_destroy, drr_exposure_develop,
};
use drr::capi::outputs::{DRR_MAX_VIEWS, DrrOutputs, drr_outputs_init};
use drr::capi::projector::DrrProjector;

use super::call::{made, succeeded};
use super::input::Input;
use super::memory::{How, Place};
use super::scene::Accepted;
use super::views::{pose, view};
use super::volume::Extent;

/// By which an input says that its end is about an exposure.
const MARK: u8 = 0xee;
/// How many bytes of it.
const BYTES: usize = 64;
/// Most exponentials and samples, so that an input takes milliseconds.
const MOST_WORK: usize = 1 << 18;

/// Exposes one view and develops it twice, if the input says so.
pub(super) fn develop(
    input: &mut Input<'_>,
    projector: *const DrrProjector,
    scene: &Accepted,
    grid: &Extent,
) {
    let Some(mut input) = input.end(MARK, BYTES) else { return };
    let size = [scene.scene.detector_width, scene.scene.detector_height];
    let rays = size[0] * size[1] * (scene.scene.supersampling as usize).pow(2);
    let per_ray =
        scene.scene.energy_count * scene.scene.material_count + 64 * grid.longest * scene.samples_per_voxel();
    if rays.saturating_mul(per_ray) > MOST_WORK {
        return;
    }
    let projector = How::of(&mut input).pass(projector);
    let how = How::of(&mut input);
    // One view, or a number that is refused.
    let count = match input.count(1, 0..2) {
        2..=DRR_MAX_VIEWS => 1,
        count => count,
    };
    let exposure = if input.seldom() {
        let view = view(&mut input, grid, &scene.scene);
        let views = how.pass(&raw const view.uniforms);
        // SAFETY: one view, or none that is looked at; no function hears of progress.
        made(|place| unsafe {
            drr_exposure_create(projector, views, count, None, std::ptr::null_mut(), place)
        })
    } else {
        let pose = pose(&mut input, grid, size);
        let poses = how.pass(&raw const pose);
        // SAFETY: as above.
        made(|place| unsafe {
            drr_exposure_create_poses(projector, poses, count, None, std::ptr::null_mut(), place)
        })
    };
    let Some(exposure) = exposure else { return };
    let own = images(&mut input, exposure, std::ptr::null(), scene);
    let again = images(&mut input, exposure, &raw const scene.scene, scene);
    if let (Some(own), Some(again)) = (own, again) {
        assert!(own == again, "the same scene, other images");
    }
    // SAFETY: live, and not used again.
    assert!(succeeded(unsafe { drr_exposure_destroy(exposure) }));
}

/// Intensity and line integral, if the call succeeds.
fn images(
    input: &mut Input<'_>,
    exposure: *const DrrExposure,
    scene: *const drr::capi::scene::DrrScene,
    accepted: &Accepted,
) -> Option<[Vec<f32>; 2]> {
    let pixels = accepted.scene.detector_width * accepted.scene.detector_height * accepted.layers();
    let mut places = [(); 2].map(|()| Place::<f32>::new(How::Good, pixels));
    let mut outputs = std::mem::MaybeUninit::uninit();
    // SAFETY: a place for one struct; it is filled on success.
    let mut outputs: DrrOutputs = unsafe {
        assert!(succeeded(drr_outputs_init(outputs.as_mut_ptr())));
        outputs.assume_init()
    };
    [outputs.intensity, outputs.line_integral] = places.each_mut().map(Place::pointer);
    let (exposure, outputs) = (How::of(input).pass(exposure), How::of(input).pass(&raw const outputs));
    // SAFETY: a live exposure, a scene whose tables live, places for the images of one view; or pointers that are refused.
    if succeeded(unsafe { drr_exposure_develop(exposure, scene, outputs) }) {
        let images = places.each_ref().map(|place| place.written().to_vec());
        assert!(images.iter().flatten().all(|value| !value.is_nan()), "NaN");
        return Some(images);
    }
    places.iter().for_each(Place::assert_untouched);
    None
}
