//! What leaves the source towards each pixel.

use rayon::prelude::*;

use crate::allocation::filled;
use crate::effects::{Effects, Heel, Sight, Sights, fall_off};
use crate::error::{Error, Result};
use crate::exposure::channels::{Before, Channels};
use crate::exposure::rows::rows_of;
use crate::geometry::View;
use crate::physics::{Material, Spectrum};
use crate::scene::Scene;

/// A view's source: a factor for all energies, and areal densities of what lies between it and the volume.
pub(crate) struct Source<'a> {
    effects: &'a Effects,
    sights: Sights,
    /// Tungsten's coefficients at the spectrum's energies, where the anode matters.
    anode: Option<Anode>,
}

/// The anode in front of the photons that it emits.
struct Anode {
    /// cm²/g.
    coefficients: Vec<f64>,
    /// g/cm³.
    density: f64,
    /// The shortest way through it that any pixel sees, and that on the central ray, mm.
    least: f64,
    central: f64,
}

/// How many times the photons on the central ray there may be where the way through the anode is shortest.
const MOST_GROWTH: f64 = 2.0;

impl Anode {
    /// g/cm² that the tube's spectrum passed on the central ray more than it does anywhere on the detector.
    fn passed(&self) -> f64 {
        CM * self.density * (self.central - self.least)
    }

    /// A spectrum that was not filtered as much as the anode would have filtered it cannot be told what was filtered out.
    fn check_growth(&self, scene: &Scene, heel: &Heel) -> Result<()> {
        let photons = scene.spectrum.weights().iter().zip(&self.coefficients);
        let grown: f64 = photons.map(|(weight, mu)| weight * (mu * self.passed()).exp()).sum();
        let growth = grown / scene.spectrum.total();
        if growth <= MOST_GROWTH {
            return Ok(());
        }
        let value = format!("{} at a target angle of {} degrees", heel.depth_mm, heel.target_angle_degrees);
        let valid = format!(
            "a depth and an angle by which the tube's spectrum grows at most {MOST_GROWTH} times towards the cathode, not \
             {growth:.1e}: it holds on the central ray, behind the anode's own filtration there"
        );
        Err(Error::invalid("scene.effects.heel.depth_mm", value, valid))
    }
}

/// mm to cm: densities are per cm³.
const CM: f64 = 0.1;

impl<'a> Source<'a> {
    /// Of a view with `size` rays, whose rays begin at the focal spot's centre.
    pub(crate) fn new(scene: &'a Scene, view: &View, size: [usize; 2]) -> Result<Self> {
        let sights = Sights::new(view, size);
        let anode = match &scene.effects.heel {
            None => None,
            Some(heel) => {
                let table = Heel::anode(*scene.spectrum.grid())?;
                let least = heel.least_path_mm(&sights, size);
                if least == f64::INFINITY {
                    let valid = "a detector that the anode does not hide, or another cathode_degrees";
                    let value = format!("{} degrees", heel.target_angle_degrees);
                    return Err(Error::invalid("scene.effects.heel.target_angle_degrees", value, valid));
                }
                let anode = Anode {
                    coefficients: table.coefficients(0).to_vec(),
                    density: Material::named("tungsten")?.reference_density(),
                    least,
                    central: heel.central_path_mm(),
                };
                anode.check_growth(scene, heel)?;
                Some(anode)
            }
        };
        Ok(Self { effects: &scene.effects, sights, anode })
    }

    /// Whether every pixel sees the same.
    pub(crate) fn is_even(&self) -> bool {
        self.effects.is_even_source()
    }

    /// Sums over energies of this source.
    pub(crate) fn channels(&self, scene: &Scene, noisy: bool) -> Result<Channels> {
        Channels::new(scene, &self.before(), noisy)
    }

    /// The factor towards a ray; what lies before the volume goes to `before`, g/cm².
    pub(crate) fn towards(&self, column: f64, row: f64, before: &mut [f64]) -> f64 {
        if self.is_even() {
            return 1.0;
        }
        let sight = self.sights.at(column, row);
        self.areal_densities(&sight, before);
        if self.effects.fall_off { fall_off(&sight) } else { 1.0 }
    }

    /// Whether the factor is not 1 everywhere.
    pub(super) fn has_factor(&self) -> bool {
        self.effects.fall_off
    }

    /// The factor towards a ray.
    pub(super) fn factor(&self, column: f64, row: f64) -> f64 {
        if self.effects.fall_off { fall_off(&self.sights.at(column, row)) } else { 1.0 }
    }

    /// What lies before the volume on the ways to all of `size` rays, g/cm²: a plane for each material.
    pub(super) fn planes(&self, size: [usize; 2]) -> Result<Vec<f32>> {
        let materials = self.before().len();
        let plane = size[0] * size[1];
        let mut planes = filled(materials * plane, 0.0, "what lies before the volume")?;
        rows_of(planes.chunks_mut(plane), size).into_par_iter().enumerate().for_each(|(row, mut values)| {
            let mut areal = vec![0.0; materials];
            // Without a material there is nowhere to go.
            for column in 0..values.first().map_or(0, |values| values.len()) {
                self.areal_densities(&self.sights.at(column as f64, row as f64), &mut areal);
                values.iter_mut().zip(&areal).for_each(|(to, &areal)| to[column] = areal as f32);
            }
        });
        Ok(planes)
    }

    fn areal_densities(&self, sight: &Sight, before: &mut [f64]) {
        let heel = self.effects.heel.iter().zip(&self.anode);
        let anode = heel.map(|(heel, anode)| CM * anode.density * (heel.path_mm(sight) - anode.least));
        let filters = self.effects.filters.iter().map(|filter| filter.areal_density(sight));
        before.iter_mut().zip(anode.chain(filters)).for_each(|(place, areal)| *place = areal);
    }

    /// The spectrum behind the filters, on the detector's normal: what scatters in the volume.
    pub(crate) fn filtered(&self, spectrum: &Spectrum) -> Result<Spectrum> {
        if self.effects.filters.is_empty() {
            return Ok(spectrum.clone());
        }
        let depth = |k: usize| -> f64 {
            let filters = self.effects.filters.iter();
            filters.map(|filter| filter.coefficients[k] * filter.areal_density(&Sight::NORMAL)).sum()
        };
        let weights = spectrum.weights().iter().enumerate().map(|(k, weight)| weight * (-depth(k)).exp());
        Spectrum::new(spectrum.name(), *spectrum.grid(), weights.collect())
    }

    /// The largest |ln| of what the source's effects multiply any energy with weight by, towards a ray.
    pub(crate) fn largest_logarithm(&self, scene: &Scene, column: f64, row: f64) -> f64 {
        let before = self.before();
        let mut areal = vec![0.0; before.len()];
        let factor = self.towards(column, row, &mut areal);
        let weights = scene.spectrum.weights().iter().enumerate().filter(|(_, weight)| **weight > 0.0);
        let logarithm = |(k, _): (usize, &f64)| {
            let depths = before.iter().zip(&areal).map(|(b, areal)| b.coefficients[k] * (areal - b.passed));
            (factor.ln() - depths.sum::<f64>()).abs()
        };
        weights.map(logarithm).fold(0.0, f64::max)
    }

    /// What lies before the volume.
    fn before(&self) -> Vec<Before<'_>> {
        let anode = self
            .anode
            .iter()
            .map(|anode| Before { coefficients: &anode.coefficients, passed: anode.passed() });
        let filters = self
            .effects
            .filters
            .iter()
            .map(|filter| Before { coefficients: &filter.coefficients, passed: 0.0 });
        anode.chain(filters).collect()
    }
}
