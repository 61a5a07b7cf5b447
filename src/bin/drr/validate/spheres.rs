//! Where the shadows of balls are, and how much water one of them seems to have.

use anyhow::Result;
use drr::phantom::Shape;
use glam::DVec3;

use super::check::Check;
use super::stand::{Shadows, Stand, shadow};

const PIXELS: usize = 720;
/// The ball of water, 40 mm, among the parts.
const WATER: usize = 3;
/// Shortest chord of the ball of water that counts, mm.
const CHORD_MM: f64 = 30.0;
/// What is left around a ball, in pixels; voxels may blur it.
const RIM: f64 = 4.0;

pub(super) fn checks(stand: &Stand) -> Result<Vec<Check>> {
    let truth = stand.closed_form(PIXELS)?;
    let balls: Vec<_> = stand.phantom.parts().iter().filter_map(|part| ball(&part.shape)).collect();
    let chord = |from: DVec3, to: DVec3| {
        let lengths = stand.phantom.lengths(from, to);
        let alone = lengths.iter().enumerate().all(|(n, &length)| n == WATER || length == 0.0);
        (alone && lengths[WATER] >= CHORD_MM).then_some(lengths[WATER])
    };
    let mut checks = Vec::new();
    for algorithm in super::FAST {
        let shadows = stand.project(algorithm, PIXELS)?;
        let mut distances = Vec::new();
        for view in 0..2 {
            for &(centre, radius) in &balls {
                let [a, b] = [&shadows, &truth].map(|image| centroid(image, view, centre, radius));
                distances.push(shadows.pixel_at_isocentre() * (a[0] - b[0]).hypot(a[1] - b[1]));
            }
        }
        checks.push(Check::millimetres("sphere centres", algorithm, &distances));
        let differences = shadows.relative_differences(&truth, chord);
        checks.push(Check::millimetres("water ball", algorithm, &differences));
    }
    Ok(checks)
}

/// Centre and radius, mm, of an ellipsoid that is a ball.
fn ball(shape: &Shape) -> Option<(DVec3, f64)> {
    match *shape {
        Shape::Ellipsoid { centre, semi_axes } if semi_axes == DVec3::splat(semi_axes.x) => {
            Some((centre, semi_axes.x))
        }
        _ => None,
    }
}

/// Centroid, in pixels, of the line integrals around the shadow of a ball.
fn centroid(shadows: &Shadows, view: usize, centre: DVec3, radius: f64) -> [f64; 2] {
    let [u, v] = shadow(&shadows.poses[view], centre);
    // The balls are up to 100 mm nearer to the source than the isocentre.
    let reach = 1.15 * radius / shadows.pixel_at_isocentre() + RIM;
    let range = |x: f64| (x - reach).max(0.0) as usize..=((x + reach) as usize).min(shadows.width - 1);
    let (mut sum, mut moments) = (0.0, [0.0; 2]);
    for j in range(v) {
        for i in range(u) {
            let p = shadows.line_integrals[view][j * shadows.width + i];
            sum += p;
            moments[0] += p * i as f64;
            moments[1] += p * j as f64;
        }
    }
    moments.map(|moment| moment / sum)
}
