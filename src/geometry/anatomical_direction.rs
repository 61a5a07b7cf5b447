//! Directions in a patient.

use glam::DVec3;

/// Towards −x and +x, −y and +y, −z and +z of LPS, as DICOM names them.
const LETTERS: [[char; 2]; 3] = [['R', 'L'], ['A', 'P'], ['F', 'H']];

/// tan 22.5°: where two components of a direction are compared, half way between one axis and the diagonal.
const REFINEMENT: f64 = std::f64::consts::SQRT_2 - 1.0;

/// Steps of a direction's largest component in which components are compared, so that rounding decides no tie.
const STEPS: f64 = 1e9;

/// A direction in a patient by its letters: towards the left L or the right R, the back (posterior) P or the front
/// (anterior) A, the head H or the feet F, the principal one first: `LA` is to the left, and also to the front.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AnatomicalDirection {
    /// Axis of the world and whether along it, the principal one first.
    towards: [Option<(usize, bool)>; 3],
}

impl AnatomicalDirection {
    /// Of a vector of any length in LPS. An axis has a letter where the component along it is at least tan 22.5° times the
    /// largest: in each plane of two axes the nearest of eight directions. Of components that are equal (to 1e-9 of the
    /// largest) the letter of x comes before that of y, and that of y before that of z. A vector that is zero or not finite
    /// has no letters.
    pub fn of(vector: DVec3) -> Self {
        let sizes = vector.abs();
        let largest = sizes.max_element();
        let in_steps = |ratio: f64| (ratio * STEPS).round() as i64;
        let mut axes = [0, 1, 2].map(|axis| (in_steps(sizes[axis] / largest), axis));
        // Stable: of equal ones the first stays the first.
        axes.sort_by_key(|(steps, _)| std::cmp::Reverse(*steps));
        let is_vector = largest > 0.0 && vector.is_finite();
        let has_letter = |steps| is_vector && steps >= in_steps(REFINEMENT);
        let towards = |(steps, axis)| has_letter(steps).then_some((axis, vector[axis] > 0.0));
        Self { towards: axes.map(towards) }
    }

    /// The direction from where this one leads to.
    #[must_use]
    pub fn opposite(self) -> Self {
        Self { towards: self.towards.map(|towards| towards.map(|(axis, along)| (axis, !along))) }
    }
}

/// The letters.
impl std::fmt::Display for AnatomicalDirection {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let letter = |&(axis, along): &(usize, bool)| LETTERS[axis][usize::from(along)];
        f.pad(&self.towards.iter().flatten().map(letter).collect::<String>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn letters(x: f64, y: f64, z: f64) -> String {
        AnatomicalDirection::of(DVec3::new(x, y, z)).to_string()
    }

    #[test]
    fn axes_have_their_letters_and_opposites_the_other_ones() {
        let axes = [(DVec3::X, "L", "R"), (DVec3::Y, "P", "A"), (DVec3::Z, "H", "F")];
        for (axis, along, against) in axes {
            let direction = AnatomicalDirection::of(0.3 * axis);
            assert_eq!(direction.to_string(), along);
            assert_eq!(direction.opposite().to_string(), against);
            assert_eq!(direction.opposite(), AnatomicalDirection::of(-0.3 * axis));
        }
        let oblique = AnatomicalDirection::of(DVec3::new(0.6, -0.8, 0.5));
        assert_eq!([oblique, oblique.opposite()].map(|d| d.to_string()), ["ALH", "PRF"]);
    }

    #[test]
    fn a_plane_has_eight_directions() {
        let names = ["L", "LP", "P", "PR", "R", "RA", "A", "AL"];
        for degrees in 0..360 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let mut own: Vec<char> = letters(cos, sin, 0.0).chars().collect();
            let mut nearest: Vec<char> = names[(2 * degrees as usize + 45) / 90 % 8].chars().collect();
            own.sort_unstable();
            nearest.sort_unstable();
            assert_eq!(own, nearest, "{degrees}°");
        }
        // The principal one comes first.
        assert_eq!(["LA", "AL"], [(1.0, -0.5), (0.5, -1.0)].map(|(x, y)| letters(x, y, 0.0)));
    }

    #[test]
    fn ties_are_broken_in_the_order_of_the_axes_whatever_the_rounding() {
        for degrees in [45.0_f64, 135.0, 225.0, 315.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            assert!(matches!(&letters(cos, sin, 0.0)[..1], "L" | "R"), "{degrees}");
            assert!(matches!(&letters(0.0, cos, sin)[..1], "A" | "P"), "{degrees}");
        }
        assert_eq!(letters(1.0, 1.0, 1.0), "LPH");
        assert_eq!(letters(1.0, -1.0 - 1e-12, 0.0), "LA");
        assert_eq!(letters(1.0, -1.0 - 1e-8, 0.0), "AL");
        // Half way between one letter and two: two.
        let (sin, cos) = 22.5_f64.to_radians().sin_cos();
        assert_eq!([letters(cos, sin, 0.0), letters(sin, cos, 0.0)], ["LP", "PL"]);
        assert_eq!(letters(cos, sin - 1e-8, 0.0), "L");
    }

    #[test]
    fn what_is_no_direction_has_no_letters() {
        for x in [0.0, f64::NAN, f64::INFINITY] {
            assert_eq!(letters(x, 0.0, 0.0), "");
        }
        assert_eq!(letters(1e-300, 0.0, 0.0), "L");
    }
}
