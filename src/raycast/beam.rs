//! All rays of one view, in the index space of one grid.

use glam::{DVec3, DVec4};

use crate::error::{Error, Result};
use crate::geometry::{DetectorPose, Grid, Projection, View};
use crate::raycast::lines::{Anchor, Even, Lines};
use crate::raycast::{Footprint, Footprints, Ray};

/// Smallest sine of the angle between the two planes of a ray in index space: below it float64 has lost the ray.
const MIN_SINE: f64 = 1e-10;

/// All rays of one view, in index coordinates.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    grid: Grid,
    rays: Rays,
    /// Side of a pixel over the distance from one to the next.
    pixel_part: f64,
}

#[derive(Debug, Clone, Copy)]
enum Rays {
    /// Segments from the source to pixel centres; `near_pixel` tells which end is the nearer one to the volume.
    Segments { source: DVec3, first_pixel: DVec3, column_step: DVec3, row_step: DVec3, near_pixel: bool },
    /// Lines where two planes meet; the planes are affine in the pixel's normalised device coordinates, and relative to
    /// the grid's centre.
    Planes { x: DVec4, y: DVec4, w: DVec4, source: Option<DVec3>, forward: f64, size: [f64; 2] },
}

impl Beam {
    /// The rays of `view` on a detector of `size` = width × height pixels.
    ///
    /// # Errors
    /// `InvalidArgument` when the view is not valid (see `DetectorPose::validate`, `Projection::validate`).
    pub fn new(view: &View, grid: &Grid, size: [usize; 2]) -> Result<Self> {
        let rays = match view {
            View::Pose(pose) => Self::segments(pose, grid, size)?,
            View::Projection(projection) => Self::planes(projection, grid, size)?,
        };
        Ok(Self { grid: *grid, rays, pixel_part: 1.0 })
    }

    /// The same rays, of parts of pixels: `n` × `n` of them are one.
    #[must_use]
    pub(crate) fn of_parts(self, n: usize) -> Self {
        Self { pixel_part: self.pixel_part / n as f64, ..self }
    }

    /// Of the volume.
    pub(crate) fn dimensions(&self) -> [usize; 3] {
        self.grid.dimensions()
    }

    /// The n×n rays of each pixel: ray (a, b) of pixel (i, j) is that of pixel (n·i+a, n·j+b).
    #[must_use]
    pub(crate) fn on_ray_grid(self, n: usize) -> Self {
        let parts = n as f64;
        let rays = match self.rays {
            Rays::Segments { source, first_pixel, column_step, row_step, near_pixel } => {
                let [column_step, row_step] = [column_step, row_step].map(|step| step / parts);
                let first_pixel = first_pixel - 0.5 * (parts - 1.0) * (column_step + row_step);
                Rays::Segments { source, first_pixel, column_step, row_step, near_pixel }
            }
            Rays::Planes { x, y, w, source, forward, size } => {
                Rays::Planes { x, y, w, source, forward, size: size.map(|side| parts * side) }
            }
        };
        Self { rays, ..self }
    }

    /// What all pixels cover.
    pub(crate) fn footprints(&self) -> Footprints {
        Footprints { lines: self.lines(), pixel_part: self.pixel_part }
    }

    /// What pixel (column, row) covers of the slices that its ray crosses; fractions are points between pixel centres.
    pub(crate) fn footprint(&self, column: f64, row: f64) -> Footprint {
        self.footprints().of(&self.ray(column, row), column, row)
    }

