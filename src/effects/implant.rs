//! Implants: solids of known shape and material that are there instead of what the CT shows.

mod shape;

use glam::DVec3;

pub use shape::{ImplantShape, MAX_SCREW_SECTIONS, Section};

use crate::effects::filter::check_density;
use crate::error::{Error, Result};

/// A homogeneous solid in the patient, sharper than voxels and free of the artefacts of metal. Where it is the CT does not
/// count; where several are the last one does.
#[derive(Debug, Clone, PartialEq)]
pub struct Implant {
    /// Where it is, world mm.
    pub shape: ImplantShape,
    /// What it is made of: an index into the scene's materials.
    pub material: u8,
    /// Mass density, g/cm³: 1e-6 … 30.
    pub density: f64,
}

impl Implant {
    /// Checks every range; `materials` is how many the scene has, `index` the place in the scene's list of implants.
    ///
    /// # Errors
    /// `InvalidArgument` with the field as `scene.effects.implants[index].…`.
    pub fn validate(&self, materials: usize, index: usize) -> Result<()> {
        let implant = format!("scene.effects.implants[{index}]");
        if usize::from(self.material) >= materials {
            let valid = format!("an index into the scene's materials, below {materials}");
            return Err(Error::invalid(format!("{implant}.material"), self.material, valid));
        }
        check_density(&format!("{implant}.density"), self.density)?;
        self.shape.validate().map_err(|error| error.of(&format!("{implant}.shape")))
    }
}

/// A part of a line inside one implant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// From and to, parameters of the line: the smaller one first.
    pub span: [f64; 2],
    /// Which implant of the list.
    pub implant: usize,
}

/// The parts of the line `origin + t * direction`, t within `limits`, that are inside valid implants: ascending,
/// disjoint up to their ends, none of no length. Where implants overlap the last one counts.
///
/// t is in units of the direction's length; a far origin costs no more digits than t has.
pub(crate) fn pieces(implants: &[Implant], origin: DVec3, direction: DVec3, limits: [f64; 2]) -> Vec<Piece> {
    let mut pieces: Vec<Piece> = Vec::new();
    for (implant, solid) in implants.iter().enumerate() {
        for [enter, leave] in solid.shape.intervals(origin, direction) {
            let span = [enter.max(limits[0]), leave.min(limits[1])];
            if span[0] < span[1] {
                pieces = pieces.into_iter().flat_map(|piece| piece.outside(span)).collect();
                pieces.push(Piece { span, implant });
            }
        }
    }
    pieces.sort_by(|a, b| a.span[0].total_cmp(&b.span[0]));
    pieces
}

impl Piece {
    /// What is left of it before and after another span.
    fn outside(self, [enter, leave]: [f64; 2]) -> impl Iterator<Item = Self> {
        let [start, end] = self.span;
        let parts = [[start, end.min(enter)], [start.max(leave), end]];
        parts.into_iter().filter(|[a, b]| a < b).map(move |span| Self { span, ..self })
    }
}

#[cfg(test)]
mod tests {
    use glam::DMat3;

    use super::*;

    const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    fn of(shape: ImplantShape) -> Implant {
        Implant { shape, material: 1, density: 4.5 }
    }

    fn ball(x: f64, radius: f64) -> Implant {
        of(ImplantShape::Sphere { centre: DVec3::new(x, 0.0, 0.0), radius })
    }

    /// Head, neck, shaft and tip, 6 + 2 + 30 + 4 mm.
    fn screw() -> Implant {
        let sections = [(6.0, 5.0), (2.0, 1.5), (30.0, 2.5), (4.0, 1.0)];
        let sections = sections.map(|(length_mm, radius_mm)| Section { length_mm, radius_mm }).to_vec();
        let direction = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        of(ImplantShape::Screw { head: DVec3::new(3.0, 4.0, -5.0), direction, sections })
    }

    fn rod() -> Implant {
        of(ImplantShape::Rod {
            ends: [DVec3::new(-20.0, 3.0, 1.0), DVec3::new(22.0, -4.0, 9.0)],
            radius: 3.0,
        })
    }

