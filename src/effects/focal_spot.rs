//! The size of the X-ray source.

use crate::effects::Taps;
use crate::error::{Error, Result};

/// Largest side of a focal spot, mm.
const MAX_SIDE_MM: f64 = 10.0;
/// Most sub-sources along one side.
const MAX_COUNT: usize = 32;
/// Most samples of the detector from the shadow of one sub-source to that of the next.
const SHADOW_SPACING: f64 = 0.5;
/// Its fields as errors call them.
const NAMES: [&str; 2] = ["scene.effects.focal_spot.width_mm", "scene.effects.focal_spot.height_mm"];

/// A rectangle, centred at the source and parallel to the detector, that emits uniformly.
///
/// Tubes are sold by IEC 60336's nominal value, which is less than what may be there: 0.6 stands for widths up to 0.9 mm
/// and lengths up to 1.3 mm. Real spots differ from a uniform one, mostly by two bright ridges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FocalSpot {
    /// Its side in the direction from one column of the detector to the next, mm.
    pub width_mm: f64,
    /// Its side in the direction from one row of the detector to the next, mm.
    pub height_mm: f64,
}

impl FocalSpot {
    fn sides(self) -> [f64; 2] {
        [self.width_mm, self.height_mm]
    }

    /// Checks that both sides are within 0 … 10 mm, and one of them at least above 0.
    pub fn validate(self) -> Result<()> {
        for (name, side) in NAMES.into_iter().zip(self.sides()) {
            if !(0.0..=MAX_SIDE_MM).contains(&side) {
                return Err(Error::invalid(name, side, "0 … 10 mm"));
            }
        }
        if self.sides() == [0.0; 2] {
            let valid = "above 0 mm where the height is 0: a point is what a scene without a focal spot has";
            return Err(Error::invalid(NAMES[0], self.width_mm, valid));
        }
        Ok(())
    }

    /// The middles of `count` = columns × rows equal cells of it, in mm from its centre along the detector's columns and
    /// rows as the fields have them, and each one's part of the emission; row by row. All come in pairs opposite to the
    /// centre.
    pub(crate) fn offsets(self, count: [usize; 2]) -> Vec<([f64; 2], f64)> {
        let part = 1.0 / (count[0] * count[1]) as f64;
        let sides = self.sides();
        // An odd numerator, so that opposite offsets differ by their sign only.
        let offset = |axis: usize, k: usize| {
            let twice = (2 * k + 1) as f64 - count[axis] as f64;
            sides[axis] * (twice / (2 * count[axis]) as f64)
        };
        let cells = (0..count[1]).flat_map(|j| (0..count[0]).map(move |i| [i, j]));
        cells.map(|[i, j]| ([offset(0, i), offset(1, j)], part)).collect()
    }

    /// Width and height, on the detector, of the penumbra of an object: f (M − 1), where the magnification M is the distance
    /// from source to detector over that from source to object (Barrett & Swindell, Radiological Imaging, 1981, ch. 4).
    pub(crate) fn blur_mm(self, source_detector_mm: f64, source_object_mm: f64) -> [f64; 2] {
        self.sides().map(|side| side * (source_detector_mm - source_object_mm) / source_object_mm)
    }

