//! Photons of a pencil beam in a slab of water.

use glam::DVec3;
use rayon::prelude::*;

use super::excursion::{CLASSES, class};
use super::photon::Photon;
use super::random::Random;
use super::responses::Responses;
use super::rings::Rings;
use crate::physics::{Interactions, Spectrum};

/// Parts into which the histories of a slab are cut, each with random numbers of its own.
const BATCHES: usize = 32;
/// A photon lighter than this part of what is usual at its depth goes on with half the probability and twice the weight.
const LIGHT: f64 = 0.2;
/// One heavier than this becomes two.
const HEAVY: f64 = 3.0;
/// Parts of a photon that may wait to be followed.
const MOST_WAITING: usize = 64;
/// How much longer paths are chosen along the beam than they are.
const STRETCH: f64 = 0.6;
/// The golden ratio: its multiples fill an interval evenly (Roberts, The unreasonable effectiveness of quasirandom
/// sequences, 2018).
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Water of 1 g/cm³ across the beam, and the detector behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slab {
    /// cm.
    pub(super) thickness_cm: f64,
    /// From the exit to the detector, cm.
    pub(super) gap_cm: f64,
}

/// Signal of scattered photons per photon of the source.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scattered {
    /// Row i of excursion class m in ring k at `(k*CLASSES + m)*rows + i`.
    pub(super) signal: Vec<f64>,
    /// Relative standard error of the sum over rings of each row, from the differences of the batches.
    pub(super) error: Vec<f64>,
}

/// A pencil beam along z, and what sees it.
#[derive(Debug)]
pub(super) struct Pencil<'a> {
    pub(super) water: &'a Interactions,
    pub(super) source: &'a Spectrum,
    pub(super) responses: &'a Responses,
    pub(super) rings: &'a Rings,
}

/// Energies to start with: `(keV, cumulative probability, weight)`.
type Starts = Vec<(f64, f64, f64)>;

