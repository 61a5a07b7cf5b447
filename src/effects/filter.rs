//! Filters between the tube and the patient.

use crate::effects::Sight;
use crate::error::{Error, Result};
use crate::physics::{EnergyGrid, MAX_ATTENUATION, MassAttenuation, Material};

/// Densities of solids, liquids and gases, g/cm³.
const DENSITIES: std::ops::RangeInclusive<f64> = 1e-6..=30.0;
/// Largest thickness, mm.
const MAX_THICKNESS: f64 = 1000.0;
/// Numbers of points of a bow-tie's profile.
const POINTS: std::ops::RangeInclusive<usize> = 2..=MAX_BOW_TIE_POINTS;
/// Most points of a bow-tie's profile.
pub const MAX_BOW_TIE_POINTS: usize = 1024;

/// A homogeneous body in the beam, before anything that is imaged.
#[derive(Debug, Clone, PartialEq)]
pub struct Filter {
    /// What it is made of, for people.
    pub name: String,
    /// Mass density, g/cm³: 1e-6 … 30.
    pub density: f64,
    /// Mass attenuation coefficients, cm²/g, one per energy of the spectrum: 0 … 1e9.
    pub coefficients: Vec<f64>,
    /// How much of it a ray crosses.
    pub profile: Profile,
}

/// The thickness of a filter. It stays where it is relative to source and detector.
#[derive(Debug, Clone, PartialEq)]
pub enum Profile {
    /// A slab across the detector's normal: at the angle θ to the normal a ray crosses mm/cos θ.
    Flat {
        /// Thickness, mm: 0 … 1000.
        mm: f64,
    },
    /// A bow-tie: the same at every height across the columns' direction (extruded), along which its thickness follows
    /// the fan angle. That is the angle, seen from the source, between the detector's normal and the ray's projection
    /// onto the plane of normal and columns' direction, growing as i does. `mm` is what a ray in that plane crosses; a
    /// ray at the angle ε to the plane crosses mm/cos ε.
    BowTie {
        /// Fan angles, degrees, strictly ascending, above −90 and below 90; 2 … 1024 of them.
        degrees: Vec<f64>,
        /// What a ray in the plane crosses there, mm: 0 … 1000, one per angle. Linear in between; beyond the first and
        /// the last angle as there.
        mm: Vec<f64>,
    },
}

impl Filter {
    /// A filter of any material; see the fields, which `validate` checks.
    pub fn new(name: impl Into<String>, density: f64, coefficients: Vec<f64>, profile: Profile) -> Self {
        Self { name: name.into(), density, coefficients, profile }
    }

    /// A filter of a built-in material, with its usual density (`physics/tables/materials.csv`) and coefficients.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown material, for energies that are not tabulated (whole keV in 15 … 150), and as
    /// `validate`.
    pub fn named(material: &str, grid: EnergyGrid, profile: Profile) -> Result<Self> {
        let density = Material::named(material)?.reference_density();
        let coefficients = MassAttenuation::named(&[material], grid)?.coefficients(0).to_vec();
        let filter = Self::new(material, density, coefficients, profile);
        filter.validate(&grid).map(|()| filter)
    }

    /// Checks every range, and that there is one coefficient per energy of `grid`.
    ///
    /// # Errors
    /// `InvalidArgument` with the name of the field (`density`, `coefficients[7]`, `profile.mm[2]`), to which the caller
    /// adds which filter it is.
    pub fn validate(&self, grid: &EnergyGrid) -> Result<()> {
        check_density("density", self.density)?;
        let valid = format!("0 … {MAX_ATTENUATION:e} cm²/g");
        grid.check_values("coefficients", &self.coefficients, (0.0..=MAX_ATTENUATION, &valid))?;
        self.profile.validate().map_err(|error| error.of("profile"))
    }

    /// What a ray crosses, g/cm².
    pub(crate) fn areal_density(&self, sight: &Sight) -> f64 {
        const CM_PER_MM: f64 = 0.1;
        self.density * CM_PER_MM * self.profile.path_mm(sight)
    }
}

/// Checks a mass density, g/cm³.
pub(super) fn check_density(argument: &str, density: f64) -> Result<()> {
    if DENSITIES.contains(&density) {
        return Ok(());
    }
    let valid = format!("{:e} … {} g/cm³", DENSITIES.start(), DENSITIES.end());
    Err(Error::invalid(argument, density, valid))
}

