//! The float32 engine: all cores, rays that are swept slice by slice where neighbours share what they read, and tiles of rays that
//! march together elsewhere.

pub(crate) mod bins;
mod developed;
mod distance_driven;
mod field;
mod indicator;
mod kernel;
mod lanes;
mod level;
mod path;
pub(crate) mod signal;
mod sum;
mod sweep;
#[cfg(test)]
mod tests;
mod tile;
mod width;
mod window;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use glam::Vec4;
use rayon::prelude::*;

use crate::allocation::filled;
use crate::engine::images::PixelValue;
use crate::engine::{Engine, Images, Job, Layers, ViewJob};
use crate::error::Result;
use crate::method::{Accumulation, Algorithm};
use crate::physics::MAX_MATERIALS;
use crate::plan::Plan;
use crate::raycast::tighten::REACH;
use crate::raycast::{Beam, Footprint, Ray};
use crate::scene::Scene;
use crate::volume::{Matter, Occupied, Volume};
use developed::Developed;
use distance_driven::DistanceDriven;
use field::Table;
use indicator::Indicator;
use kernel::{Joseph, March, Siddon};
use lanes::{Eight, Lanes};
use level::Kind;
use path::Path;
use signal::Signal;
use sum::{Blocked, Compensated, Naive, Sum};
use sweep::{Cast, RayGrid, Sweep};
use tile::Tile;

/// Rays of a tile, which walk together: rows × columns. Their voxels of one block fit the second-level cache.
const TILE: [usize; 2] = [8, 64];

/// Depth of every energy bin beyond which an early exit may stop: e⁻¹⁵ = 3e-7 of I0 is left at most, also after the
/// depth and the intensity have been rounded, which is worth 5e-5 at a depth of 15.
const OPAQUE: f64 = 15.000_1;

/// The float32 engine, ready for one scene and one volume.
pub struct Cpu {
    volume: Arc<Volume>,
    algorithm: Algorithm,
    accumulation: Accumulation,
    supersampling: usize,
    size: [usize; 2],
    materials: usize,
    accumulators: Accumulators,
    /// Label of each accumulator.
    labels: Vec<u8>,
    /// Where any of that is, if looking for the ends of rays pays.
    occupied: Option<Occupied>,
    bone: Option<Indicator>,
    signal: Signal,
    /// Whether neighbouring rays are cast together where that pays, and how: made when it first does.
    sweeps: bool,
    sweep: OnceLock<Option<Sweep>>,
    /// Of what is swept.
    level: Kind,
}

/// Rays, and the footprints of their pixels where the algorithm asks for them.
type Pixels<'a> = (&'a [Ray], &'a [Footprint]);

/// The march's tables, for as many materials as the plan needs.
enum Accumulators {
    None,
    One(Table<f32>),
    Four(Table<Vec4>),
    Eight(Table<Eight>),
}

impl Cpu {
    /// Ready to project `volume` as `scene` and `plan` say.
    pub fn new(volume: Arc<Volume>, scene: &Scene, plan: &Plan) -> Result<Self> {
        let labels: Vec<u8> = plan.materials.iter().map(|m| m.label).collect();
        let mut lane_of = [None; MAX_MATERIALS];
        labels.iter().enumerate().for_each(|(lane, &label)| lane_of[usize::from(label)] = Some(lane));
        let storage = plan.method.storage;
        let accumulators = match labels.len() {
            0 => Accumulators::None,
            1 => Accumulators::One(Table::densities(&volume, storage, &lane_of)?),
            2..=4 => Accumulators::Four(Table::densities(&volume, storage, &lane_of)?),
            _ => Accumulators::Eight(Table::densities(&volume, storage, &lane_of)?),
        };
        let seen = Matter::new(labels.iter().fold(0, |seen, label| seen | 1 << label), 0.0)?;
        let occupied = if plan.looks_for_ends() { Some(volume.occupancy()?.of(seen)?) } else { None };
        let bone = scene.bone.filter(|&bone| volume.materials()[usize::from(bone)].labelled);
        Ok(Self {
            sweeps: Sweep::has(&volume, &labels, &plan.method),
            sweep: OnceLock::new(),
            level: Kind::chosen(),
            algorithm: plan.method.algorithm,
            accumulation: plan.method.accumulation,
            supersampling: scene.supersampling,
            size: scene.detector,
            materials: scene.materials.names().len(),
            bone: bone.map(|bone| Indicator::new(&volume, bone)).transpose()?,
            signal: Signal::new(Arc::new(scene.spectral_model()?), plan.quadrature.as_ref()),
            accumulators,
            labels,
            occupied,
            volume,
        })
    }

