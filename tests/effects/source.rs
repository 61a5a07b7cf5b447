//! What lies between source and volume, against closed forms.

use drr::effects::{Effects, Filter, Heel, Profile};
use drr::engine::SILENT;
use drr::geometry::{Projection, View};
use drr::physics::MassAttenuation;
use drr::{Scene, ViewRequest};

use crate::stand::{
    SIDE, SIGNALS, SIZE, block, image, intensity, nothing, pose, projector, scene, worst_ratio,
};

/// The ray to a pixel: its angle's cosine to the detector's normal, and its components along the columns and the normal.
fn ray(pixel: usize) -> (f64, f64, f64) {
    let pose = pose(3.0);
    let normal = pose.column_step.cross(pose.row_step).normalize();
    let to = pose.pixel((pixel % SIDE) as f64, (pixel / SIDE) as f64) - pose.source;
    let (column, along) = (to.dot(pose.column_step.normalize()), to.dot(normal).abs());
    (along / to.length(), column / to.length(), along / to.length())
}

#[test]
fn fall_off_is_the_solid_angle_and_leaves_line_integrals_alone() {
    let volume = block();
    let fall_off = Effects { fall_off: true, ..Effects::default() };
    let (plain, with) = (image(&volume, scene(Effects::default())), image(&volume, scene(fall_off)));
    for pixel in 0..SIDE * SIDE {
        let (cosine, ..) = ray(pixel);
        let ratio = f64::from(with.intensity[pixel] / plain.intensity[pixel]);
        assert!((ratio / cosine.powi(3) - 1.0).abs() < 5e-7, "{pixel}: {ratio}");
        let change = with.line_integral[pixel] - plain.line_integral[pixel];
        assert!(change.abs() < 3e-7 * plain.line_integral[pixel] + 1e-7, "{pixel}: {change}");
    }
}

/// A matrix says as much as a pose.
#[test]
fn the_source_is_the_same_in_a_view_given_by_a_matrix() {
    let effects = Effects {
        fall_off: true,
        heel: Some(Heel::TYPICAL),
        filters: vec![filter("aluminium", Profile::Flat { mm: 2.0 })],
        ..Effects::default()
    };
    let projector = projector(&block(), scene(effects));
    let matrix = View::Projection(Projection::from_pose(&pose(3.0), SIZE).expect("valid"));
    let views: [ViewRequest; 2] = [View::Pose(pose(3.0)).into(), matrix.into()];
    let images = projector.project(&views, SIGNALS, SILENT).expect("projects");
    let [a, b] =
        [0, 1].map(|v| images.view(&images.intensity, v).iter().map(|&x| f64::from(x)).collect::<Vec<_>>());
    assert!(worst_ratio(&a, &b) < 3e-7, "{}", worst_ratio(&a, &b));
}

fn filter(material: &str, profile: Profile) -> Filter {
    Filter::named(material, *Scene::new([1, 1]).expect("valid").spectrum.grid(), profile).expect("built in")
}

/// Transmission of the open field through areal densities of some material.
fn transmission(material: &str, areal_density: f64) -> f64 {
    let scene = Scene::new([1, 1]).expect("valid");
    let table = MassAttenuation::named(&[material], *scene.spectrum.grid()).expect("built in");
    let weights = scene.spectrum.weights().iter().zip(table.coefficients(0));
    weights.map(|(w, mu)| w * (-mu * areal_density).exp()).sum()
}

#[test]
fn a_slab_and_a_bow_tie_attenuate_by_their_paths() {
    let bow_tie = Profile::BowTie { degrees: vec![-4.0, 0.0, 5.0], mm: vec![8.0, 1.0, 11.0] };
    let thickness = |fan: f64| match fan {
        fan if fan < -4.0 => 8.0,
        fan if fan < 0.0 => 1.0 - 7.0 * fan / 4.0,
        fan if fan < 5.0 => 1.0 + 10.0 * fan / 5.0,
        _ => 11.0,
    };
    let slab = intensity(
        &nothing(),
        Effects { filters: vec![filter("copper", Profile::Flat { mm: 0.3 })], ..Effects::default() },
    );
    let bow =
        intensity(&nothing(), Effects { filters: vec![filter("aluminium", bow_tie)], ..Effects::default() });
    for pixel in (0..SIDE * SIDE).step_by(7) {
        let (cosine, column, normal) = ray(pixel);
        let slab_cm = 0.03 / cosine;
        let expected = transmission("copper", 8.96 * slab_cm);
        assert!((slab[pixel] / expected - 1.0).abs() < 5e-7, "{pixel}: {} {expected}", slab[pixel]);
        let fan = column.atan2(normal).to_degrees();
        // Out of the plane of the fan the path is longer.
        let bow_cm = 0.1 * thickness(fan) / column.hypot(normal);
        let expected = transmission("aluminium", 2.699 * bow_cm);
        assert!((bow[pixel] / expected - 1.0).abs() < 5e-7, "{pixel}: {} {expected}", bow[pixel]);
    }
}

/// On the anode's side the beam is weaker and harder, on the central ray it is the tube's own.
#[test]
fn the_heel_effect_weakens_and_hardens_towards_the_anode() {
    let heel = Heel { cathode_degrees: 0.0, ..Heel::TYPICAL };
    let with = Effects { heel: Some(heel), ..Effects::default() };
    let open = intensity(&nothing(), with.clone());
    let alpha = heel.target_angle_degrees.to_radians();
    for (pixel, &open) in open.iter().enumerate() {
        let (_, column, normal) = ray(pixel);
        // The path leaves through the surface, whose normal is cos α towards the cathode and sin α towards the detector.
        let path = |column: f64, normal: f64| {
            heel.depth_mm * alpha.cos() / (column * alpha.cos() + normal * alpha.sin())
        };
        let more_cm = 0.1 * (path(column, normal) - path(0.0, 1.0));
        let expected = transmission("tungsten", 19.3 * more_cm);
        assert!((open / expected - 1.0).abs() < 5e-7, "{pixel}: {open} {expected}");
    }
    let row = &open[SIDE * SIDE / 2..][..SIDE];
    assert!(row.windows(2).all(|pair| pair[0] < pair[1]), "towards the cathode it grows: {row:?}");
    // Harder: the same body attenuates less.
    let volume = crate::stand::volume([40, 30, 36], |_| 0);
    let images = [Effects::default(), with].map(|effects| image(&volume, scene(effects)));
    let p = |n: usize, pixel: usize| images[n].line_integral[pixel];
    let anode = SIDE * SIDE / 2 + 8;
    assert!(p(1, anode) < p(0, anode) * 0.999, "{} {}", p(1, anode), p(0, anode));
}

/// A spectrum that was filtered by less than the anode takes away cannot be given it back.
#[test]
fn an_anode_that_the_spectrum_has_not_passed_is_refused() {
    for heel in [
        Heel { depth_mm: 1.0, ..Heel::TYPICAL },
        Heel { target_angle_degrees: 1e-3, ..Heel::TYPICAL },
        Heel { target_angle_degrees: 1e-300, depth_mm: 1e-3, ..Heel::TYPICAL },
    ] {
        let effects = Effects { heel: Some(heel), ..Effects::default() };
        let refused =
            projector(&nothing(), scene(effects)).project(&[crate::stand::view(3.0)], SIGNALS, SILENT);
        let message = refused.expect_err("too much").to_string();
        assert!(message.contains("scene.effects.heel.depth_mm") && message.contains("spectrum"), "{message}");
    }
}
