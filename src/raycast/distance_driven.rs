//! The distance-driven weights of voxels.

use std::ops::{Range, RangeInclusive};

use crate::raycast::{Footprint, Ray, Span, ray::TRANSVERSE, slices};

/// Smallest half-width, voxels: smaller ones count as this, which is beyond what positions in float32 are known to, so that
/// engines in float32 and float64 agree about a point on a face. Where a ray begins at its source, footprints are points.
pub(crate) const POINT: f64 = 1e-6;

/// Calls `visit` with the index (i, j, k) and the weight, in units of s, of every voxel that a pixel covers in some slices of
/// its ray's driving axis (De Man and Basu, Phys Med Biol 49, 2463, 2004), in order of the slices; voxels of weight 0 may
/// be among them. Slices outside the volume or the span have none.
///
/// In slice k the footprint is the rectangle [u − hᵤ, u + hᵤ] × [v − hᵥ, v + hᵥ] around the ray's crossing with the
/// slice's middle; see [`Footprint::half_widths`]. The weight of voxel (m, n) is the part of the rectangle over
/// [m − ½, m + ½] × [n − ½, n + ½], times the part of [k − ½, k + ½] that is inside the span. What of the rectangle is
/// beyond the volume counts for its outermost voxels, so that the weights of a slice sum to the latter part, and those of a
/// ray to its chord. A footprint far below a voxel, down to a millionth of one, is the voxel under it, and half of either on a face between two.
pub(crate) fn for_each_weight(
    ray: &Ray,
    footprint: &Footprint,
    span: Span,
    dimensions: [usize; 3],
    within: Range<i32>,
    mut visit: impl FnMut([usize; 3], f64),
) {
    let [u_axis, v_axis] = TRANSVERSE[ray.axis];
    for (slice, length) in slices(span, within.start..within.end.min(dimensions[ray.axis] as i32)) {
        let s = f64::from(slice);
        let (point, [half_u, half_v]) = (ray.point(s), footprint.half_widths(s - ray.centre));
        let u = Cover::new(point[u_axis], half_u, dimensions[u_axis]);
        let v = Cover::new(point[v_axis], half_v, dimensions[v_axis]);
        let mut voxel = [slice as usize; 3];
        for n in v.voxels.clone() {
            voxel[v_axis] = n;
            let of_row = length * v.part(n);
            for m in u.voxels.clone() {
                voxel[u_axis] = m;
                visit(voxel, of_row * u.part(m));
            }
        }
    }
}

/// An interval on an axis of voxels.
struct Cover {
    middle: f64,
    half: f64,
    /// Those that it covers; the outermost ones also cover what lies beyond them.
    voxels: RangeInclusive<usize>,
}

impl Cover {
    fn new(middle: f64, half: f64, size: usize) -> Self {
        let half = half.max(POINT);
        let voxel = |x: f64| (x + 0.5).floor().clamp(0.0, (size - 1) as f64) as usize;
        Self { middle, half, voxels: voxel(middle - half)..=voxel(middle + half) }
    }

    /// The part of it that is over a voxel. All of them sum to 1, but for the rounding of the sum.
    fn part(&self, voxel: usize) -> f64 {
        let below = |face: f64| (0.5 + 0.5 * (face - self.middle) / self.half).clamp(0.0, 1.0);
        let lower = if voxel == *self.voxels.start() { 0.0 } else { below(voxel as f64 - 0.5) };
        let upper = if voxel == *self.voxels.end() { 1.0 } else { below(voxel as f64 + 0.5) };
        upper - lower
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DMat3, DVec3};

    use super::*;
    use crate::geometry::{DetectorPose, Grid, View};
    use crate::raycast::Beam;

    /// Pixels of three voxels and more in a cone, near the border.
    #[test]
    fn weights_of_a_ray_sum_to_its_chord_however_the_slices_are_divided() {
        let columns =
            DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(0.0, 0.8, 0.1), DVec3::new(0.3, 0.0, 1.4));
        let to_world = DAffine3 { matrix3: columns, translation: DVec3::new(-8.0, -6.0, 3.0) };
        let grid = Grid::new([19, 16, 11], to_world).expect("valid");
        let n = grid.dimensions();
        let mut hits = 0;
        for angle in [0.0, 30.0, 100.0] {
            let pose = DetectorPose::c_arm(grid.centre(), angle, 60.0, 80.0, 3.0, [9, 7]);
            let beam = Beam::new(&View::Pose(pose), &grid, [9, 7]).expect("valid");
            for (column, row) in (0..63).map(|pixel| (f64::from(pixel % 9), f64::from(pixel / 9))) {
                let (ray, footprint) = (beam.ray(column, row), beam.footprint(column, row));
                let Some(span) = ray.clip(n) else { continue };
                hits += 1;
                let list = |within: Range<i32>| {
                    let mut all = Vec::new();
                    for_each_weight(&ray, &footprint, span, n, within, |voxel, w| all.push((voxel, w)));
                    all
                };
                let all = list(0..n[ray.axis] as i32);
                assert_eq!(all, [list(0..4), list(4..5), list(5..i32::MAX)].concat());
                assert!(all.iter().all(|(voxel, w)| *w >= 0.0 && (0..3).all(|a| voxel[a] < n[a])));
                let sum: f64 = all.iter().map(|(_, w)| w).sum();
                let chord = span.leave - span.enter;
                assert!((sum - chord).abs() < 1e-14 * chord, "{sum} of {chord}");
            }
        }
        assert!(hits > 100, "{hits}");
    }

    fn parts(middle: f64, half: f64, size: usize) -> Vec<(usize, f64)> {
        let cover = Cover::new(middle, half, size);
        cover.voxels.clone().map(|voxel| (voxel, cover.part(voxel))).collect()
    }

    #[test]
    fn parts_are_overlaps_with_the_voxels() {
        assert_eq!(parts(2.0, 0.5, 5), [(2, 1.0), (3, 0.0)]);
        assert_eq!(parts(2.25, 0.5, 5), [(2, 0.75), (3, 0.25)]);
        assert_eq!(parts(2.0, 1.0, 5), [(1, 0.25), (2, 0.5), (3, 0.25)]);
        assert_eq!(parts(2.0, 2.0, 5), [(0, 0.125), (1, 0.25), (2, 0.25), (3, 0.25), (4, 0.125)]);
    }

    #[test]
    fn beyond_the_border_the_outermost_voxel_counts() {
        assert_eq!(parts(-0.25, 0.5, 5), [(0, 1.0)]);
        assert_eq!(parts(4.0, 2.0, 5), [(2, 0.125), (3, 0.25), (4, 0.625)]);
        assert_eq!(parts(0.3, 7.0, 1), [(0, 1.0)]);
        assert_eq!(parts(0.5, 1e300, 2), [(0, 0.5), (1, 0.5)]);
        assert_eq!(parts(0.5, f64::INFINITY, 2), [(0, 0.5), (1, 0.5)]);
    }

    #[test]
    fn a_point_is_in_one_voxel_or_between_two() {
        for half in [0.0, 5e-324, 1e-15, 1e-9] {
            assert_eq!(parts(2.3, half, 5), [(2, 1.0)]);
            assert_eq!(parts(2.5, half, 5), [(2, 0.5), (3, 0.5)]);
        }
    }
}
