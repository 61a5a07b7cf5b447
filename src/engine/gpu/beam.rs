//! The rays of a view as the kernel takes them.

use crate::engine::gpu::wire::{
    ANCHOR_MOMENT, ANCHOR_POINT, Affine, Beam, ENDS_AT_PIXEL, ENDS_AT_SOURCE, Twofold,
};
use crate::raycast::{Anchor, Lines};

/// Which axis drives all rays of some views, if it is one.
pub(super) fn common_axis(views: &[Lines], size: [usize; 2]) -> Option<usize> {
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

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::geometry::{DetectorPose, Grid, Projection, View};
    use crate::raycast::Beam;

    const SIZE: [usize; 2] = [12, 9];

    fn grid() -> Grid {
        Grid::centred([40, 50, 30], DVec3::new(1.0, 1.0, 1.4)).expect("valid")
    }

    /// A C-arm turned about two axes, degrees.
    fn arm(about_z: f64, about_x: f64) -> DetectorPose {
        let turn = DMat3::from_rotation_x(about_x.to_radians());
        let pose = DetectorPose::c_arm(DVec3::ZERO, about_z, 700.0, 1000.0, 6.0, SIZE);
        DetectorPose {
            source: turn * pose.source,
            first_pixel: turn * pose.first_pixel,
            column_step: turn * pose.column_step,
            row_step: turn * pose.row_step,
        }
    }

    fn beam_of(view: View) -> Beam {
        Beam::new(&view, &grid(), SIZE).expect("valid")
    }

    fn axis_of(views: &[View]) -> Option<usize> {
        let lines: Vec<Lines> = views.iter().map(|&view| beam_of(view).lines()).collect();
        common_axis(&lines, SIZE)
    }

    /// Driving axes of all rays that a pixel may be made of.
    fn axes(view: View) -> Vec<usize> {
        let beam = beam_of(view);
        let places = |n: usize| (0..=8 * n).map(|i| i as f64 / 8.0 - 0.5);
        let mut all: Vec<usize> =
            places(SIZE[1]).flat_map(|j| places(SIZE[0]).map(move |i| beam.ray(i, j).axis)).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    #[test]
    fn a_common_axis_drives_every_ray() {
        let (mut common, mut mixed) = ([0; 3], 0);
        for pose in (0..24).flat_map(|n| (0..8).map(move |m| arm(15.0 * f64::from(n), 25.0 * f64::from(m)))) {
            // The last one looks out from inside.
            let inside = DetectorPose { source: DVec3::new(1.0, 2.0, 3.0), ..pose };
            let projection = Projection::from_pose(&pose, SIZE).expect("valid");
            for view in [View::Pose(pose), View::Projection(projection), View::Pose(inside)] {
                let axes = axes(view);
                match axis_of(&[view]) {
                    Some(axis) => {
                        assert_eq!(axes, [axis], "{view:?}");
                        common[axis] += 1;
                    }
                    // By a margin.
                    None => mixed += usize::from(axes.len() > 1),
                }
            }
        }
        assert!(common.iter().all(|&n| n > 50) && mixed > 50, "{common:?}, {mixed}");
    }

    #[test]
    fn views_have_a_common_axis_when_each_has_it() {
        let [front, side, diagonal] = [0.0, 90.0, 45.0].map(|angle| View::Pose(arm(angle, 0.0)));
        assert_eq!(axis_of(&[]), None);
        assert_eq!(axis_of(&[front, View::Pose(arm(6.0, 0.0))]), Some(1));
        assert_eq!(axis_of(&[side, side]), Some(0));
        assert_eq!(axis_of(&[front, side]), None);
        assert_eq!(axis_of(&[diagonal]), None);
        assert_eq!(axis_of(&[front, diagonal]), None);
    }

    /// Rays to either side of the source have no sign of the axis in common.
    #[test]
    fn opposite_rays_have_no_common_axis() {
        let beside = DetectorPose {
            source: DVec3::ZERO,
            first_pixel: DVec3::new(-550.0, 1.0, 0.0),
            column_step: 100.0 * DVec3::X,
            row_step: 0.1 * DVec3::Z,
        };
        assert_eq!(axis_of(&[View::Pose(beside)]), None);
    }
}
