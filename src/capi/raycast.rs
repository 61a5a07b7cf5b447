//! Rays of a camera or of a list through a volume's box, and the cache that keeps what they meet.

use std::sync::{Mutex, PoisonError};

use crate::allocation::reserved;
use crate::capi::boundary::guard;
use crate::capi::handle::{self, Opaque};
use crate::capi::status::DrrStatus;
use crate::capi::volume::DrrVolume;
use crate::capi::{memory, options};
use crate::error::{Error, Result};
use crate::raycast::{Camera, RayCache, RaySample, WorldRay};
use crate::shared::DrrBool;

/// Most rays of a list.
pub const DRR_MAX_RAYS: usize = 16_777_216;
/// Rays of a camera: through the picture's centre, and its corners top left, top right, bottom left, bottom right.
pub const DRR_CAMERA_RAYS: usize = 5;

/// A half-line in the world. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrWorldRay {
    /// Where it starts, mm, up to 1e10.
    pub origin: [f64; 3],
    /// Where it goes: of any length but 0, numbers up to 1e10.
    pub direction: [f64; 3],
}

/// Where a ray is inside a volume's box. The struct never grows: arrays of it are passed.
///
/// Dataset space is that of the volume's own axes, in mm: the box from 0 to dimensions × spacing, with spacing the distance of
/// neighbouring voxel centres. The centre of voxel i is at (i + 1/2) × spacing.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub struct DrrRaySample {
    /// Where the ray starts in dataset space, mm.
    pub origin: [f64; 3],
    /// Where it goes in dataset space; its length is 1.
    pub direction: [f64; 3],
    /// From the origin to where the ray enters, mm of dataset space; 0 where it starts inside.
    pub entry_mm: f64,
    /// From the origin to where it leaves, never less than `entry_mm`.
    pub exit_mm: f64,
    /// `entry_mm` in world mm: another number only where the volume's axes are not at right angles.
    pub world_entry_mm: f64,
    /// `exit_mm` in world mm.
    pub world_exit_mm: f64,
    /// Whether the ray meets the box. Where it does not, all other fields are 0.
    pub hit: DrrBool,
}

impl From<&Option<RaySample>> for DrrRaySample {
    fn from(sample: &Option<RaySample>) -> Self {
        sample.map_or_else(Self::default, |sample| Self {
            origin: sample.ray.origin.to_array(),
            direction: sample.ray.direction.to_array(),
            entry_mm: sample.entry,
            exit_mm: sample.exit,
            world_entry_mm: sample.world_entry,
            world_exit_mm: sample.world_exit,
            hit: DrrBool(1),
        })
    }
}

/// A pinhole camera in the world. Fill it with drr_camera_init, then set where it is and where it looks.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrCamera {
    /// Set by drr_camera_init.
    pub struct_size: usize,
    /// Where it is, mm, up to 1e10. Default 0.
    pub position: [f64; 3],
    /// Where it looks, such as target - position: of any length but 0, numbers up to 1e10. Default 0, 0, -1.
    pub forward: [f64; 3],
    /// What is up in its picture: as `forward`, and not along it: the sine of the angle between them is at least 1e-6. Default
    /// 0, 1, 0.
    pub up: [f64; 3],
    /// From the picture's lower edge to its upper one, degrees, above 0 and below 180. Default 60.
    pub vertical_field_of_view_degrees: f64,
    /// The picture's width over its height, 1e-6 to 1e6. Default 1.
    pub aspect: f64,
}

const CAMERA_SIZE: usize = size_of::<usize>() + size_of::<[f64; 11]>();

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl options::Options for DrrCamera {
    const SIZES: &'static [usize] = &[CAMERA_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            position: [0.0; 3],
            forward: [0.0, 0.0, -1.0],
            up: [0.0, 1.0, 0.0],
            vertical_field_of_view_degrees: 60.0,
            aspect: 1.0,
        }
    }
}

const _: () = assert!(size_of::<DrrCamera>() == CAMERA_SIZE);

impl From<DrrCamera> for Camera {
    fn from(camera: DrrCamera) -> Self {
        Self {
            position: camera.position.into(),
            forward: camera.forward.into(),
            up: camera.up.into(),
            vertical_field_of_view_degrees: camera.vertical_field_of_view_degrees,
            aspect: camera.aspect,
        }
    }
}

/// What rays meet in a volume: the spans of one view at a time, and the samples of one list of rays. Asked for the same again
/// it copies what it has; when anything has changed, it computes anew; when a call fails, it is left empty. Keeps its volume
/// and its context alive. Calls that change it: one at a time.
pub struct DrrRaycast {
    _opaque: [u8; 0],
}

/// What a cache's handle owns. A call takes the cache out while it works, so that no lock is held meanwhile.
pub(super) struct RaycastValue {
    cache: Mutex<Option<RayCache>>,
}

impl Opaque for DrrRaycast {
    type Value = RaycastValue;
    const MAGIC: u64 = u64::from_le_bytes(*b"drr rayc");
    const NAME: &'static str = "DrrRaycast";
}

/// Runs `work` with the cache, which is left empty when it fails.
///
/// # Safety
/// As for [`handle::borrow`].
pub(super) unsafe fn with_cache(
    raycast: *const DrrRaycast,
    work: impl FnOnce(&mut RayCache) -> Result<()>,
) -> Result<()> {
    // SAFETY: the caller's promise is the same.
    let value = unsafe { handle::borrow("raycast", raycast)? };
    let taken = value.cache.lock().unwrap_or_else(PoisonError::into_inner).take();
    let cache =
        taken.ok_or_else(|| Error::invalid("raycast", "in use by another call", "one call at a time"))?;
    let mut taken = Taken { from: &value.cache, cache: Some(cache), worked: false };
    taken.cache.as_mut().map_or(Ok(()), work)?;
    taken.worked = true;
    Ok(())
}

