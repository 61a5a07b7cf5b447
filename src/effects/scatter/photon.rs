//! A photon on its way.

use std::f64::consts::TAU;

use glam::DVec3;

use super::random::Random;
use crate::physics::{Coefficients, Incoherent, Interactions};

/// A photon, or the part of one that its weight says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Photon {
    /// cm.
    pub(super) position: DVec3,
    /// A unit vector.
    pub(super) direction: DVec3,
    /// keV.
    pub(super) kev: f64,
    pub(super) weight: f64,
    /// Largest distance of its interactions from the z axis, cm.
    pub(super) excursion: f64,
}

impl Photon {
    /// Scatters it where it is: incoherently or coherently, as likely as each is. `coefficients` are those of its energy.
    pub(super) fn scatter(&mut self, water: &Interactions, coefficients: &Coefficients, random: &mut Random) {
        let cosine = if random.uniform() * coefficients.scattering() < coefficients.incoherent {
            let electrons = Incoherent::new(self.kev);
            let cosine = electrons.sample(|| random.uniform());
            self.kev = electrons.scattered_kev(cosine);
            cosine
        } else {
            water.coherent(self.kev).sample(|| random.uniform())
        };
        let (sine, azimuth) = ((1.0 - cosine * cosine).sqrt(), TAU * random.uniform());
        let (a, b) = self.direction.any_orthonormal_pair();
        let across = a * azimuth.cos() + b * azimuth.sin();
        self.direction = (self.direction * cosine + across * sine).normalize();
    }
}
