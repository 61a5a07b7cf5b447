//! Implants in a view: where one is, it counts instead of the volume.

use glam::DVec3;
use rayon::prelude::*;

use crate::effects::{Implant, pieces};
use crate::engine::Images;
use crate::engine::reference::Reference;
use crate::exposure::Sample;
use crate::geometry::Grid;
use crate::physics::MAX_MATERIALS;
use crate::raycast::{Beam, Footprint, Ray};

/// What implants change along one ray.
struct Change {
    ray: usize,
    /// g/cm², by material.
    areal_density: [f64; MAX_MATERIALS],
    /// mm.
    bone_path: f64,
}

/// Puts implants into one of some views, whose rays are the beam's: takes away what the volume has where they are, by the
/// same algorithm in float64, and adds what they have.
pub(super) fn put<T: Sample>(
    implants: &[Implant],
    beam: &Beam,
    reference: &Reference,
    grid: &Grid,
    bone: Option<u8>,
    view: usize,
    images: &mut Images<T>,
) {
    let [width, height] = images.size;
    let bone = bone.filter(|_| !images.bone_path.is_empty());
    let footprints = beam.footprints();
    let changes: Vec<Change> = (0..height)
        .into_par_iter()
        .flat_map_iter(|row| {
            (0..width).filter_map(move |column| {
                let ray = beam.ray(column as f64, row as f64);
                let footprint = footprints.of(&ray, column as f64, row as f64);
                change(implants, &ray, &footprint, reference, grid, bone)
                    .map(|change| Change { ray: row * width + column, ..change })
            })
        })
        .collect();
    let plane = width * height;
    for change in changes {
        for m in 0..images.materials {
            // Rounding may leave less than nothing of what is taken away whole.
            let place = &mut images.areal_density[(view * images.materials + m) * plane + change.ray];
            *place = T::of(((*place).into() + change.areal_density[m]).max(0.0));
        }
        if bone.is_some() {
            let place = &mut images.bone_path[view * plane + change.ray];
            *place = T::of(((*place).into() + change.bone_path).max(0.0));
        }
    }
}

fn change(
    implants: &[Implant],
    ray: &Ray,
    footprint: &Footprint,
    reference: &Reference,
    grid: &Grid,
    bone: Option<u8>,
) -> Option<Change> {
    let world = |s: f64| grid.index_to_world().transform_point3(DVec3::from_array(ray.point(s)));
    let (origin, next) = (world(ray.centre), world(ray.centre + 1.0));
    let limits = ray.limits.map(|s| s - ray.centre);
    let pieces = pieces(implants, origin, next - origin, limits);
    if pieces.is_empty() {
        return None;
    }
    let mut change = Change { ray: 0, areal_density: [0.0; MAX_MATERIALS], bone_path: 0.0 };
    for piece in pieces {
        let implant = &implants[piece.implant];
        let [enter, leave] = piece.span.map(|t| t + ray.centre);
        let length = ray.mm_per_slice * (leave - enter);
        // mm to cm: densities are per cm³.
        change.areal_density[usize::from(implant.material)] += 0.1 * implant.density * length;
        let inside = Ray { limits: [enter.max(ray.limits[0]), leave.min(ray.limits[1])], ..*ray };
        let Some(span) = inside.clip(grid.dimensions()) else { continue };
        let replaced = reference.areal_density(&inside, footprint, span);
        change.areal_density.iter_mut().zip(replaced).for_each(|(sum, gone)| *sum -= gone);
        if bone == Some(implant.material) {
            change.bone_path += length;
        }
        if bone.is_some() {
            change.bone_path -= reference.bone_path(&inside, span);
        }
    }
    Some(change)
}
