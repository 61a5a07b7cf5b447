//! CT numbers to mass density.

use std::sync::LazyLock;

use crate::error::{Error, Result};
use crate::physics::tables::{number, records, unknown};

/// Lowest CT number with a density; what is below is padding and gets the density of this value.
pub const MIN_HU: f64 = -1000.0;
/// Highest CT number with a density, the ceiling of 12-bit scanners.
pub const MAX_HU: f64 = 3071.0;

static CURVES: LazyLock<Vec<Calibration>> = LazyLock::new(|| {
    let mut curves: Vec<Calibration> = Vec::new();
    for row in records(include_str!("tables/hu_density_segments.csv")).skip(1) {
        if curves.last().is_none_or(|curve| curve.name != row[0]) {
            curves.push(Calibration { name: row[0].into(), segments: Vec::new() });
        }
        let [first_hu, end_hu, intercept, slope] = [1, 2, 3, 4].map(|column| number(row[column]));
        let segment = DensitySegment { first_hu, end_hu, intercept, slope };
        curves.last_mut().expect("pushed above").segments.push(segment);
    }
    curves
});

/// Density = `intercept` + `slope`·HU in g/cm³, for `first_hu` ≤ HU < `end_hu`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DensitySegment {
    /// First CT number of the segment, HU.
    pub first_hu: f64,
    /// First CT number after the segment, HU.
    pub end_hu: f64,
    /// Density at 0 HU, g/cm³.
    pub intercept: f64,
    /// g/cm³ per HU.
    pub slope: f64,
}

/// A piecewise linear curve from CT numbers (HU) to mass density (g/cm³).
///
/// | name | curve |
/// |---|---|
/// | `water_anchored` | 1 + HU/1000 up to water, then through cortical bone (1641.885 HU, 1.92 g/cm³); continuous |
/// | `schneider2000` | Schneider et al. 2000 as tabulated by TOPAS; 1.018 at 0 HU, jumps, not monotone |
/// | `bilinear_1p03` | 1.03 at 0 HU, two lines, as in DeepDRR; continuous |
/// | `linear` | 1 + HU/1000: bone too dense, but what most projectors assume |
#[derive(Debug, Clone, PartialEq)]
pub struct Calibration {
    name: String,
    segments: Vec<DensitySegment>,
}

impl Calibration {
    /// Name of the default curve, the one that gives water its density.
    pub const DEFAULT: &'static str = "water_anchored";

    /// A curve of one's own, such as a scanner's calibration. The segments follow each other in ascending order,
    /// without gaps, from [`MIN_HU`] or below to above [`MAX_HU`].
    ///
    /// # Errors
    /// `InvalidArgument` names the first segment that is not finite, is empty, or does not begin where the one before
    /// it ends; or the end that is missing.
    pub fn new(name: impl Into<String>, segments: Vec<DensitySegment>) -> Result<Self> {
        let mut covered = MIN_HU;
        for (i, s) in segments.iter().enumerate() {
            if ![s.first_hu, s.end_hu, s.intercept, s.slope].iter().all(|v| v.is_finite()) {
                return Err(Error::invalid(format!("segments[{i}]"), format!("{s:?}"), "finite numbers"));
            }
            let begins_right = if i == 0 { s.first_hu <= covered } else { s.first_hu == covered };
            if !begins_right {
                let valid = if i == 0 { "at most" } else { "the end before it," };
                let argument = format!("segments[{i}].first_hu");
                return Err(Error::invalid(argument, s.first_hu, format!("{valid} {covered} HU")));
            }
            if s.end_hu <= s.first_hu {
                let valid = format!("above first_hu, {} HU", s.first_hu);
                return Err(Error::invalid(format!("segments[{i}].end_hu"), s.end_hu, valid));
            }
            covered = s.end_hu;
        }
        if covered <= MAX_HU {
            return Err(Error::invalid("segments, last end_hu", covered, format!("above {MAX_HU} HU")));
        }
        Ok(Self { name: name.into(), segments })
    }

    /// A built-in curve.
    ///
    /// # Errors
    /// `InvalidArgument` for an unknown name.
    pub fn named(name: &str) -> Result<Self> {
        let curve = CURVES.iter().find(|curve| curve.name == name);
        curve.cloned().ok_or_else(|| unknown("calibration", name, &Self::names()))
    }

