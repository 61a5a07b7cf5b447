//! Where the rays of one view meet anything.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::error::Result;
use crate::geometry::{Grid, View};
use crate::raycast::lines::Lines;
use crate::raycast::tighten::REACH;
use crate::raycast::{Beam, Ray};
use crate::volume::{Matter, Occupied};

/// The part of a pixel's ray that can meet what counts, world mm along the ray: from the source on, or, in a parallel beam,
/// from the ray's point that is nearest to the volume's centre, negative before it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RaySpan {
    /// Where it begins; 0 of a ray that meets nothing.
    pub entry_mm: f64,
    /// Where it ends, beyond `entry_mm`; 0 of a ray that meets nothing.
    pub exit_mm: f64,
    /// Length inside the volume's box that is not part of it: nothing there counts.
    pub skipped_mm: f64,
}

impl RaySpan {
    /// Its length; 0 of a ray that meets nothing.
    pub fn length_mm(&self) -> f64 {
        self.exit_mm - self.entry_mm
    }
}

/// Spans of all rays of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewSpans {
    size: [usize; 2],
    matter: Matter,
    spans: Vec<RaySpan>,
}

impl ViewSpans {
    /// Of the rays through the pixels' centres of a detector of `size` = width × height pixels.
    ///
    /// # Errors
    /// `InvalidArgument` for a view that is not valid; `OutOfMemory`.
    pub(super) fn new(
        view: &View,
        grid: &Grid,
        size: [usize; 2],
        matter: Matter,
        occupied: &Occupied,
    ) -> Result<Self> {
        let beam = Beam::new(view, grid, size)?;
        let mut spans = filled(size[0] * size[1], RaySpan::default(), "the spans of a view's rays")?;
        let full = occupied.is_full();
        let along = Along { lines: beam.lines(), grid };
        spans.par_chunks_mut(size[0]).enumerate().for_each(|(row, spans)| {
            for (column, span) in spans.iter_mut().enumerate() {
                let (column, row) = (column as f64, row as f64);
                let ray = beam.ray(column, row);
                let Some(inside) = ray.clip(grid.dimensions()) else { continue };
                let met = if full { Some(inside) } else { occupied.tighten(&ray, inside, REACH) };
                let inside_mm = (inside.leave - inside.enter) * ray.mm_per_slice;
                *span = met.map_or_else(RaySpan::default, |met| {
                    let [entry_mm, exit_mm] = along.distances(&ray, column, row, [met.enter, met.leave]);
                    RaySpan { entry_mm, exit_mm, skipped_mm: 0.0 }
                });
                let met_mm = met.map_or(0.0, |met| (met.leave - met.enter) * ray.mm_per_slice);
                span.skipped_mm = inside_mm - met_mm;
            }
        });
        Ok(Self { size, matter, spans })
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// What counts.
    pub fn matter(&self) -> Matter {
        self.matter
    }

    /// By pixel: that of pixel (i, j), i = column, is at `j*width + i`.
    pub fn spans(&self) -> &[RaySpan] {
        &self.spans
    }

    /// Rays that meet anything.
    pub fn hits(&self) -> usize {
        self.spans.iter().filter(|span| span.length_mm() > 0.0).count()
    }

    /// What a ray loses at most when only its span is looked at, g/cm²: the floor times what is skipped, of the ray of which
    /// most is. 0 without a floor.
    pub fn largest_loss(&self) -> f64 {
        self.matter.lost(self.spans.iter().fold(0.0, |most, span| span.skipped_mm.max(most)))
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.spans[..])
    }
}

/// From where distances along a view's rays are measured, and in what direction.
struct Along<'a> {
    lines: Lines,
    grid: &'a Grid,
}

impl Along<'_> {
    /// Distances of two places on the ray of a pixel, the nearer one first.
    fn distances(&self, ray: &Ray, column: f64, row: f64, [a, b]: [f64; 2]) -> [f64; 2] {
        let direction = self.lines.direction.at(column, row)[ray.axis];
        let zero = self.lines.source.map_or_else(|| self.nearest(ray), |source| source[ray.axis]);
        // A zero of either sign is 0.
        let mm = |s: f64| (s - zero) * ray.mm_per_slice.copysign(direction) + 0.0;
        if direction > 0.0 { [mm(a), mm(b)] } else { [mm(b), mm(a)] }
    }

    /// The place of the ray that is nearest to the volume's centre in the world.
    fn nearest(&self, ray: &Ray) -> f64 {
        let world = |s: f64| self.grid.index_to_world().transform_point3(ray.point(s).into());
        let crossing = world(ray.centre);
        let step = self.grid.index_to_world().transform_vector3(ray.step());
        ray.centre - (crossing - self.grid.centre()).dot(step) / step.length_squared()
    }
}
