//! Where the shadows of thin rods are.

use anyhow::Result;
use drr::phantom::{Rod, rod_axes};

use super::check::Check;
use super::stand::{Shadows, Stand, shadow};

const PIXELS: usize = 720;
/// Part of a rod that is looked at; its ends are left out.
const MIDDLE: f64 = 0.8;
/// Pixels to either side of an axis that belong to its rod; the next rod is 16 away.
const REACH: f64 = 6.0;

pub(super) fn checks(stand: &Stand) -> Result<Vec<Check>> {
    let check = |&algorithm| {
        let shadows = stand.project(algorithm, PIXELS)?;
        let differences: Vec<f64> = (0..2)
            .flat_map(|view| {
                rod_axes().iter().flat_map(|rod| distances(&shadows, view, rod)).collect::<Vec<_>>()
            })
            .collect();
        Ok(Check::millimetres("rods", algorithm, &differences))
    };
    super::FAST.iter().map(check).collect()
}

/// Distances in mm, across the rod in the plane of the isocentre, of the shadow's centroid from the axis: one per row
/// of pixels, or per column where the rod lies along the rows.
fn distances(shadows: &Shadows, view: usize, rod: &Rod) -> Vec<f64> {
    let reach = MIDDLE * rod.half_length * rod.direction;
    let [start, end] = [rod.point - reach, rod.point + reach].map(|p| shadow(&shadows.poses[view], p));
    let [du, dv] = [end[0] - start[0], end[1] - start[1]];
    let upright = dv.abs() > du.abs();
    // `along` counts rows (or columns), `across` is measured in each.
    let (along, across) = if upright { (1, 0) } else { (0, 1) };
    let slope = (end[across] - start[across]) / (end[along] - start[along]);
    let tilt = 1.0 / 1.0_f64.hypot(slope);
    let first = start[along].min(end[along]).ceil() as usize;
    let last = start[along].max(end[along]).floor() as usize;
    let image = &shadows.line_integrals[view];
    (first..=last)
        .map(|line| {
            let axis = start[across] + slope * (line as f64 - start[along]);
            let (mut sum, mut moment) = (0.0, 0.0);
            for n in (axis - REACH).ceil() as usize..=(axis + REACH).floor() as usize {
                let p =
                    if upright { image[line * shadows.width + n] } else { image[n * shadows.width + line] };
                sum += p;
                moment += p * (n as f64 - axis);
            }
            moment / sum * tilt * shadows.pixel_at_isocentre()
        })
        .collect()
}
