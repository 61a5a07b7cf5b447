//! Views, intervals and launches as the kernel takes them.

use crate::allocation::collected;
use crate::engine::gpu::parallel::{Interval, Launch, Motion, View};
use crate::engine::gpu::wire::Affine;
use crate::error::{Error, Result};
use crate::parallel::ParallelGeometry;
use crate::parallel::cpu::steps::weight;
use crate::parallel::engine::ViewRays;
use crate::parallel::frame::Frame;

/// Longest step, voxels: positions are whole voxels of 32 bits, and a block has 64 steps.
const MAX_STEP: f64 = (1 << 20) as f64;

/// Rays that one thread sums over, where there are not too many.
const PART: usize = 64;

/// Most parts.
const MAX_PARTS: usize = 1 << 14;

/// What does not change from view to view.
pub(super) fn launch(geometry: &ParallelGeometry, sides: [usize; 3]) -> Launch {
    let [width, height] = geometry.detector.map(|n| n as u32);
    let [_, sy, sz] = sides;
    Launch {
        cells: sides.map(|side| side as u32 - 1),
        stride: [(sy * sz) as u32, sz as u32],
        width,
        height,
        views: 1,
        steps: geometry.steps as u32,
        length: geometry.step as f32,
        part: PART.max(geometry.pixels().div_ceil(MAX_PARTS)) as u32,
    }
}

/// Where a view's samples are, and how they move.
///
/// # Errors
/// `Unsupported` for steps that are longer than positions can be.
pub(super) fn view(rays: &ViewRays<'_>) -> Result<View> {
    let frame = rays.frame;
    let longest = frame.step.abs().max_element();
    if !(longest <= MAX_STEP) {
        let text = format!(
            "a step of {longest:e} voxels is too long for GPU engines, which take up to {MAX_STEP:e}"
        );
        return Err(Error::Unsupported(text));
    }
    Ok(View {
        // The border is one voxel.
        at: [0, 1, 2].map(|i| Affine::new(frame.origin[i] + 1.0, frame.column[i], frame.row[i])),
        step: frame.step.to_array().map(Into::into),
        motion: rays.derivatives.map(|frame| motion(&frame)),
    })
}

fn motion(frame: &Frame) -> Motion {
    let at = [0, 1, 2].map(|i| [frame.origin[i], frame.column[i], frame.row[i]].map(|x| x as f32));
    Motion { at, step: frame.step.as_vec3().to_array() }
}

/// One per pixel.
pub(super) fn intervals(geometry: &ParallelGeometry, lengths: &[[f64; 2]]) -> Result<Vec<Interval>> {
    collected(lengths.iter().map(|&length| interval(geometry, length)), "the lengths")
}

/// The steps that overlap an interval of y, mm, and how much of the first and the last one does.
fn interval(geometry: &ParallelGeometry, length: [f64; 2]) -> Interval {
    let steps = geometry.steps as f64;
    let start = geometry.step_position(-0.5);
    let [from, to] = length.map(|y| (y - start) / geometry.step);
    let [first, end] = [from.floor(), to.ceil()].map(|step| step.clamp(0.0, steps) as usize);
    if first >= end {
        return Interval::default();
    }
    let part = |step: usize| (weight(geometry, step, length) / geometry.step) as f32;
    Interval { first: first as u32, end: end as u32, first_part: part(first), last_part: part(end - 1) }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn intervals_weigh_steps_as_their_overlaps_do() {
        let geometry = ParallelGeometry::new([3, 7, 4], DVec3::new(1.0, 1.3, 0.8), [2, 2], [1.0, 1.0]);
        for step in [0.3, 1.3, 20.0] {
            let geometry = geometry.with_step(step);
            for n in 0..400 {
                let from = -6.0 + 0.03 * f64::from(n);
                for length in [[from, from], [from, from + 0.2], [from, 3.1], [-9.0, from], [-9.0, 9.0]] {
                    let made = interval(&geometry, length);
                    for k in 0..geometry.steps {
                        let inside = (made.first..made.end).contains(&(k as u32));
                        let of_last = |k: usize| if k as u32 + 1 == made.end { made.last_part } else { 1.0 };
                        let part = if k as u32 == made.first { made.first_part } else { of_last(k) };
                        let part = if inside { part } else { 0.0 };
                        let exact = weight(&geometry, k, length) / geometry.step;
                        assert!((f64::from(part) - exact).abs() < 1e-7, "{length:?}, {k}: {made:?}, {exact}");
                    }
                }
            }
        }
    }
}
