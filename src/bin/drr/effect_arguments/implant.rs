//! Implants on the command line.

use drr::effects::{ImplantShape, Section};
use drr::physics::Material;
use glam::DVec3;

use crate::value;

/// A shape, and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ImplantArgument {
    pub(super) shape: ImplantShape,
    pub(super) material: String,
    /// g/cm³; `None`: the material's usual one.
    pub(super) density: Option<f64>,
}

const ROD: &str = "expected rod:MATERIAL:x,y,z:x,y,z:RADIUS, the middles of both ends, mm";
const SPHERE: &str = "expected sphere:MATERIAL:x,y,z:RADIUS, mm";
const BOX: &str = "expected box:MATERIAL:x,y,z:HX,HY,HZ, centre and half sides, mm";
const SCREW: &str =
    "expected screw:MATERIAL:x,y,z:DX,DY,DZ:LENGTH/RADIUS,LENGTH/RADIUS,..., from the head on, mm";

/// `SHAPE:MATERIAL[@DENSITY]:...`.
pub(super) fn implant(text: &str) -> Result<ImplantArgument, String> {
    let parts: Vec<&str> = text.split(':').collect();
    let (shape, material) = match parts[..] {
        ["rod", material, from, to, radius] => (rod(from, to, radius).ok_or(ROD)?, material),
        ["rod", ..] => return Err(ROD.into()),
        ["sphere", material, centre, radius] => (sphere(centre, radius).ok_or(SPHERE)?, material),
        ["sphere", ..] => return Err(SPHERE.into()),
        ["box", material, centre, half_sides] => (upright_box(centre, half_sides).ok_or(BOX)?, material),
        ["box", ..] => return Err(BOX.into()),
        ["screw", material, head, direction, sections] => {
            (screw(head, direction, sections).ok_or(SCREW)?, material)
        }
        ["screw", ..] => return Err(SCREW.into()),
        _ => {
            return Err(
                "expected rod:..., sphere:..., box:... or screw:...; drr project --help has the forms".into(),
            );
        }
    };
    shape.validate().map_err(|error| error.to_string())?;
    let (material, density) = match material.split_once('@') {
        Some((material, density)) => {
            (material, Some(value::positive(density).map_err(|e| format!("@{density}: {e}"))?))
        }
        None => (material, None),
    };
    Material::named(material).map_err(|error| error.to_string())?;
    Ok(ImplantArgument { shape, material: material.into(), density })
}

fn vector(text: &str) -> Option<DVec3> {
    value::vector(text).ok()
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok()
}

fn rod(from: &str, to: &str, radius: &str) -> Option<ImplantShape> {
    Some(ImplantShape::Rod { ends: [vector(from)?, vector(to)?], radius: number(radius)? })
}

fn sphere(centre: &str, radius: &str) -> Option<ImplantShape> {
    Some(ImplantShape::Sphere { centre: vector(centre)?, radius: number(radius)? })
}

fn upright_box(centre: &str, half_sides: &str) -> Option<ImplantShape> {
    let half = vector(half_sides)?;
    let half_axes = [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z];
    Some(ImplantShape::Box { centre: vector(centre)?, half_axes })
}

fn screw(head: &str, direction: &str, sections: &str) -> Option<ImplantShape> {
    let section = |text: &str| {
        let (length, radius) = text.split_once('/')?;
        Some(Section { length_mm: number(length)?, radius_mm: number(radius)? })
    };
    Some(ImplantShape::Screw {
        head: vector(head)?,
        direction: vector(direction)?.try_normalize()?,
        sections: sections.split(',').map(section).collect::<Option<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_has_its_form() {
        let rod = implant("rod:titanium:0,0,-20:0,0,20:4").expect("valid");
        let ends = [DVec3::new(0.0, 0.0, -20.0), DVec3::new(0.0, 0.0, 20.0)];
        let shape = ImplantShape::Rod { ends, radius: 4.0 };
        assert_eq!(rod, ImplantArgument { shape, material: "titanium".into(), density: None });
        let ball = implant("sphere:bone_cortical@1.5:1,2,3:0.5").expect("valid");
        assert_eq!(ball.density, Some(1.5));
        assert!(implant("box:pmma:0,0,0:1,2,3").is_ok());
        let screw = implant("screw:steel_316l:0,0,0:0,3,4:6/4,30/2").expect("valid");
        let ImplantShape::Screw { direction, sections, .. } = screw.shape else { panic!("a screw") };
        assert!((direction - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-15);
        assert_eq!(sections[1], Section { length_mm: 30.0, radius_mm: 2.0 });
    }

    #[test]
    fn what_is_not_one_is_refused_with_the_form() {
        let cases = [
            ("rod:titanium:0,0,0:1", "rod:MATERIAL"),
            ("sphere:titanium:0,0:1", "sphere:MATERIAL"),
            ("box:titanium:0,0,0:1,1,0", ""),
            ("screw:titanium:0,0,0:0,0,0:1/1", "screw:MATERIAL"),
            ("cube:titanium:0,0,0:1", "rod:"),
            ("sphere:unobtainium:0,0,0:1", "unobtainium"),
            ("sphere:titanium@-1:0,0,0:1", "@-1"),
            ("sphere:titanium:0,0,0:-1", ""),
        ];
        for (text, word) in cases {
            let message = implant(text).expect_err(text);
            assert!(message.contains(word), "{text}: {message}");
        }
    }
}
