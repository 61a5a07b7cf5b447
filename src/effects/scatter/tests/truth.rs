//! Photons of a point source in a body of water, in three dimensions: what the estimate is held to. Of the library it uses
//! the interactions with matter and no more.

use glam::DVec3;
use rayon::prelude::*;

use super::super::random::Random;
use crate::physics::{Incoherent, Interactions, Spectrum};

pub(super) const BATCHES: usize = 32;

/// Water of 1 g/cm³ around the point `centre_cm` on the beam's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Body {
    /// Across the beam, wider than it.
    Slab { thickness_cm: f64 },
    /// With its axis along y, longer than the beam is high.
    Cylinder { diameter_cm: f64 },
}

/// The source is at the origin; the detector is across z. Lengths in cm.
#[derive(Debug, Clone)]
pub(super) struct Stand<'a> {
    pub(super) body: Body,
    pub(super) centre_cm: f64,
    pub(super) detector_cm: f64,
    /// Width and height of the field in the detector's plane; the same number of photons comes to every cm² of it.
    pub(super) field_cm: [f64; 2],
    /// Cells along the field's width, on its central line, as high as wide.
    pub(super) cells: usize,
    pub(super) source: &'a Spectrum,
    /// At the source's energies, whole keV.
    pub(super) responses: &'a [Vec<f64>],
    pub(super) water: Interactions,
}

/// Where the energy of one history went, keV.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Balance {
    pub(super) started: f64,
    pub(super) absorbed: f64,
    pub(super) unscattered: f64,
    pub(super) scattered: f64,
    /// Of `absorbed`, by photons that were no longer followed.
    pub(super) unfollowed: f64,
}

impl Body {
    /// Distances along a ray at which it enters and leaves.
    pub(super) fn crossed(self, centre: f64, from: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let z = from.z - centre;
        match self {
            Self::Slab { thickness_cm } => {
                let [a, b] = [-0.5, 0.5].map(|half| (half * thickness_cm - z) / direction.z);
                Some([a.min(b), a.max(b)])
            }
            Self::Cylinder { diameter_cm } => {
                let a = direction.x * direction.x + direction.z * direction.z;
                let b = from.x * direction.x + z * direction.z;
                let c = from.x * from.x + z * z - 0.25 * diameter_cm * diameter_cm;
                let root = b * b - a * c;
                (root > 0.0).then(|| [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a])
            }
        }
    }
}

