//! The rays of an exposure: as many per pixel as the scene asks for, on a grid of their own, from every part of the focal spot.

use glam::DVec3;

use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, View};

/// The view whose pixels are the n×n rays of each pixel of `view`: ray (a, b) of pixel (i, j) is its pixel (n·i+a, n·j+b).
pub(super) fn on_ray_grid(view: &View, n: usize) -> View {
    match view {
        View::Pose(pose) => {
            let [column_step, row_step] = [pose.column_step, pose.row_step].map(|step| step / n as f64);
            let back = 0.5 * (n as f64 - 1.0);
            View::Pose(DetectorPose {
                first_pixel: pose.first_pixel - back * (column_step + row_step),
                column_step,
                row_step,
                ..*pose
            })
        }
        // Clip coordinates are parts of the detector.
        View::Projection(_) => *view,
    }
}

/// The same pixels seen from a point of the focal spot: `offset` mm from its centre, along the detector's columns and rows.
pub(crate) fn from_point(view: &View, offset: [f64; 2]) -> Result<View> {
    let pose = pose_of(view, "scene.effects.focal_spot")?;
    let [columns, rows] = [pose.column_step, pose.row_step].map(DVec3::normalize);
    Ok(View::Pose(DetectorPose { source: pose.source + offset[0] * columns + offset[1] * rows, ..*pose }))
}

/// # Errors
/// `InvalidArgument` when an effect has to know where the detector is, which a matrix does not say.
pub(crate) fn pose_of<'a>(view: &'a View, effect: &str) -> Result<&'a DetectorPose> {
    match view {
        View::Pose(pose) => Ok(pose),
        View::Projection(_) => {
            let valid = "only with views given as source and detector: a matrix says where rays run, not where the detector is";
            Err(Error::invalid(effect, "asked for in a view given by a matrix", valid))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Grid, Projection};
    use crate::raycast::Beam;

    #[test]
    fn rays_are_those_of_a_supersampled_pixel() {
        let grid = Grid::centred([40, 30, 20], DVec3::new(1.0, 1.5, 2.0)).expect("valid");
        let (size, n) = ([7, 5], 3);
        let pose = DetectorPose::c_arm(DVec3::ZERO, 20.0, 500.0, 800.0, 4.0, size);
        let projection = Projection::from_pose(&pose, size).expect("valid");
        for view in [View::Pose(pose), View::Projection(projection)] {
            let coarse = Beam::new(&view, &grid, size).expect("valid");
            let fine = Beam::new(&on_ray_grid(&view, n), &grid, size.map(|s| s * n)).expect("valid");
            for (i, a) in [(0, 0), (3, 1), (6, 2)] {
                let offset = (a as f64 + 0.5) / n as f64 - 0.5;
                let expected = coarse.ray(i as f64 + offset, 2.0 - 1.0 / 3.0);
                let ray = fine.ray((n * i + a) as f64, (2 * n) as f64);
                assert!(ray.distance(&expected, &grid) < 1e-9, "{ray:?} {expected:?}");
            }
        }
    }

    #[test]
    fn a_point_of_the_focal_spot_moves_the_source_only() {
        let pose = DetectorPose::c_arm(DVec3::ZERO, 0.0, 500.0, 800.0, 4.0, [7, 5]);
        let View::Pose(moved) = from_point(&View::Pose(pose), [0.3, -0.2]).expect("a pose") else {
            panic!("not a pose")
        };
        assert!((moved.source - pose.source - DVec3::new(0.3, 0.0, -0.2)).length() < 1e-12);
        assert_eq!(DetectorPose { source: pose.source, ..moved }, pose);
        let projection = View::Projection(Projection::from_pose(&pose, [7, 5]).expect("valid"));
        let message = from_point(&projection, [0.0; 2]).expect_err("no detector").to_string();
        assert!(message.contains("focal_spot"), "{message}");
    }
}