impl Profile {
    fn validate(&self) -> Result<()> {
        match self {
            Self::Flat { mm } => check_thickness("mm", *mm),
            Self::BowTie { degrees, mm } => {
                if !POINTS.contains(&degrees.len()) {
                    let valid = format!("{} … {} angles", POINTS.start(), POINTS.end());
                    return Err(Error::invalid("degrees", format!("{} angles", degrees.len()), valid));
                }
                if mm.len() != degrees.len() {
                    let valid = format!("one per angle, {}", degrees.len());
                    return Err(Error::invalid("mm", format!("{} values", mm.len()), valid));
                }
                for (k, angle) in degrees.iter().enumerate() {
                    let before = if k == 0 { -90.0 } else { degrees[k - 1] };
                    if !(*angle > before && *angle < 90.0) {
                        let valid = "above −90, below 90 degrees, and each above the one before";
                        return Err(Error::invalid(format!("degrees[{k}]"), angle, valid));
                    }
                }
                let mut all = mm.iter().enumerate();
                all.try_for_each(|(k, mm)| check_thickness(&format!("mm[{k}]"), *mm))
            }
        }
    }

    /// The length of a ray inside, mm.
    fn path_mm(&self, sight: &Sight) -> f64 {
        match self {
            Self::Flat { mm } => mm / sight.normal,
            Self::BowTie { degrees, mm } => {
                let fan = sight.column.atan2(sight.normal).to_degrees();
                // Of a unit vector: the cosine of its angle to the plane.
                interpolated(degrees, mm, fan) / sight.column.hypot(sight.normal)
            }
        }
    }
}

fn check_thickness(argument: &str, mm: f64) -> Result<()> {
    if (0.0..=MAX_THICKNESS).contains(&mm) {
        return Ok(());
    }
    Err(Error::invalid(argument, mm, format!("0 … {MAX_THICKNESS} mm")))
}