    fn segments(pose: &DetectorPose, grid: &Grid, [width, height]: [usize; 2]) -> Result<Rays> {
        pose.validate()?;
        let source = grid.point_to_index(pose.source);
        let middle = grid.point_to_index(pose.pixel(0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0)));
        let from_centre = |point: DVec3| (point - grid.centre_index()).length_squared();
        Ok(Rays::Segments {
            source,
            first_pixel: grid.point_to_index(pose.first_pixel),
            column_step: grid.vector_to_index(pose.column_step),
            row_step: grid.vector_to_index(pose.row_step),
            near_pixel: from_centre(middle) < from_centre(source),
        })
    }

    fn planes(projection: &Projection, grid: &Grid, size: [usize; 2]) -> Result<Rays> {
        projection.validate()?;
        if !projection.is_parallel() {
            check_source(projection, grid)?;
        }
        let to_world = grid.index_to_world();
        let centre = grid.centre();
        let [x, y, w] = projection.rows().map(|row| {
            let normal = row.truncate();
            (to_world.matrix3.transpose() * normal).extend(normal.dot(centre) + row.w)
        });
        // w·direction is the same for all pixels: n3·(n0×n1). Rays run towards growing w.
        let along = w.truncate().dot(x.truncate().cross(y.truncate()));
        let parallel = projection.is_parallel();
        for clip in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
            let [m, n] = [x - clip[0] * w, y - clip[1] * w].map(DVec4::truncate);
            if !(m.cross(n).length() > MIN_SINE * m.length() * n.length()) {
                let valid = "x, y and w rows whose sizes float64 can compare";
                return Err(Error::invalid(
                    "modelViewProjectionMatrix",
                    "singular at the detector's corner",
                    valid,
                ));
            }
        }
        Ok(Rays::Planes {
            x,
            y,
            w,
            source: (!parallel).then(|| grid.point_to_index(projection.source)),
            forward: if along < 0.0 { -1.0 } else { 1.0 },
            size: size.map(|n| n as f64),
        })
    }

    /// All rays at once.
    pub(crate) fn lines(&self) -> Lines {
        let centre = self.grid.centre_index();
        match self.rays {
            Rays::Segments { source, first_pixel, column_step, row_step, near_pixel } => {
                let even = |constant| Even { constant, column: column_step, row: row_step };
                let pixel = even(first_pixel);
                let near = if near_pixel { pixel } else { Even::constant(source) };
                Lines {
                    centre,
                    direction: even(first_pixel - source),
                    anchor: Anchor::Point(near),
                    source: Some(source),
                    pixel: Some(pixel),
                }
            }
            Rays::Planes { x, y, w, source, forward, size } => {
                // As clip coordinates change: (2i+1)/width − 1 and 1 − (2j+1)/height.
                let columns = [x - (1.0 / size[0] - 1.0) * w, -2.0 / size[0] * w];
                let rows = [y - (1.0 - 1.0 / size[1]) * w, 2.0 / size[1] * w];
                let [direction, moment] = intersections(columns, rows, forward);
                // Homogeneous: any size will do, so one that float32 can hold.
                let scale = 1.0 / direction.at(0.5 * size[0], 0.5 * size[1]).abs().max_element();
                Lines {
                    centre,
                    direction: direction.times(scale),
                    anchor: Anchor::Moment(moment.times(scale)),
                    source,
                    pixel: None,
                }
            }
        }
    }

    /// The ray of pixel (column, row); fractions are points between pixel centres.
    pub fn ray(&self, column: f64, row: f64) -> Ray {
        let centre = self.grid.centre_index();
        match &self.rays {
            Rays::Segments { source, first_pixel, column_step, row_step, near_pixel } => {
                let pixel = *first_pixel + column * *column_step + row * *row_step;
                let direction = pixel - *source;
                let near = if *near_pixel { pixel } else { *source };
                let length = self.grid.length_mm(direction);
                Ray::through(centre, near, direction, [Some(*source), Some(pixel)], length)
            }
            Rays::Planes { x, y, w, source, forward, size } => {
                let clip = [(2.0 * column + 1.0) / size[0] - 1.0, 1.0 - (2.0 * row + 1.0) / size[1]];
                let (a, b) = (*x - clip[0] * *w, *y - clip[1] * *w);
                let (m, n) = (a.truncate(), b.truncate());
                let direction = *forward * m.cross(n);
                // The point of both planes that is nearest to the volume's centre.
                let nearest = *forward * (-a.w * n.cross(direction) + b.w * m.cross(direction))
                    / direction.length_squared();
                Ray::through(
                    centre,
                    centre + nearest,
                    direction,
                    [*source, None],
                    self.grid.length_mm(direction),
                )
            }
        }
    }
}