impl Stand<'_> {
    /// Water along the ray to a point of the detector, cm.
    pub(super) fn length(&self, u: f64, v: f64) -> f64 {
        let direction = DVec3::new(u, v, self.detector_cm).normalize();
        self.body.crossed(self.centre_cm, DVec3::ZERO, direction).map_or(0.0, |[a, b]| b - a)
    }

    pub(super) fn cell_cm(&self) -> f64 {
        self.field_cm[0] / self.cells as f64
    }

    fn response(&self, row: usize, kev: f64) -> f64 {
        let (values, place) = (&self.responses[row], kev - self.source.grid().first_kev());
        let k = (place as usize).min(values.len() - 2);
        values[k] + (values[k + 1] - values[k]) * (place - k as f64)
    }

    /// Primary signal behind `cm` of water, per photon of the source.
    pub(super) fn primary(&self, row: usize, cm: f64) -> f64 {
        let bins = self.source.grid().energies().zip(self.source.weights());
        let passed =
            bins.map(|(kev, w)| w * self.response(row, kev) * (-self.water.at(kev).total() * cm).exp());
        passed.sum::<f64>() / self.source.total()
    }

    /// Scattered signal at the cells per unit of fluence, row by row, for each batch, and the balance of each history.
    pub(super) fn run(&self, histories: usize, seed: u64) -> (Vec<Vec<f64>>, Vec<Balance>) {
        let batch = |b: usize| {
            let (mut random, mut sums) =
                (Random::new(seed, b as u64), vec![0.0; self.cells * self.responses.len()]);
            let count = histories / BATCHES;
            let balances: Vec<_> = (0..count).map(|_| self.history(&mut random, &mut sums)).collect();
            let area = self.field_cm[0] * self.field_cm[1];
            for sum in &mut sums {
                *sum *= area / count as f64;
            }
            (sums, balances)
        };
        let all: Vec<_> = (0..BATCHES).into_par_iter().map(batch).collect();
        let (sums, balances): (Vec<_>, Vec<Vec<_>>) = all.into_iter().unzip();
        (sums, balances.concat())
    }

    /// Energies in keV that photons start with, by one uniform number.
    pub(super) fn start(&self, place: f64) -> f64 {
        let mut sum = 0.0;
        let bins = self.source.grid().energies().zip(self.source.weights());
        let found = bins.filter(|(_, w)| **w > 0.0).find(|(_, w)| {
            sum += **w / self.source.total();
            sum > place
        });
        found.map_or_else(|| self.source.mean_kev(), |(kev, _)| kev)
    }

    /// One photon, as nature does it; at each interaction, what would come to the cells.
    fn history(&self, random: &mut Random, sums: &mut [f64]) -> Balance {
        let mut kev = self.start(random.uniform());
        let mut balance = Balance { started: kev, ..Balance::default() };
        let [u, v] = self.field_cm.map(|side| side * (random.uniform() - 0.5));
        let (mut position, mut direction) = (DVec3::ZERO, DVec3::new(u, v, self.detector_cm).normalize());
        let Some([enter, _]) = self.body.crossed(self.centre_cm, position, direction) else {
            return Balance { unscattered: kev, ..balance };
        };
        position += direction * enter;
        for interactions in 0.. {
            let of = self.water.at(kev);
            let path = -(1.0 - random.uniform()).ln() / of.total();
            let room = self.body.crossed(self.centre_cm, position, direction).map_or(0.0, |[_, leave]| leave);
            if path >= room {
                let escaped =
                    if interactions == 0 { &mut balance.unscattered } else { &mut balance.scattered };
                *escaped += kev;
                break;
            }
            position += direction * path;
            self.detect(position, direction, kev, random, sums);
            let kind = random.uniform() * of.total();
            if kind < of.photoelectric {
                balance.absorbed += kev;
                break;
            }
            let electrons = Incoherent::new(kev);
            let cosine = if kind < of.photoelectric + of.incoherent {
                let cosine = electrons.sample(|| random.uniform());
                balance.absorbed += kev - electrons.scattered_kev(cosine);
                kev = electrons.scattered_kev(cosine);
                cosine
            } else {
                self.water.coherent(kev).sample(|| random.uniform())
            };
            if kev < Interactions::LOWEST_KEV {
                balance.absorbed += kev;
                balance.unfollowed += kev;
                break;
            }
            direction = turned(direction, cosine, std::f64::consts::TAU * random.uniform());
        }
        balance
    }

    /// Expected signal per cm² at a random point of each cell from an interaction (next-event estimator).
    fn detect(&self, at: DVec3, direction: DVec3, kev: f64, random: &mut Random, sums: &mut [f64]) {
        let (of, electrons, atoms) = (self.water.at(kev), Incoherent::new(kev), self.water.coherent(kev));
        let cell = self.cell_cm();
        for k in 0..self.cells {
            let u = (k as f64 + random.uniform()) * cell - 0.5 * self.field_cm[0];
            let v = (random.uniform() - 0.5) * cell;
            let way = DVec3::new(u, v, self.detector_cm) - at;
            let distance = way.length();
            let towards = way / distance;
            let cosine = direction.dot(towards).clamp(-1.0, 1.0);
            let geometry = towards.z / (distance * distance * of.total());
            let water =
                self.body.crossed(self.centre_cm, at, towards).map_or(0.0, |[_, leave]| leave.max(0.0));
            for (kev, density) in [
                (kev, of.coherent * atoms.density(cosine)),
                (electrons.scattered_kev(cosine), of.incoherent * electrons.density(cosine)),
            ] {
                if kev >= Interactions::LOWEST_KEV {
                    let passed = geometry * density * (-self.water.at(kev).total() * water).exp();
                    for row in 0..self.responses.len() {
                        sums[row * self.cells + k] += passed * self.response(row, kev);
                    }
                }
            }
        }
    }
}

/// A unit vector at an angle with that cosine to another, turned around it by the azimuth.
fn turned(direction: DVec3, cosine: f64, azimuth: f64) -> DVec3 {
    let axis = if direction.x.abs() < 0.6 { DVec3::X } else { DVec3::Y };
    let across = direction.cross(axis).normalize();
    let other = direction.cross(across);
    let sine = (1.0 - cosine * cosine).sqrt();
    (direction * cosine + (across * azimuth.cos() + other * azimuth.sin()) * sine).normalize()
}
