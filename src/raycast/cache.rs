//! What the rays of a view or of a camera meet, kept until something changes.

use std::sync::Arc;

use crate::allocation::collected;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::geometry::View;
use crate::raycast::{Camera, DatasetSpace, RaySample, ViewSpans, WorldRay};
use crate::scene::MAX_DETECTOR;
use crate::volume::{Matter, Volume};

/// Where rays enter a volume, and where they leave what counts in it: for one view at a time, and for one list of rays.
/// Both are computed when they are asked for and anything has changed since they were: the volume, the view, the detector,
/// what counts; the rays. Whatever fails leaves the cache empty.
pub struct RayCache {
    context: Context,
    volume: Arc<Volume>,
    view: Option<(ViewKey, ViewSpans)>,
    list: Option<(Vec<WorldRay>, Vec<Option<RaySample>>)>,
    computed: Computed,
}

/// How often a cache has computed what it holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Computed {
    /// Spans of a view.
    pub views: u64,
    /// Samples of a list of rays.
    pub lists: u64,
}

/// All that the spans of a view depend on, beside the volume, which never changes.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ViewKey {
    view: View,
    size: [usize; 2],
    matter: Matter,
}

impl RayCache {
    /// An empty one, whose work is done on the threads of `context`.
    pub fn new(context: &Context, volume: Arc<Volume>) -> Self {
        Self { context: context.clone(), volume, view: None, list: None, computed: Computed::default() }
    }

    /// The volume.
    pub fn volume(&self) -> &Arc<Volume> {
        &self.volume
    }

    /// Another volume; the cache is then empty, unless it is the same one.
    pub fn set_volume(&mut self, volume: Arc<Volume>) {
        if !Arc::ptr_eq(&self.volume, &volume) {
            self.clear();
            self.volume = volume;
        }
    }

    /// Forgets what it holds.
    pub fn clear(&mut self) {
        self.view = None;
        self.list = None;
    }

    /// How often it has computed anything.
    pub fn computed(&self) -> Computed {
        self.computed
    }

    /// The spans of the last view; `None` when there is none.
    pub fn view(&self) -> Option<&ViewSpans> {
        self.view.as_ref().map(|(_, spans)| spans)
    }

    /// The samples of the last rays, in their order; `None` when there are none.
    pub fn samples(&self) -> Option<&[Option<RaySample>]> {
        self.list.as_ref().map(|(_, samples)| &samples[..])
    }

    /// Where the rays of all pixels of `view` meet matter that counts, on a detector of `size` = width × height pixels.
    ///
    /// # Errors
    /// `InvalidArgument` for a view that is not valid, or sides of 0 or above 32768 pixels; `Unsupported` for a volume in a
    /// texture; `OutOfMemory`. The cache is then empty.
    pub fn update(&mut self, view: &View, size: [usize; 2], matter: Matter) -> Result<&ViewSpans> {
        let key = ViewKey { view: without_idle_source(view), size, matter };
        let kept = self.view.take().filter(|(made_for, _)| *made_for == key);
        let spans = match kept {
            Some((_, spans)) => spans,
            None => self.spans(&key).inspect_err(|_| self.clear())?,
        };
        Ok(&self.view.insert((key, spans)).1)
    }

    fn spans(&mut self, key: &ViewKey) -> Result<ViewSpans> {
        for (name, n) in ["width", "height"].into_iter().zip(key.size) {
            if !(1..=MAX_DETECTOR).contains(&n) {
                return Err(Error::invalid(name, n, format!("1 … {MAX_DETECTOR} pixels")));
            }
        }
        let (volume, grid) = (&self.volume, self.volume.grid());
        let made = self.context.install(|| {
            let occupied = volume.occupancy()?.of(key.matter)?;
            ViewSpans::new(&key.view, grid, key.size, key.matter, &occupied).map_err(|error| error.of("view"))
        })?;
        self.computed.views += 1;
        Ok(made)
    }

    /// Where rays are inside the volume's box: one sample for each, in their order; `None` for those that miss.
    ///
    /// # Errors
    /// `OutOfMemory`. The cache is then empty.
    pub fn cast(&mut self, rays: &[WorldRay]) -> Result<&[Option<RaySample>]> {
        let kept = self.list.take().filter(|(made_for, _)| made_for == rays);
        let list = match kept {
            Some(list) => list,
            None => self.sampled(rays).inspect_err(|_| self.clear())?,
        };
        Ok(&self.list.insert(list).1)
    }

    /// As [`RayCache::cast`], of the rays of a camera: centre, top left, top right, bottom left, bottom right.
    ///
    /// # Errors
    /// As [`Camera::rays`]. The cache is then empty.
    pub fn cast_camera(&mut self, camera: &Camera) -> Result<&[Option<RaySample>]> {
        let rays = camera.rays().inspect_err(|_| self.clear())?;
        self.cast(&rays)
    }

    fn sampled(&mut self, rays: &[WorldRay]) -> Result<(Vec<WorldRay>, Vec<Option<RaySample>>)> {
        let space = DatasetSpace::new(self.volume.grid());
        let what = "rays and their samples";
        let samples = collected(rays.iter().map(|ray| space.cast(ray)), what)?;
        self.computed.lists += 1;
        Ok((collected(rays.iter().copied(), what)?, samples))
    }
}

/// The view, without the source of a parallel beam: it is not read and may be NaN, which equals nothing.
fn without_idle_source(view: &View) -> View {
    let mut view = *view;
    if let View::Projection(projection) = &mut view
        && projection.is_parallel()
    {
        projection.source = glam::DVec3::ZERO;
    }
    view
}

#[cfg(test)]
mod tests;
