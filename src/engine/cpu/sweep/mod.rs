//! Joseph's method slice by slice: what a band of rays reads of a slice is decoded once, and all rays of the band cross it side
//! by side. Its plain twin is the march of tiles, ray by ray.

mod axes;
mod bundle;
mod columns;
mod densities;
mod gather;
mod part;
mod planes;
mod slab;
mod spans;
mod sums;

use rayon::prelude::*;

use crate::engine::Progress;
use crate::engine::cpu::level::{Kind, LANES};
use crate::engine::cpu::path::ROUND;
use crate::error::Result;
use crate::geometry::Grid;
use crate::method::{Accumulation, Algorithm, Method, Storage};
use crate::raycast::ray::TRANSVERSE;
use crate::raycast::{Beam, Ray};
use crate::volume::{Volume, Voxels};
use columns::Columns;
use densities::Densities;
use gather::Gather;
pub(super) use part::{Met, Part, RayGrid};
use planes::Planes;
use slab::Codes;

/// The largest whole number that is not above x. |x| < 2²².
#[inline(always)]
fn floor(x: f32) -> f32 {
    let near = (x + ROUND) - ROUND;
    if near > x { near - 1.0 } else { near }
}

/// A whole number as an integer. |x| < 2²².
#[inline(always)]
fn integer(x: f32) -> i32 {
    (x + ROUND).to_bits().wrapping_sub(ROUND.to_bits()).cast_signed()
}

/// What float32 may move places by, voxels, and more.
const MARGIN: f64 = 1e-3;
/// Smallest detectors that are swept, pixels: fewer share too little.
const SMALLEST: [usize; 2] = [LANES, 8];
/// Places in a slice are counted in float32, [`integer`]s.
const LARGEST: usize = 1 << 22;
/// Most voxels of a slice per ray: more are too many to decode for those that are read.
const SPARSEST: f64 = 16.0;
/// Most views that share what is decoded.
const TOGETHER: usize = 2;
/// Most views that are made ready at a time: a multiple of those that share.
const AT_A_TIME: usize = 64;
/// Most rays that are reported at once.
const REPORTED: usize = 1024;
/// Most blocks of a part whose rays gather: the slices that it decodes at a time fit the second-level cache.
const GATHERED: usize = 12;
/// Rows of a part, more where there is work enough for all threads.
const ROWS: [usize; 2] = [16, 32];

/// A volume and method that can be swept.
pub(super) struct Sweep {
    /// By accumulator.
    densities: Vec<Densities>,
    /// Which accumulators a brick's labels are.
    accumulators: Box<[u8; 256]>,
}

/// What is the same for all views that are cast.
pub(super) struct Cast<'a> {
    pub level: Kind,
    pub volume: &'a Volume,
    pub rays: RayGrid,
    pub progress: &'a Progress<'a>,
}

/// Views that are swept together.
struct Group {
    /// Their places in the list of views.
    views: Vec<usize>,
    /// By view; none where rays gather.
    columns: Vec<Columns>,
}

impl Sweep {
    /// Whether rays of a method are swept at all, where that pays.
    pub(super) fn has(volume: &Volume, labels: &[u8], method: &Method) -> bool {
        let plain = (method.algorithm, method.accumulation, method.storage);
        plain == (Algorithm::Joseph, Accumulation::Blocked, Storage::Exact)
            && matches!(volume.voxels(), Voxels::Coded { .. })
            && !labels.is_empty()
    }

    /// `None` where lines do not describe what codes mean.
    pub(super) fn new(volume: &Volume, labels: &[u8]) -> Option<Self> {
        let meanings: Vec<_> = (0..=u16::MAX).map(|code| volume.meaning(code)).collect();
        let densities = Densities::of(&meanings, labels)?;
        let accumulator = |byte: usize| {
            let holds = |&(_, &label): &(usize, &u8)| byte >> label & 1 != 0;
            labels.iter().enumerate().filter(holds).fold(0, |all, (lane, _)| all | 1 << lane)
        };
        let accumulators = Box::new(std::array::from_fn(accumulator));
        Some(Self { densities, accumulators })
    }

