//! Where the sides of an image lie in the patient.

use crate::geometry::{AnatomicalDirection, DetectorPose};

/// Where an image's rows and columns lead in the patient: DICOM's Patient Orientation (0020,0020), PS3.3 C.7.6.1.1.1. It
/// prints as that attribute's value, the row direction first: `L\F` is a radiograph with the patient's left at the right
/// edge and the feet at the bottom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PatientOrientation {
    /// Along a row, in which the column's number grows: what the right edge shows.
    pub row: AnatomicalDirection,
    /// Along a column, in which the row's number grows: what the bottom edge shows, where row 0 is at the top.
    pub column: AnatomicalDirection,
}

impl PatientOrientation {
    /// Of the images of a detector, stored from row 0 on.
    pub fn of(pose: &DetectorPose) -> Self {
        Self {
            row: AnatomicalDirection::of(pose.column_step),
            column: AnatomicalDirection::of(pose.row_step),
        }
    }

    /// Of the same image with its last row first.
    #[must_use]
    pub fn upside_down(self) -> Self {
        Self { column: self.column.opposite(), ..self }
    }

    /// What is at the left, the right, the top and the bottom edge of an image with row 0 at the top.
    pub fn edges(self) -> [AnatomicalDirection; 4] {
        [self.row.opposite(), self.row, self.column.opposite(), self.column]
    }
}

/// Row direction, backslash, column direction.
impl std::fmt::Display for PatientOrientation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}\\{}", self.row, self.column)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// The view of the C-arm at an angle, turned so that the head is up: its rows lead to the head.
    fn upright(angle_degrees: f64) -> PatientOrientation {
        let pose = DetectorPose::c_arm(DVec3::ZERO, angle_degrees, 1000.0, 1500.0, 1.0, [9, 9]);
        PatientOrientation::of(&pose).upside_down()
    }

    #[test]
    fn radiographs_of_a_head_first_supine_patient_have_the_letters_of_the_textbook() {
        // From the front, as if the reader faced the patient; from the left side (the detector at the right one), from the
        // back and from the right side, as the source sees them.
        let views = [(0.0, r"L\F"), (90.0, r"P\F"), (180.0, r"R\F"), (270.0, r"A\F")];
        for (angle, expected) in views {
            assert_eq!(upright(angle).to_string(), expected, "{angle}°");
        }
        // The stereo pair is frontal, obliques have two letters.
        assert_eq!([-6.0, 6.0].map(|angle| upright(angle).to_string()), [r"L\F"; 2]);
        assert_eq!([-45.0, 30.0].map(|angle| upright(angle).to_string()), [r"LA\F", r"LP\F"]);
    }

    #[test]
    fn edges_stand_opposite_each_other() {
        let edges = |orientation: PatientOrientation| orientation.edges().map(|edge| edge.to_string());
        assert_eq!(edges(upright(0.0)), ["R", "L", "H", "F"]);
        assert_eq!(edges(upright(-30.0).upside_down()), ["RP", "LA", "F", "H"]);
    }

    #[test]
    fn the_letters_are_those_of_the_detector_s_steps() {
        let pose = DetectorPose {
            source: DVec3::new(0.0, 0.0, 500.0),
            first_pixel: DVec3::new(1.0, -1.0, -500.0),
            column_step: DVec3::new(-2.0, -1.0, 0.0),
            row_step: DVec3::new(0.0, 0.3, 0.1),
        };
        assert_eq!(PatientOrientation::of(&pose).to_string(), r"RA\P");
    }
}