/// Where two planes meet that turn evenly with the pixel: column i's is `a[0] + i·a[1]`, row j's is `b[0] + j·b[1]`. The
/// products i·j vanish, because a[1] and b[1] are parallel.
fn intersections(a: [DVec4; 2], b: [DVec4; 2], forward: f64) -> [Even; 2] {
    let normal = |plane: DVec4| plane.truncate();
    let direction = |a: DVec4, b: DVec4| forward * normal(a).cross(normal(b));
    let moment = |a: DVec4, b: DVec4| forward * (a.w * normal(b) - b.w * normal(a));
    let even = |product: &dyn Fn(DVec4, DVec4) -> DVec3| Even {
        constant: product(a[0], b[0]),
        column: product(a[1], b[0]),
        row: product(a[0], b[1]),
    };
    [even(&direction), even(&moment)]
}

/// Refuses a source that is not where the matrix's three planes meet. What float32 matrices and sources may be off by:
/// 1e-5 of the distances between source and volume, for a matrix multiplied up in float32, and the rounding of the
/// numbers themselves where the world's origin is far away.
fn check_source(projection: &Projection, grid: &Grid) -> Result<()> {
    let source = projection.source;
    let extent = grid.length_mm(DVec3::from_array(grid.dimensions().map(|n| n as f64)));
    for (name, row) in ["x", "y", "w"].into_iter().zip(projection.rows()) {
        let terms = (row.truncate() * source).extend(row.w);
        let per_mm = row.truncate().length();
        let rounding = 8.0 * f64::from(f32::EPSILON) * terms.abs().element_sum() / per_mm;
        let off = terms.element_sum().abs() / per_mm;
        if off > 1e-5 * ((source - grid.centre()).length() + extent) + rounding {
            let valid = "the point that modelViewProjectionMatrix sends to (0, 0, *, 0)";
            return Err(Error::invalid(
                "sourcePosition",
                source,
                format!("{valid}; it is {off:.3e} mm off in {name}"),
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
pub(super) mod tests {
    use glam::{DAffine3, DMat3, DMat4};

    use super::*;

    const SIZE: [usize; 2] = [37, 22];

    /// Anisotropic voxels on axes that lie askew in the world.
    pub(in crate::raycast) fn oblique_grid() -> Grid {
        let columns = DMat3::from_cols(
            DVec3::new(-0.7, 0.02, 0.0),
            DVec3::new(0.05, 0.69, 0.1),
            DVec3::new(0.0, 0.3, 2.5),
        );
        Grid::new([64, 48, 33], DAffine3 { matrix3: columns, translation: DVec3::new(30.0, -12.0, 7.0) })
            .expect("valid")
    }

    fn pose(grid: &Grid, distance: f64) -> DetectorPose {
        DetectorPose {
            row_step: DVec3::new(0.1, 0.3, 2.0),
            ..DetectorPose::c_arm(grid.centre(), 17.0, distance, distance + 500.0, 1.5, SIZE)
        }
    }

    #[test]
    fn a_projection_and_its_pose_give_the_same_lines() {
        let grid = oblique_grid();
        for distance in [300.0, 1000.0, 1e6] {
            let pose = pose(&grid, distance);
            let projection = Projection::from_pose(&pose, SIZE).expect("valid");
            let segments = Beam::new(&View::Pose(pose), &grid, SIZE).expect("valid");
            let planes = Beam::new(&View::Projection(projection), &grid, SIZE).expect("valid");
            for (i, j) in [(0.0, 0.0), (36.0, 0.0), (18.3, 10.2), (0.0, 21.0), (36.0, 21.0)] {
                let (a, b) = (segments.ray(i, j), planes.ray(i, j));
                assert_eq!(a.axis, b.axis);
                for t in 0..2 {
                    assert!((a.base[t] - b.base[t]).abs() < 1e-15 * distance + 1e-12, "{a:?} {b:?}");
                    assert!((a.slope[t] - b.slope[t]).abs() < 1e-12);
                }
                assert!((a.mm_per_slice - b.mm_per_slice).abs() < 1e-12 * a.mm_per_slice);
                let source =
                    b.limits.into_iter().find(|s| s.is_finite()).expect("a half-line starts somewhere");
                assert!(a.limits.iter().any(|s| (s - source).abs() < 1e-6 * distance), "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn rays_pass_through_source_and_pixel() {
        let grid = oblique_grid();
        let pose = pose(&grid, 900.0);
        let beam = Beam::new(&View::Pose(pose), &grid, SIZE).expect("valid");
        for (i, j) in [(0.0, 0.0), (36.0, 21.0), (5.5, 3.25)] {
            let ray = beam.ray(i, j);
            for world in [pose.source, pose.pixel(i, j)] {
                let p = grid.point_to_index(world);
                let at = DVec3::from_array(ray.point(p[ray.axis]));
                assert!((at - p).length() < 1e-9);
            }
        }
    }

    #[test]
    fn a_source_must_be_where_the_planes_meet_to_what_float32_can_say() {
        // World offset, error of the source: accepted or not.
        for (offset, error, fits) in
            [(0.0, 0.0, true), (0.0, 1e-3, true), (0.0, 0.1, false), (1e6, 0.06, true), (1e6, 10.0, false)]
        {
            let origin = DVec3::new(offset, -offset, 0.5 * offset);
            let grid = Grid::axis_aligned([64, 64, 64], DVec3::ONE, origin).expect("valid");
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let exact = Projection::from_pose(&pose(&grid, 900.0), SIZE).expect("valid");
                let matrix =
                    DMat4::from_cols_array(&exact.matrix.to_cols_array().map(|x| f64::from(x as f32)));
                let source = (exact.source + error * axis).as_vec3().as_dvec3();
                let view = View::Projection(Projection { matrix, source });
                assert_eq!(
                    Beam::new(&view, &grid, SIZE).is_ok(),
                    fits,
                    "{error} mm at {offset} mm along {axis}"
                );
            }
        }
        // A source at the origin, and a matrix multiplied up in float32 whose planes pass 2e-6 mm beside it.
        let grid =
            Grid::axis_aligned([64, 64, 64], DVec3::ONE, DVec3::new(-32.0, 700.0, -32.0)).expect("valid");
        let mut beside = Projection::from_pose(&pose(&grid, 900.0), SIZE).expect("valid");
        let shift = DMat4::from_translation(beside.source);
        beside.matrix *= shift;
        beside.matrix.w_axis.x += 2e-6 * beside.matrix.row(0).truncate().length();
        beside.source = DVec3::ZERO;
        assert!(Beam::new(&View::Projection(beside), &grid, SIZE).is_ok());
    }

    #[test]
    fn an_orthographic_matrix_gives_parallel_rays_without_a_source() {
        let grid = Grid::centred([10, 10, 10], DVec3::ONE).expect("valid");
        let matrix = DMat4::from_diagonal(DVec4::new(0.2, 0.2, 0.005, 1.0));
        let projection = Projection { matrix, source: DVec3::NAN };
        let beam = Beam::new(&View::Projection(projection), &grid, [10, 10]).expect("valid");
        for i in 0..10 {
            let ray = beam.ray(f64::from(i), 9.0);
            assert_eq!((ray.axis, ray.slope), (2, [0.0, 0.0]));
            assert!((ray.base[0] - f64::from(i)).abs() < 1e-12 && ray.base[1].abs() < 1e-12, "{ray:?}");
            assert_eq!(ray.clip([10, 10, 10]).map(|s| s.leave - s.enter), Some(10.0));
        }
    }

    #[test]
    fn rows_too_different_to_tell_rays_apart_are_refused() {
        let grid = Grid::centred([10, 10, 10], DVec3::ONE).expect("valid");
        // All pixels within an angle of `scale`, in float64's last digits or beyond them.
        for (scale, fits) in [(1.0, true), (1e9, true), (1e14, false), (1e30, false), (1e60, false)] {
            let source = DVec3::new(0.0, 0.0, -100.0);
            let matrix = DMat4::from_cols(
                DVec4::new(1.0, 0.0, 0.0, 0.0),
                DVec4::new(0.0, 1.0, 0.0, 0.0),
                DVec4::new(0.0, 0.0, 0.0, scale),
                DVec4::new(0.0, 0.0, 0.0, 100.0 * scale),
            );
            let beam = Beam::new(&View::Projection(Projection { matrix, source }), &grid, [8, 8]);
            assert_eq!(beam.is_ok(), fits, "{scale}: {beam:?}");
        }
    }
}
