//! Where the rays of a view meet matter that counts.

use crate::allocation::reserved;
use crate::capi::boundary::guard;
use crate::capi::geometry::DrrDetectorPose;
use crate::capi::raycast::{DrrRaycast, with_cache};
use crate::capi::status::DrrStatus;
use crate::capi::{memory, options};
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::raycast::{RaySpan, ViewSpans};
use crate::shared::ProjectionUniforms;
use crate::volume::Matter;

/// Which matter of a volume counts. Fill it with drr_matter_init, which makes all count but vacuum.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrMatter {
    /// Set by drr_matter_init.
    pub struct_size: usize,
    /// Density, g/cm³, 0 to 1000, up to which matter need not count: where nothing of 8 × 8 × 8 voxels is denser, they are
    /// passed over. What a ray loses by that is at most the floor times the length of what is skipped. Default 0: only vacuum
    /// is passed over.
    pub floor: f64,
    /// Bit m stands for the matter with label m. Default 255: all of it.
    pub labels: u32,
    /// Not read.
    _padding: u32,
}

const MATTER_SIZE: usize = size_of::<usize>() + 16;

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl options::Options for DrrMatter {
    const SIZES: &'static [usize] = &[MATTER_SIZE];
    fn defaults() -> Self {
        Self { struct_size: size_of::<Self>(), floor: 0.0, labels: u32::from(u8::MAX), _padding: 0 }
    }
}

const _: () = assert!(size_of::<DrrMatter>() == MATTER_SIZE);

impl DrrMatter {
    fn read(&self) -> Result<Matter> {
        let labels = u8::try_from(self.labels)
            .map_err(|_| Error::invalid("matter.labels", self.labels, "0 … 255, a bit for each label"))?;
        Matter::new(labels, self.floor).map_err(|error| error.of("matter"))
    }
}

/// The part of a pixel's ray outside of which nothing counts, world mm along the ray: from the source on, or, in a parallel
/// beam, from the ray's point that is nearest to the volume's centre, negative before it. Of a ray that meets nothing, 0 and
/// 0. The struct never grows: arrays of it are passed.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrRaySpan {
    /// Where it begins.
    pub entry_mm: f64,
    /// Where it ends.
    pub exit_mm: f64,
    /// Length inside the volume's box that is not part of it.
    pub skipped_mm: f64,
}

impl From<&RaySpan> for DrrRaySpan {
    fn from(span: &RaySpan) -> Self {
        Self { entry_mm: span.entry_mm, exit_mm: span.exit_mm, skipped_mm: span.skipped_mm }
    }
}

/// What a cache has done, and what it holds of the last view. Fill it with drr_raycast_statistics_init, hand it to
/// drr_raycast_statistics.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct DrrRaycastStatistics {
    /// Set by drr_raycast_statistics_init.
    pub struct_size: usize,
    /// How often spans of a view have been computed.
    pub views_computed: u64,
    /// How often samples of rays have been computed.
    pub lists_computed: u64,
    /// Rays of the view; 0 when the cache holds none.
    pub rays: usize,
    /// Those that meet anything.
    pub hits: usize,
    /// Length of all spans, mm.
    pub span_mm: f64,
    /// Length that is skipped of all rays, mm.
    pub skipped_mm: f64,
    /// What a ray loses at most when only its span is looked at, g/cm²: the floor times what is skipped.
    pub largest_loss: f64,
}

const STATISTICS_SIZE: usize = size_of::<[usize; 3]>() + 40;

// SAFETY: repr(C), no padding (asserted), starts with its size, numbers only.
unsafe impl options::Options for DrrRaycastStatistics {
    const SIZES: &'static [usize] = &[STATISTICS_SIZE];
    fn defaults() -> Self {
        Self {
            struct_size: size_of::<Self>(),
            views_computed: 0,
            lists_computed: 0,
            rays: 0,
            hits: 0,
            span_mm: 0.0,
            skipped_mm: 0.0,
            largest_loss: 0.0,
        }
    }
}

const _: () = assert!(size_of::<DrrRaycastStatistics>() == STATISTICS_SIZE);

/// Fills `*matter` with the defaults and its size. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_matter_init(matter: *mut DrrMatter) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("matter", matter) })
}