    /// Whether neighbouring rays share most of what they read.
    pub(super) fn pays(beam: &Beam, size: [usize; 2]) -> bool {
        let [n0, n1, n2] = beam.dimensions().map(|n| n + 4 * LANES);
        if size[0] < SMALLEST[0] || size[1] < SMALLEST[1] || n0.max(n1) * n1.max(n2) > LARGEST {
            return false;
        }
        let [i, j] = size.map(|side| (0.5 * (side as f64 - 1.0)).floor());
        let ray = beam.ray(i, j);
        let step = |other: Ray| {
            TRANSVERSE[ray.axis].map(|axis| other.point(ray.centre)[axis] - ray.point(ray.centre)[axis])
        };
        let (a, b) = (step(beam.ray(i + 1.0, j)), step(beam.ray(i, j + 1.0)));
        (a[0] * b[1] - a[1] * b[0]).abs() <= SPARSEST
    }

    /// Sweeps views, which `finish` is told of part by part, from any thread.
    pub(super) fn project(
        &self,
        Cast { level, volume, rays, progress }: Cast<'_>,
        views: &[(usize, Beam)],
        finish: &(dyn Fn(usize, &Beam, &Part, &Met) -> Result<()> + Sync),
    ) -> Result<()> {
        let Voxels::Coded { codes, .. } = volume.voxels() else { unreachable!("looked at when it was made") };
        let occupancy = volume.occupancy()?;
        let codes = Codes {
            voxels: codes,
            dimensions: volume.grid().dimensions(),
            densities: &self.densities,
            labels: occupancy.all_labels(),
            accumulators: &self.accumulators,
        };
        // So many at a time that their columns are few beside their images.
        views.chunks(AT_A_TIME).try_for_each(|views| {
            let groups = groups(views, volume.grid(), rays.size);
            let depth = codes.dimensions.into_iter().min().unwrap_or(1);
            let parts = |group: &Group| {
                let widest = if group.columns.is_empty() { GATHERED } else { usize::MAX };
                Part::all(rays, group.views.len(), groups.len(), depth, widest)
            };
            let parts: Vec<_> =
                groups.iter().flat_map(|group| parts(group).map(move |part| (group, part))).collect();
            parts.par_iter().try_for_each(|(group, part)| {
                let finished = |rays| progress.finished(rays);
                let met = if group.columns.is_empty() {
                    let beams: Vec<_> = group.views.iter().map(|&n| &views[n].1).collect();
                    self.gather(level, codes, &beams, (rays.size[0], part), &finished)?
                } else {
                    level.dispatch(Planes { codes, views: &group.columns, part, finished: &finished })?
                };
                group.views.iter().zip(&met).try_for_each(|(&n, met)| {
                    let (view, beam) = &views[n];
                    finish(*view, beam, part, met)
                })
            })
        })
    }

    /// One driving axis after the other, of those that rays of the part have.
    fn gather(
        &self,
        level: Kind,
        codes: Codes<'_>,
        beams: &[&Beam],
        (width, part): (usize, &Part),
        finished: &dyn Fn(usize) -> Result<()>,
    ) -> Result<Vec<Met>> {
        let mut met: Vec<_> = beams.iter().map(|_| Met::nothing(part, self.densities.len())).collect();
        let driving = Gather::driving(beams, width, part);
        for (n, axis) in driving.into_iter().enumerate() {
            // Rays are reported by the first axis; the others only ask whether to go on.
            let share = |rays: usize| finished(if n == 0 { rays } else { 0 });
            let gather = Gather { codes, beams, width, axes: axis.into(), part, finished: &share };
            for (met, more) in met.iter_mut().zip(&level.dispatch(gather)?) {
                met.add(more);
            }
        }
        Ok(met)
    }
}

/// Neighbouring views are swept together when they are of planes along the same axes, or all gather.
fn groups(views: &[(usize, Beam)], grid: &Grid, size: [usize; 2]) -> Vec<Group> {
    let columns: Vec<_> = views.par_iter().map(|(_, beam)| Columns::of(beam, grid, size)).collect();
    let mut groups: Vec<Group> = Vec::new();
    for (n, columns) in columns.into_iter().enumerate() {
        match groups.last_mut() {
            Some(group) if group.takes(columns.as_ref()) => {
                group.views.push(n);
                group.columns.extend(columns);
            }
            _ => groups.push(Group { views: vec![n], columns: columns.into_iter().collect() }),
        }
    }
    groups
}

impl Group {
    fn takes(&self, columns: Option<&Columns>) -> bool {
        let axes = |columns: &Columns| columns.axes;
        self.views.len() < TOGETHER && self.columns.first().map(axes) == columns.map(axes)
    }
}

#[cfg(test)]
mod tests;
