//! What a kernel of an upright pencil in a slab misses: the beam diverges, and objects are not slabs.
//!
//! Both corrections have the form (factor of the source) × (factor of the target), so that the sum over pencils stays a
//! convolution.

/// Factors of one row of responses, from means over the places where scatter comes from: scattered photons are attenuated about as
/// the primary ones, so that the last scattering of those that get out is as likely at every depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Obliquity {
    /// From the volume's centre to the detector, mm; at most 0: no corrections.
    pub(super) gap_mm: f64,
    /// Lengths in the detector's plane over those at the volume's centre.
    pub(super) magnification: f64,
    /// Effective attenuation of the row's primary signal, cm²/g.
    pub(super) attenuation: f64,
}

impl Obliquity {
    /// Exponent n of `(1 + d²/gap²)⁻ⁿ`, how scatter falls with the distance d of the foot of its way: n = 3/2 for the
    /// square of the distance and the slope, and μA/4 for the longer way through the half of A that is left on average.
    fn exponent(&self, areal_density: f64) -> f64 {
        1.5 + 0.25 * self.attenuation * areal_density
    }

    /// For the kernel at the distance r, mm. A pencil that hits the detector at x' is scattered about x'/M, M the
    /// magnification, and comes to x at the slope of x − x'/M instead of x − x'. With `q(d) = (1 + d²/gap²)ⁿ` the ratio
    /// `q(x − x')/q(x − x'/M)` is taken as K(x − x')·S(x')·T(x), which is exact for x = 0 and for x' = 0.
    pub(super) fn kernel(&self, r: f64, areal_density: f64) -> f64 {
        self.ratio(r, areal_density, 1.0, 1.0 / self.magnification)
    }

    /// S(x') · exp(f(A')) for a source at that distance from the detector's centre, mm.
    pub(super) fn source(&self, r: f64, areal_density: f64) -> f64 {
        let m = self.magnification;
        self.ratio(r, areal_density, 1.0 / m, 1.0 / (m * m)) * self.further(areal_density).exp()
    }

    /// T(x) · exp(−f(A)) for a target at that distance from the detector's centre, mm.
    pub(super) fn target(&self, r: f64, areal_density: f64) -> f64 {
        self.ratio(r, areal_density, 1.0 / self.magnification, 1.0) * (-self.further(areal_density)).exp()
    }

    fn ratio(&self, r: f64, areal_density: f64, above: f64, below: f64) -> f64 {
        if !(self.gap_mm > 0.0) {
            return 1.0;
        }
        let square = (r / self.gap_mm).powi(2);
        ((1.0 + above * square) / (1.0 + below * square)).powf(self.exponent(areal_density))
    }

    /// What the separable factor `exp(f(A') − f(A))` misses of `exp(−μ/2 (A'' − A'))`, for photons from a place of the areal
    /// density `here`, A', that leave the object where it is `leaving`, A'', towards a target behind `target`, A.
    pub(super) fn missed(&self, here: f64, leaving: f64, target: f64) -> f64 {
        let way = 0.5 * self.attenuation * (leaving - here);
        (self.further(target) - self.further(here) - way).exp()
    }

    /// The part of its way aside, between the volume's centre and the detector, that a photon goes within the object: A/2 of
    /// the gap, in which the pencil it leaves diverges by the magnification.
    pub(super) fn aside(&self, areal_density: f64) -> f64 {
        (areal_density * self.slope()).min(1.0)
    }

    /// 1/(g/cm²).
    fn slope(&self) -> f64 {
        if self.gap_mm > 0.0 { 0.5 * self.magnification / (0.1 * self.gap_mm) } else { 0.0 }
    }

    /// f(A): a photon that is scattered towards a thicker place of the object has a longer way out than in a slab, one
    /// towards a thinner place a shorter one. Half of the change of A lies on its way, as far as it gets aside in the object:
    /// f' = μ/2 · aside(A).
    fn further(&self, areal_density: f64) -> f64 {
        let (a, slope) = (areal_density, self.slope());
        0.5 * self.attenuation * if a * slope < 1.0 { 0.5 * a * a * slope } else { a - 0.5 / slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OBLIQUITY: Obliquity = Obliquity { gap_mm: 500.0, magnification: 1.5, attenuation: 0.2 };

    #[test]
    fn a_divergent_beam_scatters_as_steeply_as_its_pencils_foot_is_far() {
        let q = |r: f64, areal: f64| (1.0 + (r / 500.0).powi(2)).powf(1.5 + 0.05 * areal);
        for (areal, r) in [(0.0, 100.0), (20.0, 150.0), (40.0, 300.0)] {
            let to_centre =
                OBLIQUITY.kernel(r, areal) * OBLIQUITY.source(r, areal) * OBLIQUITY.target(0.0, areal);
            assert!((to_centre / (q(r, areal) / q(r / 1.5, areal)) - 1.0).abs() < 1e-12);
            let from_centre =
                OBLIQUITY.kernel(r, areal) * OBLIQUITY.source(0.0, areal) * OBLIQUITY.target(r, areal);
            assert!((from_centre - 1.0).abs() < 1e-12);
            let straight =
                OBLIQUITY.kernel(0.0, areal) * OBLIQUITY.source(r, areal) * OBLIQUITY.target(r, areal);
            // The product is not exact there.
            assert!(straight <= 1.0 && straight > 0.9, "{straight}");
        }
    }

    /// A cylinder's A² falls with the square of the distance from its axis, in cm at the object.
    #[test]
    fn the_way_out_of_a_cylinder_is_that_of_its_tangents() {
        let (radius, gap) = (15.0_f64, 50.0);
        let areal = |s: f64| 2.0 * (radius * radius - s * s).sqrt();
        for (s, y) in [(2.0, 1.0), (8.0, 7.0), (5.0, 6.5), (0.0, 2.0)] {
            let aside = OBLIQUITY.aside(areal(s));
            assert!((aside - 1.5 * 0.5 * areal(s) / gap).abs() < 1e-12);
            // Exact to first order in the way aside: half of dA/ds = −4s/A on the way.
            let exact = (-0.5 * 0.2 * (-4.0 * s / areal(s)) * aside * (y - s)).exp();
            let separable = (OBLIQUITY.further(areal(s)) - OBLIQUITY.further(areal(y))).exp();
            let missed = OBLIQUITY.missed(areal(s), areal(s + aside * (y - s)), areal(y));
            assert!((separable * missed / exact - 1.0).abs() < 0.01, "{s} to {y}");
        }
    }

    #[test]
    fn a_detector_in_front_of_the_centre_is_not_corrected() {
        let none = Obliquity { gap_mm: -10.0, ..OBLIQUITY };
        assert_eq!([none.kernel(90.0, 20.0), none.source(90.0, 20.0), none.target(90.0, 20.0)], [1.0; 3]);
    }
}