/// A cache that goes back to its handle, empty unless the work was done, also when it panics.
struct Taken<'a> {
    from: &'a Mutex<Option<RayCache>>,
    cache: Option<RayCache>,
    worked: bool,
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        if let (Some(cache), false) = (&mut self.cache, self.worked) {
            cache.clear();
        }
        *self.from.lock().unwrap_or_else(PoisonError::into_inner) = self.cache.take();
    }
}

/// Makes an empty cache for `volume`. On success `*raycast` is a new handle, to be given to drr_raycast_destroy; on failure
/// `*raycast` is left as it is. Fails with DRR_STATUS_INVALID_ARGUMENT. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_create(
    volume: *const DrrVolume,
    raycast: *mut *mut DrrRaycast,
) -> DrrStatus {
    guard(|| {
        memory::check("raycast", raycast, 1)?;
        // SAFETY: the C caller passes a handle that stays alive during the call.
        let volume = unsafe { handle::borrow("volume", volume)? };
        let made = RayCache::new(&volume.context, volume.volume.clone());
        // SAFETY: `raycast` is not null and aligned; the C caller passes a place for one handle.
        unsafe { raycast.write(handle::create(RaycastValue { cache: Mutex::new(Some(made)) })) };
        Ok(())
    })
}

/// Gives a cache up. NULL is nothing. As drr_context_destroy.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_destroy(raycast: *mut DrrRaycast) -> DrrStatus {
    // SAFETY: the C caller owns the handle and does not use it again.
    guard(|| unsafe { handle::destroy("raycast", raycast) })
}

/// Goes on with another volume: what the cache holds is forgotten, unless it is the same handle's. Its work is still done on
/// the threads of the context of the volume that it was made for. Fails with DRR_STATUS_INVALID_ARGUMENT. Any thread, one call
/// with a cache at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_set_volume(
    raycast: *mut DrrRaycast,
    volume: *const DrrVolume,
) -> DrrStatus {
    // SAFETY: the C caller passes handles that stay alive during the call.
    guard(|| unsafe {
        with_cache(raycast, |cache| {
            cache.set_volume(handle::borrow("volume", volume)?.volume.clone());
            Ok(())
        })
    })
}

/// Fills `*camera` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_camera_init(camera: *mut DrrCamera) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("camera", camera) })
}

/// Where the rays of a camera are inside the volume's box: samples[0] of the picture's centre, samples[1] to samples[4] of its
/// corners top left, top right, bottom left, bottom right.
///
/// A ray enters where it has come within all of the box's three slabs, but not before it starts, and leaves where it leaves the
/// first of them; along an axis on which its direction is 0 it is inside or outside by comparison. The box is closed: a touch
/// is a hit of length 0. `camera` is only read during the call; `samples` is a place for DRR_CAMERA_RAYS, written on success
/// only; on failure the cache is empty. Fails with DRR_STATUS_INVALID_ARGUMENT: no other direction stands in for one that is
/// not valid. Any thread, one call with a cache at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_cast_camera(
    raycast: *mut DrrRaycast,
    camera: *const DrrCamera,
    samples: *mut DrrRaySample,
) -> DrrStatus {
    // SAFETY: the C caller passes a handle that stays alive during the call, and a struct of the size that it says.
    guard(|| unsafe {
        with_cache(raycast, |cache| {
            memory::check("samples", samples, DRR_CAMERA_RAYS)?;
            let camera = options::read("camera", camera)?;
            // SAFETY: checked above; the C caller passes a place for as many samples as a camera has rays.
            write(samples, cache.cast_camera(&camera.into())?)
        })
    })
}

/// Where `ray_count` rays, 1 to DRR_MAX_RAYS, are inside the volume's box: samples[i] is of rays[i], also of one that misses.
///
/// `rays` are only read during the call; `samples` is a place for `ray_count`. Fails with DRR_STATUS_OUT_OF_MEMORY, too.
/// Otherwise as drr_raycast_cast_camera.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_cast(
    raycast: *mut DrrRaycast,
    rays: *const DrrWorldRay,
    ray_count: usize,
    samples: *mut DrrRaySample,
) -> DrrStatus {
    // SAFETY: the C caller passes a handle that stays alive during the call, and `ray_count` rays.
    guard(|| unsafe {
        with_cache(raycast, |cache| {
            if !(1..=DRR_MAX_RAYS).contains(&ray_count) {
                return Err(Error::invalid("ray_count", ray_count, format!("1 … {DRR_MAX_RAYS}")));
            }
            memory::check("samples", samples, ray_count)?;
            let given = memory::read_array("rays", rays, ray_count)?;
            let mut rays = reserved(ray_count, "the rays")?;
            for (n, ray) in given.iter().enumerate() {
                let ray = WorldRay::new(ray.origin.into(), ray.direction.into());
                rays.push(ray.map_err(|error| error.of(&format!("rays[{n}]")))?);
            }
            // SAFETY: checked above; the C caller passes a place for one sample per ray.
            write(samples, cache.cast(&rays)?)
        })
    })
}

/// # Safety
/// As for [`memory::write_array`], of as many samples.
unsafe fn write(place: *mut DrrRaySample, samples: &[Option<RaySample>]) -> Result<()> {
    let mut made = reserved(samples.len(), "the samples")?;
    made.extend(samples.iter().map(DrrRaySample::from));
    // SAFETY: the caller's promise is the same.
    unsafe { memory::write_array(place, &made) };
    Ok(())
}