    fn plate() -> Implant {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.5, -0.8, 1.9);
        let half_axes = [DVec3::X * 20.0, DVec3::Y * 6.0, DVec3::Z * 1.5].map(|axis| turn * axis);
        of(ImplantShape::Box { centre: DVec3::new(4.0, 2.0, 3.0), half_axes })
    }

    /// Directions and offsets that fill a ball, from irrational steps.
    fn lines(count: u32) -> impl Iterator<Item = (DVec3, DVec3)> {
        (0..count).map(f64::from).map(|n| {
            let point =
                |a: f64, b: f64, c: f64| DVec3::new((a * n).sin(), (b * n + 1.0).sin(), (c * n + 2.0).sin());
            (point(1.3, 2.7, 0.9) * 25.0, point(0.7, 1.9, 3.1).normalize())
        })
    }

    fn length(pieces: &[Piece]) -> f64 {
        pieces.iter().map(|piece| piece.span[1] - piece.span[0]).sum()
    }

    #[test]
    fn pieces_are_what_sampling_finds() {
        let implants = [rod(), plate(), screw(), ball(6.0, 9.0), rod(), ball(-8.0, 4.0), plate()];
        let mut met = [0; 7];
        for (point, direction) in lines(1500) {
            let origin = point - 100.0 * direction;
            let limits = [70.0, 118.0];
            let found = pieces(&implants, origin, direction, limits);
            assert!(
                found
                    .iter()
                    .all(|p| p.span[0] < p.span[1] && limits[0] <= p.span[0] && p.span[1] <= limits[1])
            );
            assert!(found.windows(2).all(|pair| pair[0].span[1] <= pair[1].span[0]), "{found:?}");
            let step = (limits[1] - limits[0]) / 200.0;
            for n in 0..200 {
                let t = limits[0] + (f64::from(n) + 0.5) * step;
                let last =
                    implants.iter().rposition(|implant| implant.shape.contains(origin + t * direction));
                let inside = found.iter().find(|p| p.span[0] <= t && t <= p.span[1]).map(|p| p.implant);
                // Next to a surface rounding decides.
                let near = found.iter().any(|p| p.span.iter().any(|end| (end - t).abs() < 1e-9));
                assert!(last == inside || near, "{t}: {last:?}, {found:?}");
                if let Some(implant) = last {
                    met[implant] += 1;
                }
            }
        }
        // The first ones lie below the same ones again.
        assert!(met[2..].iter().all(|&count| count > 100) && met[..2] == [0, 0], "{met:?}");
    }

    #[test]
    fn chords_in_closed_form() {
        let across = DVec3::new(1.0, 2.0, 0.0) / 5.0_f64.sqrt();
        let ImplantShape::Screw { head, direction: axis, .. } = screw().shape else { unreachable!() };
        let ImplantShape::Rod { ends, .. } = rod().shape else { unreachable!() };
        let ImplantShape::Box { centre, half_axes } = plate().shape else { unreachable!() };
        let diagonal = half_axes.iter().sum::<DVec3>();
        for (implant, point, direction, expected) in [
            (screw(), head, axis, 42.0),
            (screw(), head, -axis, 42.0),
            // At 2 mm from the axis the neck and the tip are missed, at 3 mm the shaft as well.
            (screw(), head + 2.0 * across, axis, 36.0),
            (screw(), head + 3.0 * across, axis, 6.0),
            (screw(), head + 20.0 * axis, across, 5.0),
            (screw(), head + 7.0 * axis, across, 3.0),
            (ball(0.0, 5.0), DVec3::new(9.0, 3.0, 0.0), DVec3::X, 8.0),
            (rod(), ends[0], (ends[1] - ends[0]).normalize(), ends[0].distance(ends[1])),
            (rod(), 0.5 * (ends[0] + ends[1]), (ends[1] - ends[0]).normalize().any_orthonormal_vector(), 6.0),
            (plate(), centre, half_axes[1].normalize(), 12.0),
            (plate(), centre, diagonal.normalize(), 2.0 * diagonal.length()),
        ] {
            let found =
                pieces(std::slice::from_ref(&implant), point - 70.0 * direction, direction, EVERYWHERE);
            assert!((length(&found) - expected).abs() < 1e-12, "{implant:?}: {found:?}");
        }
        // The axis: one piece, and as many units of a longer direction as fit.
        let whole = pieces(&[screw()], head - 8.0 * axis, 4.0 * axis, EVERYWHERE);
        assert!(whole.len() == 1 && (whole[0].span[0] - 2.0).abs() < 1e-14, "{whole:?}");
        assert!((whole[0].span[1] - 12.5).abs() < 1e-13, "{whole:?}");
        assert_eq!(pieces(&[screw()], head + 2.0 * across, axis, EVERYWHERE).len(), 2, "head and shaft");
    }

    #[test]
    fn the_last_of_overlapping_spheres_counts() {
        let (large, small) = (ball(0.0, 10.0), ball(2.0, 4.0));
        let along = |implants: &[Implant], limits| {
            let found = pieces(implants, DVec3::new(-50.0, 0.0, 0.0), DVec3::X, limits);
            found.into_iter().map(|piece| (piece.span, piece.implant)).collect::<Vec<_>>()
        };
        let nested = [([40.0, 48.0], 0), ([48.0, 56.0], 1), ([56.0, 60.0], 0)];
        assert_eq!(along(&[large.clone(), small.clone()], EVERYWHERE), nested);
        assert_eq!(along(&[small.clone(), large.clone()], EVERYWHERE), [([40.0, 60.0], 1)]);
        assert_eq!(
            along(&[large.clone(), small.clone()], [50.0, 58.0]),
            [([50.0, 56.0], 1), ([56.0, 58.0], 0)]
        );
        assert_eq!(
            along(&[large.clone(), ball(10.0, 4.0)], EVERYWHERE),
            [([40.0, 56.0], 0), ([56.0, 64.0], 1)]
        );
        assert_eq!(along(&[large, small], [60.0, 90.0]), []);
    }

    #[test]
    fn grazing_and_degenerate_lines() {
        // 2 √(gap (2R − gap)), down to a line that only touches, which has no length.
        for gap in [0.25, 0.5_f64.powi(20), 0.5_f64.powi(40)] {
            let origin = DVec3::new(-30.0, 8.0 - gap, 0.0);
            let exact = 2.0 * (gap * (16.0 - gap)).sqrt();
            let found = length(&pieces(&[ball(0.0, 8.0)], origin, DVec3::X, EVERYWHERE));
            assert!((found - exact).abs() < 2e-14, "gap {gap}: {found}");
        }
        let touching = DVec3::new(-30.0, 8.0, 0.0);
        assert_eq!(pieces(&[ball(0.0, 8.0)], touching, DVec3::X, EVERYWHERE), []);
        let all = [rod(), plate(), screw(), ball(0.0, 8.0)];
        for (origin, direction) in
            [(DVec3::ZERO, DVec3::ZERO), (DVec3::NAN, DVec3::X), (DVec3::X, DVec3::NAN)]
        {
            assert_eq!(pieces(&all, origin, direction, EVERYWHERE), []);
        }
        // Square to a screw's axis, within the plane that head and neck share: the head's chord, once.
        let sections =
            [(6.0, 5.0), (2.0, 1.5)].map(|(length_mm, radius_mm)| Section { length_mm, radius_mm });
        let shape =
            ImplantShape::Screw { head: DVec3::ZERO, direction: DVec3::Z, sections: sections.to_vec() };
        let found = pieces(&[of(shape)], DVec3::new(-9.0, 3.0, 6.0), DVec3::X, EVERYWHERE);
        assert_eq!(found, [Piece { span: [5.0, 13.0], implant: 0 }]);
    }

    #[test]
    fn a_far_origin_keeps_the_chord() {
        for (k, implant) in [rod(), plate(), screw(), ball(1.0, 9.0)].into_iter().enumerate() {
            let mut compared = 0;
            for (point, direction) in lines(2000) {
                // With so few bits the far origin is exact, and both are one line.
                let [point, direction] = [point, direction].map(|v| (v * 1024.0).round() / 1024.0);
                let chord = |origin| {
                    let found = pieces(std::slice::from_ref(&implant), origin, direction, EVERYWHERE);
                    length(&found) * direction.length()
                };
                let (near, far) = (chord(point), chord(point - 1e9 * direction));
                if near > 0.125 {
                    compared += 1;
                    // The rounding of both parameters, each half of 2^-23; of the chord below 1e-6.
                    assert!((far - near).abs() < 1.25e-7, "{k}: {far} mm for {near} mm");
                }
            }
            assert!(compared > 50, "{k}: {compared}");
        }
    }

    #[test]
    fn refusals_name_the_implant_and_the_field() {
        assert!(
            [rod(), plate(), screw(), ball(0.0, 1.0)].iter().all(|implant| implant.validate(2, 0).is_ok())
        );
        let section = Section { length_mm: 1.0, radius_mm: 1.0 };
        let turned = |direction, sections| of(ImplantShape::Screw { head: DVec3::ZERO, direction, sections });
        let cuboid = |half_axes| of(ImplantShape::Box { centre: DVec3::ZERO, half_axes });
        for (implant, message) in [
            (Implant { material: 2, ..rod() }, "material is 2;"),
            (Implant { density: f64::NAN, ..rod() }, "density is NaN;"),
            (ball(f64::NAN, 1.0), "shape.centre is [NaN"),
            (ball(0.0, 0.0), "shape.radius is 0;"),
            (ball(0.0, f64::NAN), "shape.radius is NaN;"),
            (of(ImplantShape::Rod { ends: [DVec3::ONE; 2], radius: 1.0 }), "shape.distance of ends is 0;"),
            (turned(DVec3::ONE, vec![section]), "shape.direction is [1, 1, 1];"),
            (turned(DVec3::NAN, vec![section]), "shape.direction is [NaN"),
            (turned(DVec3::X, vec![]), "shape.sections is 0 cylinders;"),
            (turned(DVec3::X, vec![section; 1025]), "shape.sections is 1025 cylinders;"),
            (
                turned(DVec3::X, vec![section, Section { radius_mm: -1.0, ..section }]),
                "shape.sections[1].radius_mm is -1;",
            ),
            (
                turned(DVec3::X, vec![Section { length_mm: 1e7, ..section }]),
                "shape.sections[0].length_mm is 10000000;",
            ),
            (cuboid([DVec3::X, DVec3::Y, DVec3::ZERO]), "shape.length of half_axes[2] is 0;"),
            (cuboid([DVec3::X, DVec3::Y, DVec3::new(0.0, 1e-5, 1.0)]), "shape.half_axes is "),
        ] {
            let error = implant.validate(2, 7).unwrap_err().to_string();
            assert!(error.starts_with(&format!("scene.effects.implants[7].{message}")), "{error}");
        }
    }
}
