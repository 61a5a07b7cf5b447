//! What no view can see: all views and the volume move together.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use crate::allocation::collected;
use crate::error::{Error, Result};
use crate::parallel::{ViewParameters, check_views};

/// Steps of Newton's iteration for the nearest rotation; it converges quadratically, from a few degrees in four.
const POLAR_STEPS: usize = 12;

/// The same views of the same object, which has moved so that they are as near as can be to those of `reference`.
///
/// Where the object moves by x ↦ Q x + s, views with `R Qᵀ` and `t − R Qᵀ s` show what those with R and t did. Q is the
/// rotation nearest to `Σ R_refᵀ R` (Schönemann, Psychometrika 31(1), 1, 1966), s that with the least squares of
/// differences of Δx and Δz, after it.
///
/// # Errors
/// `InvalidArgument` for another number of views than `reference` has, none, or views that are not valid or differ by so
/// much that there is no nearest one; `OutOfMemory`.
pub fn without_common_motion(
    views: &[ViewParameters],
    reference: &[ViewParameters],
) -> Result<Vec<ViewParameters>> {
    if views.is_empty() || views.len() != reference.len() {
        return Err(Error::invalid("views' number", views.len(), format!("{}, not 0", reference.len())));
    }
    check_views(views)?;
    let pairs = || views.iter().map(ViewParameters::motion).zip(reference.iter().map(ViewParameters::motion));
    let sum =
        pairs().fold(DMat3::ZERO, |sum, (own, other)| sum + other.rotation().transpose() * own.rotation());
    let turn = nearest_rotation(sum / views.len() as f64)?.transpose();
    let (mut normal, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (own, other) in pairs() {
        let turned = own.rotation() * turn;
        let difference = own.translation - other.translation;
        for axis in [0, 2] {
            let row = turned.row(axis);
            normal += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            right += row * difference[axis];
        }
    }
    let shift = solve(normal, right);
    let moved = pairs().map(|(own, other)| {
        let rotation = own.rotation() * turn;
        let translation = own.translation - rotation * shift;
        let [alpha, beta, phi] = angles(rotation, other.angles);
        ViewParameters { alpha, beta, phi, dx: translation.x, dz: translation.z }
    });
    collected(moved, "the views")
}

/// The orthogonal factor of the polar decomposition, by Newton's iteration X ↦ (X + X⁻ᵀ)/2 (Higham, SIAM J. Sci. Stat.
/// Comput. 7(4), 1160, 1986).
fn nearest_rotation(matrix: DMat3) -> Result<DMat3> {
    if !(matrix.determinant() > 1e-3) {
        let valid = "views that differ by much less than half a turn";
        return Err(Error::invalid("views", "too far from the reference", valid));
    }
    Ok((0..POLAR_STEPS).fold(matrix, |x, _| 0.5 * (x + x.inverse().transpose())))
}

/// The shortest least-squares solution of a system whose matrix is symmetric: along a direction that no view sees, as the
/// beam's where all views look alike, nothing moves.
fn solve(normal: DMat3, right: DVec3) -> DVec3 {
    let size = normal.x_axis.x + normal.y_axis.y + normal.z_axis.z;
    (normal + 1e-9 * size * DMat3::IDENTITY).inverse() * right
}

/// α, β, φ of `R_y(β) R_x(α) R_z(φ)`, |α| ≤ 90°, and the turns nearest to `near`.
fn angles(rotation: DMat3, near: [f64; 3]) -> [f64; 3] {
    let (row, column) = (rotation.row(1), rotation.col(2));
    let found = [(-row.z).clamp(-1.0, 1.0).asin(), column.x.atan2(column.z), row.x.atan2(row.y)];
    std::array::from_fn(|k| found[k] + TAU * ((near[k] - found[k]) / TAU).round())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn views() -> Vec<ViewParameters> {
        let view = |n: u32| {
            let x = f64::from(n);
            ViewParameters {
                alpha: 0.02 * (1.7 * x).sin(),
                beta: 0.03 * (2.9 * x).cos(),
                phi: 0.35 * x,
                dx: (0.7 * x).sin(),
                dz: (1.1 * x).cos(),
            }
        };
        (0..20).map(view).collect()
    }

    #[test]
    fn a_common_motion_is_taken_back() {
        let views = views();
        let turn = DMat3::from_rotation_z(0.03) * DMat3::from_rotation_x(-0.05);
        let shift = DVec3::new(3.0, -2.0, 5.0);
        let moved: Vec<_> = views
            .iter()
            .map(|view| {
                let rotation = view.motion().rotation() * turn.transpose();
                let t = view.motion().translation - rotation * shift;
                let [alpha, beta, phi] = angles(rotation, [0.0, 0.0, view.phi]);
                ViewParameters { alpha, beta, phi, dx: t.x, dz: t.z }
            })
            .collect();
        assert!((moved[3].dx - views[3].dx).abs() > 1.0);
        for (own, right) in without_common_motion(&moved, &views).unwrap().iter().zip(&views) {
            let pairs = own.to_array().into_iter().zip(right.to_array());
            // The shift's system is damped by 1e-9.
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-7), "{own:?}, not {right:?}");
        }
    }

    #[test]
    fn views_stay_where_nothing_is_common() {
        let views = views();
        let same = without_common_motion(&views, &views).unwrap();
        for (own, right) in same.iter().zip(&views) {
            let pairs = own.to_array().into_iter().zip(right.to_array());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-12), "{own:?}");
        }
    }

    #[test]
    fn one_view_alone_is_met() {
        let own = ViewParameters { alpha: 0.1, phi: 7.0, dx: 2.0, dz: -1.0, ..ViewParameters::default() };
        let reference = ViewParameters { phi: 6.5, ..ViewParameters::default() };
        let [met] = without_common_motion(&[own], &[reference]).unwrap()[..] else { panic!("one view") };
        let pairs = met.to_array().into_iter().zip(reference.to_array());
        assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-7), "{met:?}");
    }

    #[test]
    fn what_cannot_be_compared_is_refused() {
        let views = views();
        assert!(without_common_motion(&[], &[]).is_err());
        assert!(without_common_motion(&views, &views[1..]).is_err());
        let behind =
            views.iter().map(|view| ViewParameters { phi: view.phi + 3.0, ..*view }).collect::<Vec<_>>();
        assert!(without_common_motion(&behind, &views).is_ok(), "a turn about z is a common motion");
        let scattered: Vec<_> =
            (0..20).map(|n| ViewParameters { phi: TAU / 20.0 * f64::from(n), ..views[0] }).collect();
        let still = vec![views[0]; 20];
        assert!(without_common_motion(&scattered, &still).is_err());
        let nan = vec![ViewParameters { dx: f64::NAN, ..views[0] }];
        assert!(without_common_motion(&nan, &still[..1]).unwrap_err().to_string().starts_with("views[0]"));
    }
}