    fn sweep(&self) -> Option<&Sweep> {
        self.sweep.get_or_init(|| Sweep::new(&self.volume, &self.labels)).as_ref()
    }

    /// By the view's own tables, where it has some.
    fn signal(&self, view: &ViewJob) -> Cow<'_, Signal> {
        let own = view.spectral.clone();
        own.map_or(Cow::Borrowed(&self.signal), |model| Cow::Owned(Signal::new(model, None)))
    }

    /// Rows and columns of pixels in a tile.
    fn tile_size(&self) -> [usize; 2] {
        TILE.map(|rays| (rays / self.supersampling).max(1))
    }

    /// All pixels of rows `first_row …` of a view, row-major.
    fn band(&self, job: &Job<'_>, view: &ViewJob, first_row: usize) -> Result<Vec<PixelValue>> {
        let [width, height] = self.size;
        let [tile_rows, tile_columns] = self.tile_size();
        let rows = first_row..(first_row + tile_rows).min(height);
        let signal = &*self.signal(view);
        let vacuum = PixelValue::vacuum(signal.i0());
        let mut values = filled(rows.len() * width, vacuum, "rows of the detector")?;
        for first_column in (0..width).step_by(tile_columns) {
            let columns = first_column..(first_column + tile_columns).min(width);
            let pixels: Vec<_> = rows.clone().flat_map(|j| columns.clone().map(move |i| (i, j))).collect();
            for ((i, j), value) in pixels.iter().zip(self.tile(view, signal, job.layers, &pixels)) {
                values[(j - first_row) * width + i] = value;
            }
            job.progress.finished(pixels.len() * self.supersampling * self.supersampling)?;
        }
        Ok(values)
    }

    /// The values of some neighbouring pixels.
    fn tile(
        &self,
        view: &ViewJob,
        signal: &Signal,
        layers: Layers,
        pixels: &[(usize, usize)],
    ) -> Vec<PixelValue> {
        let n = self.supersampling;
        let offset = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
        let in_pixel = |&(i, j): &(usize, usize)| {
            (0..n * n).map(move |k| (i as f64 + offset(k % n), j as f64 + offset(k / n)))
        };
        let places: Vec<(f64, f64)> = pixels.iter().flat_map(in_pixel).collect();
        let rays: Vec<Ray> = places.iter().map(|&(i, j)| view.beam.ray(i, j)).collect();
        let footprints = self.footprints(&view.beam, &places, &rays);
        // A truncated ray would be seen in every layer but the intensity and, marched on its own, the bone path.
        let may_stop = view.early_exit && !layers.line_integral && !layers.areal_density;
        let areal_densities = self.areal_densities((&rays, &footprints), may_stop.then_some(signal));
        let bone_paths = if layers.bone_path { self.bone_paths(&rays) } else { Vec::new() };
        let mut depth = Vec::new();
        let lit = layers.intensity || layers.line_integral;
        let values: Vec<_> = areal_densities
            .into_iter()
            .enumerate()
            .map(|(k, areal_density)| {
                let (intensity, line_integral) =
                    if lit { signal.of(&areal_density, &mut depth) } else { (0.0, 0.0) };
                let bone_path = bone_paths.get(k).copied().unwrap_or(0.0);
                PixelValue { intensity, line_integral, areal_density, bone_path }
            })
            .collect();
        values.chunks(n * n).map(PixelValue::mean).collect()
    }

    /// What the pixels cover, where the algorithm asks for it.
    fn footprints(&self, beam: &Beam, places: &[(f64, f64)], rays: &[Ray]) -> Vec<Footprint> {
        if self.algorithm != Algorithm::DistanceDriven {
            return Vec::new();
        }
        let all = beam.of_parts(self.supersampling).footprints();
        places.iter().zip(rays).map(|(&(i, j), ray)| all.of(ray, i, j)).collect()
    }

    /// Areal densities of each ray, g/cm², by label.
    fn areal_densities(&self, rays: Pixels<'_>, stop: Option<&Signal>) -> Vec<[f64; MAX_MATERIALS]> {
        let labels = &self.labels;
        let by_label = |lanes: &[f64; MAX_MATERIALS]| {
            let mut areal = [0.0; MAX_MATERIALS];
            // A sample a rounding error outside its cell is extrapolated: vacuum beside bone would come out at -1e-7.
            labels.iter().zip(lanes).for_each(|(&label, &a)| areal[usize::from(label)] = a.max(0.0));
            areal
        };
        let opaque = |lanes: &[f64; MAX_MATERIALS]| {
            stop.is_some_and(|signal| signal.least_depth(&by_label(lanes)) > OPAQUE)
        };
        let lanes = match &self.accumulators {
            Accumulators::None => vec![[0.0; MAX_MATERIALS]; rays.0.len()],
            Accumulators::One(table) => self.integrate(table, rays, &opaque),
            Accumulators::Four(table) => self.integrate(table, rays, &opaque),
            Accumulators::Eight(table) => self.integrate(table, rays, &opaque),
        };
        lanes.iter().map(by_label).collect()
    }

    fn integrate<L: Lanes>(
        &self,
        table: &Table<L>,
        rays: Pixels<'_>,
        opaque: &dyn Fn(&[f64; MAX_MATERIALS]) -> bool,
    ) -> Vec<[f64; MAX_MATERIALS]> {
        match self.accumulation {
            Accumulation::Naive => self.integrate_by::<Naive<L>, L>(table, rays, opaque),
            Accumulation::Blocked => self.integrate_by::<Blocked<L>, L>(table, rays, opaque),
            Accumulation::Compensated => self.integrate_by::<Compensated<L>, L>(table, rays, opaque),
        }
    }

    fn integrate_by<S: Sum<L>, L: Lanes>(
        &self,
        table: &Table<L>,
        (rays, footprints): Pixels<'_>,
        opaque: &dyn Fn(&[f64; MAX_MATERIALS]) -> bool,
    ) -> Vec<[f64; MAX_MATERIALS]> {
        let occupied = self.occupied.as_ref();
        let tile = |step| Tile::new(rays, &self.volume, step, occupied, |_, _| REACH);
        match self.algorithm {
            Algorithm::March { step } => tile(step).integrate::<S, L>(&March, table, opaque),
            Algorithm::Siddon => tile(1.0).integrate::<S, L>(&Siddon, table, opaque),
            Algorithm::Joseph => tile(1.0).integrate::<S, L>(&Joseph, table, opaque),
            Algorithm::DistanceDriven => {
                let reach = |k: usize, span| footprints[k].reach(&rays[k], span);
                let tile = Tile::new(rays, &self.volume, 1.0, occupied, reach);
                tile.of_pixels(footprints, rays).integrate::<S, L>(&DistanceDriven, table, opaque)
            }
            Algorithm::Exact => unreachable!("the plan refuses it"),
        }
    }

    /// Length through bone of each ray, mm.
    fn bone_paths(&self, rays: &[Ray]) -> Vec<f64> {
        let Some(indicator) = &self.bone else {
            return Vec::new();
        };
        // Voxels are bone by their label, whatever their density.
        let tile = Tile::new(rays, &self.volume, 1.0, None, |_, _| REACH);
        let cm = tile.integrate::<Blocked<f32>, f32>(&Siddon, indicator, &|_| false);
        cm.iter().map(|lanes| 10.0 * lanes[0]).collect()
    }
}

