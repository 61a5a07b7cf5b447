//! Rays of a camera, of a list and of a view by any numbers.

use drr::capi::context::DrrContext;
use drr::capi::raycast::{
    DRR_CAMERA_RAYS, DrrCamera, DrrRaySample, DrrRaycast, DrrWorldRay, drr_camera_init, drr_raycast_cast,
    drr_raycast_cast_camera, drr_raycast_create, drr_raycast_destroy,
};
use drr::capi::raycast_view::{
    DrrMatter, DrrRaySpan, drr_matter_init, drr_raycast_update, drr_raycast_update_pose,
};
use drr::capi::scene::drr_scene_init;
use drr::capi::status::DrrStatus;
use drr::capi::volume::drr_volume_destroy;

use super::call::{made, succeeded};
use super::input::Input;
use super::memory::How;
use super::views::{pose, view};
use super::volume::{self, Extent};

/// By which an input says that its end is about rays.
pub(super) const MARK: u8 = 0xd9;
/// How many bytes of it.
pub(super) const BYTES: usize = 256;
/// Rays of a list.
const RAYS: usize = 3;
/// Pixels, at most.
const MOST_PIXELS: usize = 64;

/// A struct that a function of the library fills.
fn filled<T>(init: impl FnOnce(*mut T) -> DrrStatus) -> T {
    let mut place = std::mem::MaybeUninit::uninit();
    assert!(succeeded(init(place.as_mut_ptr())));
    // SAFETY: a call that succeeds has written its result.
    unsafe { place.assume_init() }
}

/// Whether all rays were cast.
pub(super) fn check(input: &mut Input<'_>, context: *const DrrContext) -> bool {
    let Some((volume, grid)) = volume::make(input, context) else { return false };
    // SAFETY: a live handle.
    let raycast = made(|place| unsafe { drr_raycast_create(volume, place) }).expect("a cache");
    // SAFETY: live, and not used again: the cache keeps it.
    assert!(succeeded(unsafe { drr_volume_destroy(volume) }));
    let passed = camera(input, raycast, &grid) & list(input, raycast, &grid) & spans(input, raycast, &grid);
    // SAFETY: live, and not used again.
    assert!(succeeded(unsafe { drr_raycast_destroy(raycast) }));
    passed
}

/// What is true of every sample that is written.
fn sound(samples: &[DrrRaySample]) {
    for sample in samples {
        let ends = [sample.entry_mm, sample.exit_mm, sample.world_entry_mm, sample.world_exit_mm];
        assert!(ends.iter().all(|end| end.is_finite() && *end >= 0.0), "{sample:?}");
        assert!(sample.exit_mm >= sample.entry_mm && sample.world_exit_mm >= sample.world_entry_mm);
        let length = sample.direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((length - f64::from(sample.hit.0)).abs() < 1e-12, "{sample:?}");
    }
}

fn camera(input: &mut Input<'_>, raycast: *mut DrrRaycast, grid: &Extent) -> bool {
    // SAFETY: a place for one struct.
    let mut camera: DrrCamera = filled(|place| unsafe { drr_camera_init(place) });
    camera.struct_size = input.count(camera.struct_size, 0..120);
    camera.position = grid.centre.map(|centre| input.number(centre));
    camera.forward = camera.forward.map(|x| input.number(x));
    camera.up = camera.up.map(|x| input.number(x));
    camera.vertical_field_of_view_degrees = input.number(camera.vertical_field_of_view_degrees);
    camera.aspect = input.number(camera.aspect);
    let mut samples = [DrrRaySample::default(); DRR_CAMERA_RAYS];
    let (from, to) = (How::of(input).pass(&raw const camera), How::of(input).pass(samples.as_mut_ptr()));
    // SAFETY: a live handle; a struct and a place for five, or pointers that are refused.
    let done = succeeded(unsafe { drr_raycast_cast_camera(raycast, from, to.cast_mut()) });
    sound(&samples);
    assert!(done || samples.iter().all(|sample| sample.hit.0 == 0), "written by a call that failed");
    done
}

fn list(input: &mut Input<'_>, raycast: *mut DrrRaycast, grid: &Extent) -> bool {
    let rays = [0; RAYS].map(|_| DrrWorldRay {
        origin: grid.centre.map(|centre| input.number(centre)),
        direction: [1.0, 0.5, 0.0].map(|x| input.number(x)),
    });
    let mut samples = [DrrRaySample::default(); RAYS];
    // As many as there are, or a number that is refused.
    let count = match input.count(RAYS, 0..RAYS + 1) {
        count @ (..=RAYS) => count,
        _ => usize::MAX,
    };
    let (from, to) = (How::of(input).pass(rays.as_ptr()), How::of(input).pass(samples.as_mut_ptr()));
    // SAFETY: a live handle; as many rays and places as are said, or pointers that are refused.
    let done = succeeded(unsafe { drr_raycast_cast(raycast, from, count, to.cast_mut()) });
    sound(&samples);
    assert!(done || samples.iter().all(|sample| sample.hit.0 == 0), "written by a call that failed");
    done
}

fn spans(input: &mut Input<'_>, raycast: *mut DrrRaycast, grid: &Extent) -> bool {
    let size = [4, 3].map(|n| input.count(n, 0..8));
    // SAFETY: places for one struct each.
    let (mut matter, mut scene): (DrrMatter, _) =
        unsafe { (filled(|place| drr_matter_init(place)), filled(|place| drr_scene_init(place))) };
    matter.struct_size = input.count(matter.struct_size, 0..40);
    matter.floor = input.number(matter.floor);
    matter.labels = input.code(matter.labels);
    (scene.detector_width, scene.detector_height) = (size[0], size[1]);
    let none = DrrRaySpan { entry_mm: 0.0, exit_mm: 0.0, skipped_mm: 0.0 };
    let pixels = size[0].saturating_mul(size[1]);
    let mut spans = vec![none; if pixels <= MOST_PIXELS { pixels } else { 0 }];
    let place = if pixels <= MOST_PIXELS { How::of(input) } else { How::Null };
    let (given, to) = (How::of(input).pass(&raw const matter), place.pass(spans.as_mut_ptr()).cast_mut());
    let [width, height] = size;
    let how = How::of(input);
    let done = if input.seldom() {
        let view = view(input, grid, &scene);
        let uniforms = how.pass(&raw const view.uniforms);
        // SAFETY: a live handle; structs and a place for all pixels, or pointers that are refused.
        succeeded(unsafe { drr_raycast_update(raycast, uniforms, width, height, given, to) })
    } else {
        let pose = pose(input, grid, size);
        let pose = how.pass(&raw const pose);
        // SAFETY: as above.
        succeeded(unsafe { drr_raycast_update_pose(raycast, pose, width, height, given, to) })
    };
    for span in &spans {
        assert!(span.entry_mm.is_finite() && span.exit_mm >= span.entry_mm, "{span:?}");
        assert!(done || span.exit_mm == 0.0, "written by a call that failed");
        let length = span.exit_mm - span.entry_mm + span.skipped_mm;
        assert!(
            span.skipped_mm >= 0.0 && length <= grid.diagonal_mm * (1.0 + 1e-5) + 1e-5 * span.exit_mm.abs()
        );
    }
    done
}