/// The value at `x` of the lines between points with ascending abscissae `xs`; beyond the ends as there.
fn interpolated(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let above = xs.partition_point(|known| *known <= x);
    if above == 0 || above == xs.len() {
        return ys[above.saturating_sub(1)];
    }
    let part = (x - xs[above - 1]) / (xs[above] - xs[above - 1]);
    ys[above - 1] + part * (ys[above] - ys[above - 1])
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    const GRID: EnergyGrid = EnergyGrid::SPECIFICATION;

    fn of(profile: Profile) -> Filter {
        Filter::new("stuff", 2.0, vec![1.0; GRID.count()], profile)
    }

    fn bow_tie(points: &[(f64, f64)]) -> Profile {
        let (degrees, mm) = points.iter().copied().unzip();
        Profile::BowTie { degrees, mm }
    }

    #[test]
    fn a_flat_filter_is_as_long_as_its_obliquity() {
        let filter = of(Profile::Flat { mm: 5.0 });
        // 5 mm of 2 g/cm³ are 1 g/cm²; at 60° to the normal twice as much, in whatever direction.
        assert!((filter.areal_density(&Sight::along(DVec3::Z)) - 1.0).abs() < 1e-15);
        for (sin, cos) in [0.0, 40.0, 200.0].map(|degrees: f64| degrees.to_radians().sin_cos()) {
            let sight = Sight::along(DVec3::new(3.0_f64.sqrt() * cos, 3.0_f64.sqrt() * sin, 1.0));
            assert!((filter.areal_density(&sight) - 2.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_bow_tie_of_a_slab_is_the_slab() {
        let degrees: Vec<f64> = (-50..=50).map(f64::from).collect();
        let mm = degrees.iter().map(|angle| 5.0 / angle.to_radians().cos()).collect();
        let (flat, shaped) = (of(Profile::Flat { mm: 5.0 }), of(Profile::BowTie { degrees, mm }));
        for angle in [-50.0_f64, -31.0, 0.0, 8.0, 49.0] {
            for height in [0.0, -0.3, 2.0] {
                let (sin, cos) = angle.to_radians().sin_cos();
                let sight = Sight::along(DVec3::new(sin, height, cos));
                let ratio = shaped.areal_density(&sight) / flat.areal_density(&sight);
                assert!((ratio - 1.0).abs() < 1e-13, "{angle}°, height {height}: {ratio}");
            }
        }
    }

    #[test]
    fn a_bow_tie_is_linear_between_its_points_and_level_beyond() {
        let filter = of(bow_tie(&[(-10.0, 30.0), (0.0, 2.0), (20.0, 42.0)]));
        for (fan, mm) in
            [(-60.0, 30.0), (-10.0, 30.0), (-2.5, 9.0), (0.0, 2.0), (5.0, 12.0), (20.0, 42.0), (89.0, 42.0)]
        {
            let (sin, cos) = f64::to_radians(fan).sin_cos();
            let crossed = filter.areal_density(&Sight { column: sin, row: 0.0, normal: cos });
            assert!((crossed - 0.2 * mm).abs() < 1e-12, "{fan}°: {crossed}");
        }
    }

    #[test]
    fn a_named_filter_halves_the_beam_at_its_half_value_layer() {
        // NIST (Hubbell & Seltzer): aluminium at 60 keV 0.2778 cm²/g, density 2.699 g/cm³: ln 2/0.7498 cm.
        let layer = Profile::Flat { mm: 10.0 * std::f64::consts::LN_2 / (0.2778 * 2.699) };
        let filter = Filter::named("aluminium", GRID, layer.clone()).unwrap();
        let index = GRID.index_of(60.0).unwrap();
        let passed = (-filter.coefficients[index] * filter.areal_density(&Sight::along(DVec3::Z))).exp();
        assert!((passed - 0.5).abs() < 1e-3, "{passed}");
        let message = Filter::named("unobtainium", GRID, layer.clone()).unwrap_err().to_string();
        assert!(message.contains("unobtainium") && message.contains("aluminium"), "{message}");
        assert!(Filter::named("copper", EnergyGrid::single(60.5).unwrap(), layer).is_err());
        assert!(Filter::named("copper", GRID, Profile::Flat { mm: -1.0 }).is_err());
    }

    #[test]
    fn refusals_name_the_field() {
        let good = of(Profile::Flat { mm: 0.0 });
        let coefficient = |value| {
            let mut coefficients = vec![0.5; 136];
            coefficients[7] = value;
            Filter { coefficients, ..good.clone() }
        };
        let many: Vec<_> = (0..1025).map(|n| (f64::from(n) * 0.05, 1.0)).collect();
        for (filter, message) in [
            (Filter { density: 0.0, ..good.clone() }, "density is 0;"),
            (Filter { density: 31.0, ..good.clone() }, "density is 31;"),
            (Filter { density: f64::NAN, ..good.clone() }, "density is NaN;"),
            (
                Filter { coefficients: vec![1.0; 135], ..good.clone() },
                "coefficients is 135 values; valid: one value",
            ),
            (coefficient(-1.0), "coefficients[7] is -1;"),
            (coefficient(f64::NAN), "coefficients[7] is NaN;"),
            (coefficient(f64::INFINITY), "coefficients[7] is inf;"),
            (of(Profile::Flat { mm: f64::NAN }), "profile.mm is NaN;"),
            (of(Profile::Flat { mm: 1000.5 }), "profile.mm is 1000.5;"),
            (of(bow_tie(&[(0.0, 1.0)])), "profile.degrees is 1 angles;"),
            (of(bow_tie(&many)), "profile.degrees is 1025 angles;"),
            (of(bow_tie(&[(-90.0, 1.0), (0.0, 1.0)])), "profile.degrees[0] is -90;"),
            (of(bow_tie(&[(0.0, 1.0), (90.0, 1.0)])), "profile.degrees[1] is 90;"),
            (of(bow_tie(&[(0.0, 1.0), (0.0, 1.0)])), "profile.degrees[1] is 0;"),
            (of(bow_tie(&[(0.0, 1.0), (f64::NAN, 1.0)])), "profile.degrees[1] is NaN;"),
            (of(bow_tie(&[(0.0, 1.0), (1.0, -1.0)])), "profile.mm[1] is -1;"),
            (of(Profile::BowTie { degrees: vec![0.0, 1.0], mm: vec![0.0] }), "profile.mm is 1 values;"),
        ] {
            let error = filter.validate(&GRID).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
        assert_eq!(good.validate(&GRID), Ok(()));
        assert_eq!(of(bow_tie(&many[..1024])).validate(&GRID), Ok(()));
    }
}
