//! The rays of a view as the kernel takes them.

use crate::engine::gpu::wire::{
    ANCHOR_MOMENT, ANCHOR_POINT, Affine, Beam, ENDS_AT_PIXEL, ENDS_AT_SOURCE, Twofold,
};
use crate::raycast::{Anchor, Lines};

/// Which axis drives all rays of some views, if it is one.
pub(crate) fn common_axis(views: &[Lines], size: [usize; 2]) -> Option<usize> {
    let (first, others) = views.split_first()?;
    let axis = axis(first, size)?;
    others.iter().all(|view| self::axis(view, size) == Some(axis)).then_some(axis)
}

/// Which axis drives all rays of one view. Directions with one driving axis and one sign along it are a convex cone, so
/// the detector's corners decide for all its pixels.
fn axis(view: &Lines, [width, height]: [usize; 2]) -> Option<usize> {
    let [right, bottom] = [width as f64 - 0.5, height as f64 - 0.5];
    let corners = [[-0.5, -0.5], [right, -0.5], [-0.5, bottom], [right, bottom]];
    let directions = corners.map(|[i, j]| view.direction.at(i, j));
    // By a margin that rounding cannot cross.
    let drives =
        |axis: usize, d: glam::DVec3| (0..3).all(|b| b == axis || d[axis].abs() > 1.001 * d[b].abs());
    let one_way = |axis: usize| directions.iter().all(|d| (d[axis] > 0.0) == (directions[0][axis] > 0.0));
    (0..3).find(|&axis| directions.iter().all(|&d| drives(axis, d)) && one_way(axis))
}

/// The rays; the view's spectral tables are still to be named.
pub(super) fn beam(lines: &Lines, early_exit: bool) -> Beam {
    let (anchor_kind, anchor) = match &lines.anchor {
        Anchor::Point(point) => (ANCHOR_POINT, Affine::relative(point, lines.centre)),
        Anchor::Moment(moment) => (ANCHOR_MOMENT, Affine::of(moment)),
    };
    let direction = Affine::of(&lines.direction);
    let mut beam = Beam { direction, anchor_kind, anchor, early_exit: early_exit.into(), ..Beam::default() };
    if let Some(source) = lines.source {
        beam.source = [0, 1, 2].map(|axis| Twofold::difference(source[axis], lines.centre[axis]));
        beam.ends |= ENDS_AT_SOURCE;
    }
    if let Some(pixel) = &lines.pixel {
        beam.pixel = Affine::relative(pixel, lines.centre);
        beam.ends |= ENDS_AT_PIXEL;
    }
    beam
}