impl Pencil<'_> {
    /// Signal of each row of the photons that cross the slab without interaction, per photon of the source.
    pub(super) fn primary(&self, slab: Slab) -> Vec<f64> {
        let (mut sums, total) = (vec![0.0; self.responses.rows()], self.source.total());
        for (kev, weight) in self.source.grid().energies().zip(self.source.weights()) {
            let passed = (-self.water.at(kev).total() * slab.thickness_cm).exp();
            self.responses.add(kev, weight / total * passed, &mut sums);
        }
        sums
    }

    /// Effective attenuation of each row's primary signal, cm²/g, as if it were exponential: over 20 g/cm².
    pub(super) fn attenuation(&self) -> Vec<f64> {
        let [none, thick] = [0.0, 20.0].map(|thickness_cm| self.primary(Slab { thickness_cm, gap_cm: 0.0 }));
        none.iter().zip(&thick).map(|(none, thick)| (none / thick).ln() / 20.0).collect()
    }

    /// The signal of scattered photons in each ring, from about `histories` photons. Streams of random numbers
    /// `stream` … `stream + 31` are used.
    pub(super) fn scattered(&self, slab: Slab, histories: usize, seed: u64, stream: u64) -> Scattered {
        let (starts, per_batch) = (self.starts(slab), histories.div_ceil(BATCHES));
        let batch = |b: usize| self.batch(slab, &starts, per_batch, Random::new(seed, stream + b as u64));
        let batches: Vec<Vec<f64>> = (0..BATCHES).into_par_iter().map(batch).collect();
        let mut signal = vec![0.0; self.values()];
        for (sum, k) in signal.iter_mut().zip(0..) {
            *sum = batches.iter().map(|batch: &Vec<f64>| batch[k]).sum::<f64>() / BATCHES as f64;
        }
        let error = (0..self.responses.rows()).map(|row| self.relative_error(&batches, row)).collect();
        Scattered { signal, error }
    }

    fn relative_error(&self, batches: &[Vec<f64>], row: usize) -> f64 {
        let of = |batch: &Vec<f64>| batch.iter().skip(row).step_by(self.responses.rows()).sum::<f64>();
        let (n, sums) = (batches.len() as f64, batches.iter().map(of).collect::<Vec<_>>());
        let mean = sums.iter().sum::<f64>() / n;
        let variance = sums.iter().map(|sum| (sum - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (variance / n).sqrt() / mean
    }

    /// The source's energies, those more often that get deeper into the slab: importance sampling with the transmission
    /// of three quarters of it.
    fn starts(&self, slab: Slab) -> Starts {
        let total = self.source.total();
        let energies = self.source.grid().energies().zip(self.source.weights()).filter(|(_, w)| **w > 0.0);
        let chosen: Vec<_> = energies
            .map(|(kev, weight)| {
                let reach = (-0.75 * self.water.at(kev).total() * slab.thickness_cm).exp();
                (kev, weight / total, weight / total * reach)
            })
            .collect();
        let all: f64 = chosen.iter().map(|(_, _, often)| often).sum();
        let mut sum = 0.0;
        let start = |(kev, weight, often): (f64, f64, f64)| {
            sum += often / all;
            (kev, sum, weight / (often / all))
        };
        chosen.into_iter().map(start).collect()
    }

    /// The mean signal of `histories` photons, whose energies are as evenly spread as the starts say.
    fn batch(&self, slab: Slab, starts: &Starts, histories: usize, mut random: Random) -> Vec<f64> {
        let (mut sums, shift) = (vec![0.0; self.values()], random.uniform());
        for history in 0..histories {
            let place = (history as f64 + random.uniform()) / histories as f64;
            let (kev, _, weight) = starts[starts.partition_point(|s| s.1 <= place).min(starts.len() - 1)];
            let weight = weight / histories as f64;
            let depth = (shift + history as f64 * GOLDEN).fract() * slab.thickness_cm;
            let position = DVec3::new(0.0, 0.0, depth);
            let photon = Photon { position, direction: DVec3::Z, kev, weight, excursion: 0.0 };
            self.follow(slab, photon, &mut random, &mut sums);
        }
        sums
    }

    /// Sums of a batch.
    fn values(&self) -> usize {
        self.rings.count() * CLASSES * self.responses.rows()
    }

    /// One history, from its first interaction on, which is as likely at every depth. Absorption takes weight instead of
    /// photons, after each scattering the part that reaches the detector without another one is counted, paths are
    /// chosen longer the more they lead to the exit, and photons are split and dropped where their weights are unusual, all
    /// with the weights that keep the estimate unbiased (Lux & Koblinger, Monte Carlo Particle Transport Methods, 1991,
    /// ch. 5 and 6). Below 15 keV nothing is followed.
    fn follow(&self, slab: Slab, mut photon: Photon, random: &mut Random, sums: &mut [f64]) {
        let beam = self.water.at(photon.kev).total();
        let usual = |z: f64| (-beam * z).exp() * beam * slab.thickness_cm;
        let first = photon.weight;
        photon.weight *= usual(photon.position.z);
        let mut waiting = vec![photon];
        while let Some(mut photon) = waiting.pop() {
            let ratio = photon.weight / (first * usual(photon.position.z));
            if ratio > HEAVY && waiting.len() < MOST_WAITING {
                photon.weight *= 0.5;
                waiting.extend([photon; 2]);
                continue;
            }
            if ratio < LIGHT {
                if random.uniform() < 0.5 {
                    continue;
                }
                photon.weight *= 2.0;
            }
            waiting.extend(self.interact(slab, photon, random, sums));
        }
    }

    /// Scatters a photon, counts it, and lets it fly to its next interaction in the slab, if there is one.
    fn interact(
        &self,
        slab: Slab,
        mut photon: Photon,
        random: &mut Random,
        sums: &mut [f64],
    ) -> Option<Photon> {
        let before = self.water.at(photon.kev);
        photon.weight *= before.scattering() / before.total();
        photon.scatter(self.water, &before, random);
        if photon.kev < Interactions::LOWEST_KEV {
            return None;
        }
        let total = self.water.at(photon.kev).total();
        self.count(slab, &photon, total, sums);
        let shorter = STRETCH * photon.direction.z;
        let path = -(-random.uniform()).ln_1p() / (total * (1.0 - shorter));
        photon.weight *= (-total * shorter * path).exp() / (1.0 - shorter);
        photon.position += photon.direction * path;
        photon.excursion = photon.excursion.max(photon.position.x.hypot(photon.position.y));
        (photon.position.z > 0.0 && photon.position.z < slab.thickness_cm).then_some(photon)
    }

    /// Counts the part of a photon that leaves the slab towards the detector without interaction, where it hits.
    fn count(&self, slab: Slab, photon: &Photon, attenuation: f64, sums: &mut [f64]) {
        if !(photon.direction.z > 0.0) {
            return;
        }
        let to_exit = slab.thickness_cm - photon.position.z;
        let hit = photon.position + photon.direction * ((to_exit + slab.gap_cm) / photon.direction.z);
        let Some(ring) = self.rings.index(10.0 * hit.x.hypot(hit.y)) else { return };
        let passed = (-attenuation * to_exit / photon.direction.z).exp();
        let rows = self.responses.rows();
        let place = (ring * CLASSES + class(photon.excursion)) * rows;
        self.responses.add(photon.kev, photon.weight * passed, &mut sums[place..][..rows]);
    }
}