impl Engine for Cpu {
    fn project(&self, job: &Job<'_>) -> Result<Images<f32>> {
        let images = Mutex::new(Images::zeroed(self.size, job.views.len(), self.materials, job.layers)?);
        let store = |v: usize, row: usize, columns: Range<usize>, values: &[PixelValue]| {
            let mut images = images.lock().unwrap_or_else(PoisonError::into_inner);
            images.store(v, row, columns, values, |x| x as f32);
        };
        let rays =
            RayGrid { size: self.size.map(|side| side * self.supersampling), unit: self.supersampling };
        let (mut swept, mut marched) = (Vec::new(), Vec::new());
        for (v, view) in job.views.iter().enumerate() {
            let beam = view.beam.on_ray_grid(self.supersampling);
            if self.sweeps && Sweep::pays(&beam, rays.size) && self.sweep().is_some() {
                swept.push((v, beam));
            } else {
                marched.push((v, view));
            }
        }
        if let (Some(sweep), false) = (self.sweep.get().and_then(Option::as_ref), swept.is_empty()) {
            let cast = Cast { level: self.level, volume: &self.volume, rays, progress: &job.progress };
            sweep.project(cast, &swept, &|v, beam, part, met| {
                let values = Developed { cpu: self, view: &job.views[v], layers: job.layers, part, met }
                    .pixels(beam)?;
                let [columns, rows] = part.pixels(rays);
                store(v, rows.start, columns, &values);
                Ok(())
            })?;
        }
        let rows = self.tile_size()[0];
        let bands = self.size[1].div_ceil(rows);
        (0..marched.len() * bands).into_par_iter().try_for_each(|n| {
            let ((v, view), row) = (marched[n / bands], n % bands * rows);
            let values = self.band(job, view, row)?;
            store(v, row, 0..self.size[0], &values);
            Ok(())
        })?;
        Ok(images.into_inner().unwrap_or_else(PoisonError::into_inner))
    }
}