/// Where the rays of a view that is given by a projection matrix meet matter that counts, for a detector of `width` × `height`
/// pixels, each 1 to 32768: that of pixel (i, j), i = column, is spans[j × width + i].
///
/// A span is never too short: every voxel that counts and that any of the algorithms could read lies within; its ends are up to
/// 3 voxels from a block of 8 × 8 × 8 voxels with matter that counts. When nothing has changed since the last view, the
/// spans are copied. The uniforms' tables and enableEarlyExit are not read.
///
/// `uniforms` and `matter` are only read during the call; `spans` is written on success only; on failure the cache is empty.
/// Fails with DRR_STATUS_INVALID_ARGUMENT, DRR_STATUS_OUT_OF_MEMORY, or DRR_STATUS_UNSUPPORTED for a volume in a texture. Any
/// thread, one call with a cache at a time. The same call gives the same bytes for any number of threads.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_update(
    raycast: *mut DrrRaycast,
    uniforms: *const ProjectionUniforms,
    width: usize,
    height: usize,
    matter: *const DrrMatter,
    spans: *mut DrrRaySpan,
) -> DrrStatus {
    let view = |uniforms: &ProjectionUniforms| View::Projection(uniforms.into());
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { update(raycast, ("uniforms", uniforms), view, [width, height], matter, spans) })
}

/// As drr_raycast_update, of a view that is given by source and detector in float64. Rays end at their pixels: what lies behind
/// is neither in a span nor skipped.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_update_pose(
    raycast: *mut DrrRaycast,
    pose: *const DrrDetectorPose,
    width: usize,
    height: usize,
    matter: *const DrrMatter,
    spans: *mut DrrRaySpan,
) -> DrrStatus {
    let view = |pose: &DrrDetectorPose| View::Pose(pose.into());
    // SAFETY: the C caller's promises are the same.
    guard(|| unsafe { update(raycast, ("pose", pose), view, [width, height], matter, spans) })
}

/// # Safety
/// The pointers are as [`drr_raycast_update`] says.
unsafe fn update<V: Copy>(
    raycast: *mut DrrRaycast,
    (argument, given): (&str, *const V),
    view: impl FnOnce(&V) -> View,
    size: [usize; 2],
    matter: *const DrrMatter,
    place: *mut DrrRaySpan,
) -> Result<()> {
    let work = |cache: &mut crate::raycast::RayCache| {
        // SAFETY: the C caller passes one view, and a struct of the size that it says.
        let (view, matter) = unsafe {
            (view(&memory::read_array(argument, given, 1)?[0]), options::read("matter", matter)?.read()?)
        };
        memory::check("spans", place, 1)?;
        let made = cache.update(&view, size, matter).map_err(|error| error.called("view", argument))?;
        let mut spans = reserved(made.spans().len(), "the spans")?;
        spans.extend(made.spans().iter().map(DrrRaySpan::from));
        // SAFETY: not null, aligned; the C caller passes a place for one span per pixel.
        unsafe { memory::write_array(place, &spans) };
        Ok(())
    };
    // SAFETY: the C caller passes a handle that stays alive during the call.
    unsafe { with_cache(raycast, work) }
}

/// Fills `*statistics` with its size and zeros. Fails for NULL. Any thread.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_statistics_init(statistics: *mut DrrRaycastStatistics) -> DrrStatus {
    // SAFETY: the C caller passes a place for one struct.
    guard(|| unsafe { options::init("statistics", statistics) })
}

/// What a cache has done and holds. Writes `*statistics`, which drr_raycast_statistics_init has filled, on success only. Fails
/// with DRR_STATUS_INVALID_ARGUMENT. Any thread, one call with a cache at a time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn drr_raycast_statistics(
    raycast: *mut DrrRaycast,
    statistics: *mut DrrRaycastStatistics,
) -> DrrStatus {
    guard(|| {
        let sum = |view: &ViewSpans, part: fn(&RaySpan) -> f64| view.spans().iter().map(part).sum::<f64>();
        // SAFETY: the C caller passes a handle that stays alive during the call, and a struct of the size that it says.
        unsafe {
            with_cache(raycast, |cache| {
                options::read("statistics", statistics)?;
                let (computed, view) = (cache.computed(), cache.view());
                let made = DrrRaycastStatistics {
                    struct_size: size_of::<DrrRaycastStatistics>(),
                    views_computed: computed.views,
                    lists_computed: computed.lists,
                    rays: view.map_or(0, |view| view.spans().len()),
                    hits: view.map_or(0, ViewSpans::hits),
                    span_mm: view.map_or(0.0, |view| sum(view, RaySpan::length_mm)),
                    skipped_mm: view.map_or(0.0, |view| sum(view, |span| span.skipped_mm)),
                    largest_loss: view.map_or(0.0, ViewSpans::largest_loss),
                };
                // SAFETY: `read` has seen that there is a struct of today's size.
                statistics.write(made);
                Ok(())
            })
        }
    })
}
