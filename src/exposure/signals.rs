//! The signals of all rays of a view.

use rayon::prelude::*;

use crate::effects::Plane;
use crate::error::Result;
use crate::exposure::channels::{Channels, Scratch};
use crate::exposure::rows::rows_of;
use crate::exposure::source::Source;
use crate::exposure::{Sample, Shot};

/// Images of one number per ray.
pub(super) struct Signals {
    /// One plane per sum of the channels.
    pub(super) planes: Vec<Plane>,
    /// The same of the open field, without the volume, where it was asked for.
    pub(super) open: Vec<Plane>,
}

impl Signals {
    /// Zeros, of so many sums.
    pub(super) fn zeroed(size: [usize; 2], sums: usize, open: bool) -> Result<Self> {
        let planes =
            |count: usize| -> Result<Vec<Plane>> { (0..count).map(|_| Plane::filled(size, 0.0)).collect() };
        Ok(Self { planes: planes(sums)?, open: planes(if open { sums } else { 0 })? })
    }

    /// The same row of every plane, those of the open field last, row by row.
    pub(super) fn rows(&mut self) -> Vec<Vec<&mut [f64]>> {
        let size = self.planes[0].size();
        rows_of(self.planes.iter_mut().chain(&mut self.open).map(Plane::values_mut), size)
    }

    /// Changes every plane.
    pub(super) fn change(&mut self, to: impl Fn(&Plane) -> Result<Plane>) -> Result<()> {
        for plane in self.planes.iter_mut().chain(&mut self.open) {
            *plane = to(plane)?;
        }
        Ok(())
    }
}

/// The signals of a shot's rays, averaged over the focal spot; `open`: and those of the same rays without the volume.
pub(super) fn signals<T: Sample>(
    shot: &Shot<T>,
    source: &Source<'_>,
    channels: &Channels,
    open: bool,
) -> Result<Signals> {
    let size = shot.size();
    let sums = channels.count();
    let mut signals = Signals::zeroed(size, sums, open)?;
    signals.rows().into_par_iter().enumerate().for_each(|(row, mut planes)| {
        let mut ray = RaySignals::new(channels, T::EXACT);
        let (behind, before) = planes.split_at_mut(sums);
        for column in 0..size[0] {
            ray.add(shot, source, [column, row], behind, before);
        }
    });
    Ok(signals)
}

/// The sums of one ray after the other.
struct RaySignals<'a> {
    channels: &'a Channels,
    exact: bool,
    scratch: Scratch,
    /// g/cm²: the scene's materials, then what lies before the volume.
    areal_density: Vec<f64>,
    sums: Vec<f64>,
}

impl<'a> RaySignals<'a> {
    fn new(channels: &'a Channels, exact: bool) -> Self {
        let (areal_density, sums) = (vec![0.0; channels.materials()], vec![0.0; channels.count()]);
        Self { channels, exact, scratch: Scratch::default(), areal_density, sums }
    }

    /// Writes the sums behind the volume and, where there is a place for them, before it.
    fn add<T: Sample>(
        &mut self,
        shot: &Shot<T>,
        source: &Source<'_>,
        [column, row]: [usize; 2],
        behind: &mut [&mut [f64]],
        open: &mut [&mut [f64]],
    ) {
        let (images, materials) = (&shot.images, shot.images.materials);
        let ray = row * images.size[0] + column;
        let factor = source.towards(column as f64, row as f64, &mut self.areal_density[materials..]);
        for (point, part) in shot.parts.iter().enumerate() {
            for m in 0..materials {
                self.areal_density[m] = images.areal_density(point, m)[ray].into();
            }
            self.pass();
            behind.iter_mut().zip(&self.sums).for_each(|(to, sum)| to[column] += part * factor * sum);
        }
        if !open.is_empty() {
            self.areal_density[..materials].fill(0.0);
            self.pass();
            open.iter_mut().zip(&self.sums).for_each(|(to, sum)| to[column] = factor * sum);
        }
    }

    fn pass(&mut self) {
        if self.exact {
            self.channels.exact(&self.areal_density, &mut self.sums);
        } else {
            self.channels.fast(&self.areal_density, &mut self.scratch, &mut self.sums);
        }
    }
}
