//! Implants count where they are, and the CT does not.

use drr::Scene;
use drr::effects::{Effects, Implant, ImplantShape};
use drr::engine::{Layers, SILENT};
use drr::physics::MassAttenuation;
use glam::DVec3;

use crate::stand::{SIDE, pose, projector, scene, view, volume};

const RADIUS: f64 = 11.0;

fn with_titanium(implants: Vec<Implant>) -> Scene {
    let scene = scene(Effects { implants, ..Effects::default() });
    let names = ["air", "lung", "soft_tissue", "bone_cortical", "titanium"];
    let materials = MassAttenuation::named(&names, *scene.spectrum.grid()).expect("built in");
    Scene { materials, ..scene }
}

fn ball(centre: DVec3, material: u8, density: f64) -> Implant {
    Implant { shape: ImplantShape::Sphere { centre, radius: RADIUS }, material, density }
}

/// The length of a pixel's ray in a ball, mm.
fn chord(pixel: usize, centre: DVec3, radius: f64) -> f64 {
    let pose = pose(3.0);
    let direction = (pose.pixel((pixel % SIDE) as f64, (pixel / SIDE) as f64) - pose.source).normalize();
    let distance = (centre - pose.source).reject_from(direction).length();
    2.0 * (radius * radius - distance * distance).max(0.0).sqrt()
}

#[test]
fn a_ball_of_titanium_takes_the_tissues_place() {
    // All of bone, which the ball's way is cut out of.
    let body = volume([40, 30, 36], |_| 1000);
    let centre = DVec3::new(5.0, -3.0, 4.0);
    let layers = Layers { areal_density: true, bone_path: true, ..Layers::default() };
    let images = |implants: Vec<Implant>| {
        projector(&body, with_titanium(implants)).project(&[view(3.0)], layers, SILENT).expect("projects")
    };
    let (plain, with) = (images(Vec::new()), images(vec![ball(centre, 4, 4.5)]));
    // The density of a voxel of 1000 HU, from a ray through many of them.
    let middle = SIDE * SIDE / 2 + SIDE / 2;
    let density = f64::from(plain.areal_density(0, 3)[middle]) / (0.1 * f64::from(plain.bone_path[middle]));
    let mut hit = 0;
    for pixel in 0..SIDE * SIDE {
        let length = chord(pixel, centre, RADIUS);
        hit += usize::from(length > 0.0);
        let titanium = f64::from(with.areal_density(0, 4)[pixel]);
        assert!((titanium - 0.45 * length).abs() < 1e-6 * titanium + 1e-7, "{pixel}: {titanium} {length}");
        let bone = f64::from(plain.areal_density(0, 3)[pixel] - with.areal_density(0, 3)[pixel]);
        assert!(
            (bone - 0.1 * density * length).abs() < 1e-4,
            "{pixel}: {bone} for {}",
            0.1 * density * length
        );
        let path = f64::from(plain.bone_path[pixel] - with.bone_path[pixel]);
        assert!((path - length).abs() < 1e-3, "{pixel}: {path} for {length}");
    }
    assert!(hit > 30, "{hit}");
}

#[test]
fn the_last_implant_counts_and_a_hole_is_one_of_air() {
    let body = volume([40, 30, 36], |_| 0);
    let centre = DVec3::new(5.0, -3.0, 4.0);
    let layers = Layers { areal_density: true, ..Layers::default() };
    let images = |implants: Vec<Implant>| {
        projector(&body, with_titanium(implants)).project(&[view(3.0)], layers, SILENT).expect("projects")
    };
    let air_last = images(vec![ball(centre, 4, 4.5), ball(centre, 0, 0.001)]);
    let air_only = images(vec![ball(centre, 0, 0.001)]);
    assert!(air_last.areal_density(0, 4).iter().all(|&titanium| titanium == 0.0));
    assert_eq!(air_last.areal_density, air_only.areal_density);
    // Beside the CT they are there all the same.
    let beside = images(vec![ball(DVec3::new(0.0, 0.0, 42.0), 4, 4.5)]);
    let seen: f32 = beside.areal_density(0, 4).iter().sum();
    assert!(seen > 0.0);
}

/// An implant of bone is bone: its chord counts.
#[test]
fn a_ball_of_bone_has_a_bone_path() {
    let body = volume([40, 30, 36], |_| 0);
    let centre = DVec3::new(5.0, -3.0, 4.0);
    let layers = Layers { bone_path: true, ..Layers::default() };
    let images = projector(&body, with_titanium(vec![ball(centre, 3, 1.92)]))
        .project(&[view(3.0)], layers, SILENT)
        .expect("projects");
    for (pixel, &path) in images.bone_path.iter().enumerate() {
        let length = chord(pixel, centre, RADIUS);
        assert!((f64::from(path) - length).abs() < 1e-4, "{pixel}: {path} for {length}");
    }
}

#[test]
fn an_unknown_material_is_refused() {
    let scene = with_titanium(vec![ball(DVec3::ZERO, 5, 4.5)]);
    let message = scene.validate().expect_err("there are five").to_string();
    assert!(message.starts_with("scene.effects.implants[0].material is 5"), "{message}");
}
