//! From areal densities to images, view by view and stage by stage: energies, focal spot, scatter, detector blur, pixels, noise.

use rayon::prelude::*;

use crate::effects::{FillFactor, FocalSpot, Noise, Plane, ScatterKernels, Sights, convolved};
use crate::engine::{Images, Layers};
use crate::error::Result;
use crate::exposure::channels::{Channels, mean_gain};
use crate::exposure::passed::signals_of;
use crate::exposure::signals::{Signals, signals};
use crate::exposure::sums::Sums;
use crate::exposure::times::StageTimes;
use crate::exposure::{Exposure, Focus, Sample, Shot};
use crate::scene::Scene;

/// What is made of an exposure.
pub(super) struct Development<'a> {
    scene: &'a Scene,
    layers: Layers,
    times: StageTimes,
}

impl<'a> Development<'a> {
    pub(super) fn new(scene: &'a Scene, layers: Layers) -> Self {
        Self { scene, layers, times: StageTimes::default() }
    }

    /// The images of all views, and what the stages took.
    pub(super) fn images<T: Sample>(self, exposure: &Exposure<T>) -> Result<(Images<T>, StageTimes)> {
        let materials = self.scene.materials.names().len();
        let (size, views) = (self.scene.detector, exposure.views());
        let mut images = Images::of_layers(size, views, materials, self.scene.layers(), self.layers)?;
        for (v, shot) in exposure.shots.iter().enumerate() {
            self.paths(shot, v, &mut images)?;
            if self.layers.intensity || self.layers.line_integral {
                self.signal(exposure, shot, v, &mut images)?;
            }
        }
        Ok((images, self.times))
    }

    /// Areal densities and bone path of the pixels: means over their rays and over the focal spot.
    fn paths<T: Sample>(&self, shot: &Shot<T>, view: usize, images: &mut Images<T>) -> Result<()> {
        let (materials, n) = (images.materials, self.scene.supersampling);
        for m in 0..if self.layers.areal_density { materials } else { 0 } {
            let mean = FillFactor::FULL.collected(&shot.areal_density(m)?, n)?;
            put(&mut images.areal_density, view * materials + m, &mean);
        }
        if self.layers.bone_path {
            let mean = FillFactor::FULL.collected(&shot.bone_path()?, n)?;
            put(&mut images.bone_path, view, &mean);
        }
        Ok(())
    }

    /// Intensities and line integrals of a view, in the order in which a photon meets the effects.
    fn signal<T: Sample>(
        &self,
        exposure: &Exposure<T>,
        shot: &Shot<T>,
        place: usize,
        images: &mut Images<T>,
    ) -> Result<()> {
        let effects = &self.scene.effects;
        let sums = Sums::new(self.scene, &shot.view, shot.size(), self.layers)?;
        let mut rays = self.times.of("energies", || match &shot.passed {
            Some(passed) => signals_of(shot, passed, &sums),
            None => signals(shot, &sums.source, &sums.channels, sums.open),
        })?;
        let channels = &sums.channels;
        if let Some(spot) = effects.focal_spot.filter(|_| exposure.focus == Focus::Convolved) {
            self.times.of("focal spot", || convolve(spot, shot, &mut rays))?;
        }
        if let Some(scatter) = effects.scatter {
            let beamline = shot.beamline("scene.effects.scatter")?;
            let kernels = self.times.of("scatter kernels", || {
                let cache = exposure.context.scatter();
                cache.get_or_make(
                    scatter,
                    &sums.source.filtered(&self.scene.spectrum)?,
                    channels.responses(),
                    beamline,
                )
            })?;
            self.times.of("scatter", || add_scatter(&kernels, shot, &mut rays))?;
        }
        if let Some(blur) = &effects.detector_blur {
            let pitch = shot.pitch("scene.effects.detector_blur")?;
            self.times.of("detector blur", || rays.change(|plane| blur.applied(plane, pitch)))?;
        }
        let fill = effects.fill_factor.unwrap_or(FillFactor::FULL);
        let n = self.scene.supersampling;
        if n > 1 || effects.fill_factor.is_some() {
            self.times.of("pixels", || rays.change(|plane| fill.collected(plane, n)))?;
        }
        for layer in 0..self.scene.layers() {
            self.read_out(channels, &rays, fill, [place, shot.number, layer], images)?;
        }
        Ok(())
    }

    /// One detector layer's image, with noise.
    fn read_out<T: Sample>(
        &self,
        channels: &Channels,
        pixels: &Signals,
        fill: FillFactor,
        [place, number, layer]: [usize; 3],
        images: &mut Images<T>,
    ) -> Result<()> {
        let rows = channels.of_layer(layer);
        let mean = &pixels.planes[rows[1]];
        let totals = channels.totals();
        let noisy = match &self.scene.effects.noise {
            None => None,
            Some(noise) => Some(self.times.of("noise", || {
                // Intensities are in units of the spectrum.
                let photons_per_pixel = noise.photons_per_pixel / self.scene.spectrum.total();
                let noise = Noise { photons_per_pixel, ..*noise };
                let gain = mean_gain(self.scene, layer)?;
                noise.applied(rows.map(|row| &pixels.planes[row]), gain, number, layer)
            })?),
        };
        let intensity = noisy.as_ref().unwrap_or(mean);
        let plane = place * self.scene.layers() + layer;
        if self.layers.intensity {
            put(&mut images.intensity, plane, intensity);
        }
        if self.layers.line_integral {
            let even = totals[rows[1]] * fill.part();
            let open = |k: usize| pixels.open.get(rows[1]).map_or(even, |open| open.values()[k]);
            let values = intensity.values();
            plane_of(&mut images.line_integral, plane, values.len())
                .par_iter_mut()
                .zip(values)
                .enumerate()
                .for_each(|(k, (to, &signal))| {
                    // Where noise leaves no signal, or nothing arrives at all, it is infinite.
                    let p = if signal > 0.0 { (open(k) / signal).ln() } else { f64::INFINITY };
                    *to = T::of(p);
                });
        }
        Ok(())
    }
}

/// Blurs the images as the focal spot does at the volume's centre.
fn convolve<T: Sample>(spot: FocalSpot, shot: &Shot<T>, rays: &mut Signals) -> Result<()> {
    let at = shot.beamline("scene.effects.focal_spot")?;
    let pitch = shot.pitch("scene.effects.focal_spot")?;
    let [columns, rows] = spot.taps(at.source_detector_mm, at.source_centre_mm, pitch)?;
    for plane in &mut rays.planes {
        *plane = convolved(plane, &columns, &rows)?;
    }
    Ok(())
}

fn add_scatter<T: Sample>(kernels: &ScatterKernels, shot: &Shot<T>, rays: &mut Signals) -> Result<()> {
    let (areal_density, pitch) = (shot.total_areal_density()?, shot.pitch("scene.effects.scatter")?);
    let foot = Sights::new(&shot.view, shot.size()).foot();
    for (row, plane) in rays.planes.iter_mut().enumerate() {
        let scattered = kernels.scattered(row, plane, &areal_density, pitch, foot)?;
        plane.add(&scattered);
    }
    Ok(())
}

/// Stores a plane of a layer.
fn put<T: Sample>(layer: &mut [T], plane: usize, values: &Plane) {
    let values = values.values();
    let target = plane_of(layer, plane, values.len());
    target.par_iter_mut().zip(values).for_each(|(to, &value)| *to = T::of(value));
}

/// A plane, of so many pixels, of a layer.
fn plane_of<T>(layer: &mut [T], plane: usize, pixels: usize) -> &mut [T] {
    &mut layer[plane * pixels..(plane + 1) * pixels]
}