    /// Kernels along columns and rows that blur an image as the spot does for objects at one distance from the source;
    /// `pitch_mm` are the distances of the image's samples along columns and rows on the detector.
    /// A penumbra narrower than a sample does nothing.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(crate) fn taps(
        self,
        source_detector_mm: f64,
        source_object_mm: f64,
        pitch_mm: [f64; 2],
    ) -> Result<[Taps; 2]> {
        let blur = self.blur_mm(source_detector_mm, source_object_mm);
        Ok([Taps::boxcar(blur[0] / pitch_mm[0])?, Taps::boxcar(blur[1] / pitch_mm[1])?])
    }

    /// Numbers of sub-sources along width and height, two at least, whose shadows are at most half a sample apart, for penumbrae of at most
    /// `blur_px` samples of the detector along columns and rows: those of the object that is nearest to the source.
    ///
    /// # Errors
    /// `InvalidArgument` where that takes more than 32 along one side.
    pub(crate) fn counts(self, blur_px: [f64; 2]) -> Result<[usize; 2]> {
        let count = |axis: usize| {
            let (side, blur, most) = (self.sides()[axis], blur_px[axis], MAX_COUNT as f64 * SHADOW_SPACING);
            if !(blur <= most) {
                let valid = format!(
                    "at most {:.3} mm at the magnification of what is nearest to the source: its penumbra is {blur:.1} \
                     pixels wide, and at most {most} can be simulated; a smaller focal spot, a greater distance from \
                     source to object, or larger pixels",
                    side * most / blur
                );
                return Err(Error::invalid(NAMES[axis], side, valid));
            }
            // Two already have three quarters of the spot's variance; one has none.
            Ok(if blur == 0.0 { 1 } else { ((blur / SHADOW_SPACING).ceil() as usize).max(2) })
        };
        Ok([count(0)?, count(1)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Plane, convolved};

    const SPOT: FocalSpot = FocalSpot { width_mm: 0.6, height_mm: 1.3 };

    #[test]
    fn the_penumbra_of_a_knife_edge_is_a_ramp() {
        // Magnification 3: penumbrae of 1.2 and 2.6 mm, that is 3 columns and 13 rows.
        let (distances, pitch) = ([1500.0, 500.0], [0.4, 0.2]);
        let blur = SPOT.blur_mm(distances[0], distances[1]);
        assert!((blur[0] - 1.2).abs() < 1e-15 && (blur[1] - 2.6).abs() < 1e-15);
        let taps = SPOT.taps(distances[0], distances[1], pitch).expect("memory");
        for axis in [0, 1] {
            let edge = Plane::of_points([41, 41], |i, j| f64::from(u8::from([i, j][axis] > 20)));
            let seen = convolved(&edge, &taps[0], &taps[1]).expect("memory");
            for n in 0..41 {
                let value = if axis == 0 { seen.row(7)[n] } else { seen.row(n)[7] };
                // The edge is half way between samples 20 and 21.
                let from_edge = (n as f64 - 20.5) * pitch[axis];
                let ramp = (0.5 + from_edge / blur[axis]).clamp(0.0, 1.0);
                assert!((value - ramp).abs() < 1e-14, "axis {axis}, sample {n}: {value} for {ramp}");
            }
        }
    }

    #[test]
    fn the_sub_sources_penumbra_is_that_ramp_in_steps() {
        let [far, near] = [1500.0, 500.0];
        let count = [5, 9];
        for (axis, blur) in SPOT.blur_mm(far, near).into_iter().enumerate() {
            let steps = count[axis] as f64;
            for position in (-20..=20).map(|k| 0.0713 * f64::from(k) * blur) {
                // A knife covers all below the axis, at `near`: who sees the place `position` on the detector?
                let height = |source: f64| source + (position - source) * near / far;
                let lit = SPOT.offsets(count).into_iter().filter(|(offset, _)| height(offset[axis]) > 0.0);
                let seen: f64 = lit.map(|(_, part)| part).sum();
                let ramp = (0.5 + position / blur).clamp(0.0, 1.0);
                assert!((seen - ramp).abs() <= 0.5 / steps + 1e-12, "axis {axis}: {seen} for {ramp}");
            }
        }
    }

    #[test]
    fn sub_sources_lie_evenly_about_the_centre() {
        let offsets = SPOT.offsets([4, 3]);
        assert!((offsets.iter().map(|(_, part)| part).sum::<f64>() - 1.0).abs() < 1e-15);
        for (a, b) in offsets.iter().zip(offsets.iter().rev()) {
            assert_eq!(a.0.map(|x| -x), b.0);
        }
        // Σ x² of the middles of n cells: f²/12 (1 − 1/n²).
        for (axis, (side, n)) in [(0.6, 4.0), (1.3, 3.0)].into_iter().enumerate() {
            let variance: f64 = offsets.iter().map(|(offset, part)| part * offset[axis] * offset[axis]).sum();
            let exact = side * side / 12.0 * (1.0 - 1.0 / (n * n));
            assert!((variance / exact - 1.0).abs() < 1e-14);
        }
        assert_eq!(SPOT.offsets([1, 1]), [([0.0, 0.0], 1.0)]);
    }

    #[test]
    fn shadows_are_half_a_sample_apart_or_it_is_refused() {
        assert_eq!(SPOT.counts([0.0, 0.5]), Ok([1, 2]));
        assert_eq!(SPOT.counts([0.51, 16.0]), Ok([2, 32]));
        assert_eq!(SPOT.counts([3.2, 1.0]), Ok([7, 2]));
        let message = SPOT.counts([1.0, 20.8]).expect_err("too many").to_string();
        assert!(
            message.starts_with("scene.effects.focal_spot.height_mm is 1.3; valid: at most 1.000 mm"),
            "{message}"
        );
        assert!(message.contains("20.8 pixels"), "{message}");
        for blur in [f64::NAN, f64::INFINITY] {
            assert!(SPOT.counts([blur, 1.0]).is_err());
        }
    }

    #[test]
    fn sides_outside_their_range_are_refused() {
        let spot = |width_mm: f64, height_mm: f64| FocalSpot { width_mm, height_mm }.validate();
        assert!(spot(0.0, 10.0).is_ok() && spot(0.3, 0.0).is_ok());
        for (width, height, name) in [
            (0.0, 0.0, "width_mm"),
            (f64::NAN, 1.0, "width_mm"),
            (1.0, f64::NAN, "height_mm"),
            (-0.1, 1.0, "width_mm"),
            (1.0, 10.1, "height_mm"),
        ] {
            let message = spot(width, height).expect_err("invalid").to_string();
            assert!(message.starts_with(&format!("scene.effects.focal_spot.{name} is ")), "{message}");
        }
    }
}