    /// Names of the built-in curves.
    pub fn names() -> Vec<&'static str> {
        CURVES.iter().map(|curve| curve.name.as_str()).collect()
    }

    /// The name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The segments, ascending.
    pub fn segments(&self) -> &[DensitySegment] {
        &self.segments
    }

    /// Mass density in g/cm³, at least 0, of a CT number, which is first limited to [`MIN_HU`] … [`MAX_HU`]: padding
    /// such as −2048 is no tissue and must not give a negative density. NaN gives NaN.
    pub fn density(&self, hu: f64) -> f64 {
        if hu.is_nan() {
            return hu;
        }
        let hu = hu.clamp(MIN_HU, MAX_HU);
        // The last segment that begins at or below: `new` made sure that one does.
        let index = self.segments.partition_point(|segment| segment.first_hu <= hu) - 1;
        let segment = self.segments[index];
        (segment.intercept + segment.slope * hu).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn density(name: &str, hu: f64) -> f64 {
        Calibration::named(name).unwrap().density(hu)
    }

    #[test]
    fn the_default_anchors_air_water_and_bone() {
        let curve = Calibration::named(Calibration::DEFAULT).unwrap();
        assert_eq!(curve.density(0.0), 1.0);
        assert_eq!(curve.density(-1000.0), 0.0);
        assert!((curve.density(-500.0) - 0.5).abs() < 1e-15);
        // Predicted CT number of cortical bone at 120 kVp, to 0.001 HU.
        assert!((curve.density(1641.885) - 1.92).abs() < 1e-6);
    }

    #[test]
    fn padding_is_vacuum_and_the_ceiling_holds() {
        for name in Calibration::names() {
            let curve = Calibration::named(name).unwrap();
            for padding in [-1000.5, -1024.0, -2048.0, -3024.0, -32768.0, f64::NEG_INFINITY] {
                assert_eq!(curve.density(padding), curve.density(-1000.0), "{name} at {padding}");
            }
            for above in [3071.5, 4095.0, 32767.0, f64::INFINITY] {
                assert_eq!(curve.density(above), curve.density(3071.0), "{name} at {above}");
            }
            assert!(curve.density(f64::NAN).is_nan());
        }
        assert_eq!(density("water_anchored", -2048.0), 0.0);
        assert_eq!(density("water_anchored", -32768.0), 0.0);
    }

    #[test]
    fn schneider_is_itself() {
        assert_eq!(density("schneider2000", 0.0), 1.018);
        assert_eq!(density("schneider2000", 18.25), 1.03);
        assert_eq!(density("schneider2000", 3000.0), 4.54);
        assert!((density("schneider2000", -1000.0) - 0.00121).abs() < 1e-12);
        // It falls at 101 HU, where the value belongs to the segment that begins there, and just below to the other.
        assert!((density("schneider2000", 101.0) - (1.017 + 0.000_592 * 101.0)).abs() < 1e-15);
        assert!((density("schneider2000", 100.999) - (1.003 + 0.001_169 * 100.999)).abs() < 1e-15);
    }

    #[test]
    fn continuous_curves_are_continuous_and_rise() {
        for name in ["water_anchored", "bilinear_1p03", "linear"] {
            let samples: Vec<_> = (-10000..=30710).map(|i| density(name, f64::from(i) / 10.0)).collect();
            // At most 0.00103 g/cm³ per HU, a tenth of a HU apart.
            assert!(samples.windows(2).all(|w| w[1] > w[0] && w[1] - w[0] < 1.04e-4), "{name}");
        }
        assert_eq!(density("bilinear_1p03", 0.0), 1.03);
    }

    #[test]
    fn built_in_curves_would_pass_as_ones_own() {
        for name in Calibration::names() {
            let curve = Calibration::named(name).unwrap();
            assert_eq!(Calibration::new(name, curve.segments().to_vec()), Ok(curve));
        }
        let message = Calibration::named("water").unwrap_err().to_string();
        assert!(message.contains("water_anchored, bilinear_1p03"), "{message}");
    }

    #[test]
    fn a_curve_of_ones_own_never_goes_below_zero() {
        let line = DensitySegment { first_hu: -2000.0, end_hu: 4000.0, intercept: 0.9, slope: 0.001 };
        let curve = Calibration::new("own", vec![line]).unwrap();
        assert_eq!(curve.density(-950.0), 0.0);
        assert_eq!(curve.density(100.0), 1.0);
    }

    #[test]
    fn refusals_name_the_segment() {
        let segment = |first_hu, end_hu| DensitySegment { first_hu, end_hu, intercept: 1.0, slope: 0.0 };
        for (segments, part) in [
            (vec![], "last end_hu"),
            (vec![segment(-1000.0, 3071.0)], "last end_hu"),
            (vec![segment(-999.0, 3072.0)], "segments[0].first_hu is -999"),
            (vec![segment(0.0, 3072.0), segment(-1000.0, 0.0)], "segments[0].first_hu is 0"),
            (vec![segment(-1000.0, 0.0), segment(1.0, 3072.0)], "segments[1].first_hu is 1"),
            (vec![segment(-1000.0, -1000.0), segment(-1000.0, 3072.0)], "segments[0].end_hu"),
            (vec![segment(-1000.0, f64::NAN)], "segments[0]"),
        ] {
            let message = Calibration::new("own", segments).unwrap_err().to_string();
            assert!(message.contains(part), "{message}");
        }
    }
}
