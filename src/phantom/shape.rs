//! Solids whose intersection with a line is known in closed form.

use glam::{BVec3, DVec3};

use crate::error::{Error, Result};

/// A convex solid in world mm. Its surface belongs to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// An axis-aligned ellipsoid.
    Ellipsoid {
        /// The centre, mm.
        centre: DVec3,
        /// Half the length along x, y, z, mm.
        semi_axes: DVec3,
    },
    /// A circular cylinder of finite length.
    Cylinder {
        /// The point half way along the axis, mm.
        centre: DVec3,
        /// The direction of the axis, a unit vector.
        axis: DVec3,
        /// The radius, mm.
        radius: f64,
        /// From the centre to either end, mm.
        half_length: f64,
    },
    /// An axis-aligned box.
    Cuboid {
        /// The corner with the smallest coordinates, mm.
        minimum: DVec3,
        /// The corner with the largest coordinates, mm.
        maximum: DVec3,
    },
}

impl Shape {
    /// A ball: centre and radius in mm.
    pub fn sphere(centre: DVec3, radius: f64) -> Self {
        Self::Ellipsoid { centre, semi_axes: DVec3::splat(radius) }
    }

    /// Checks that all numbers are finite, all sizes are positive, and a cylinder's axis is a unit vector.
    pub fn validate(&self) -> Result<()> {
        let (centre, size) = match *self {
            Self::Ellipsoid { centre, semi_axes } => (centre, semi_axes),
            Self::Cylinder { centre, axis, radius, half_length } => {
                let unit = (axis.length() - 1.0).abs() <= 1e-12;
                if !unit {
                    return Err(Error::invalid("shape.axis", axis, "a unit vector, to 1e-12"));
                }
                (centre, DVec3::new(radius, radius, half_length))
            }
            Self::Cuboid { minimum, maximum } => (minimum, maximum - minimum),
        };
        if !centre.is_finite() {
            return Err(Error::invalid("shape's position", centre, "finite numbers, mm"));
        }
        if !(size.min_element() > 0.0 && size.is_finite()) {
            return Err(Error::invalid("shape's size", size, "finite and greater than 0, mm"));
        }
        Ok(())
    }

    /// The centre of symmetry, mm.
    pub fn centre(&self) -> DVec3 {
        match *self {
            Self::Ellipsoid { centre, .. } | Self::Cylinder { centre, .. } => centre,
            Self::Cuboid { minimum, maximum } => 0.5 * (minimum + maximum),
        }
    }

    /// The smallest and the largest x, y, z of the shape, mm.
    pub fn bounds(&self) -> [DVec3; 2] {
        match *self {
            Self::Ellipsoid { centre, semi_axes } => [centre - semi_axes, centre + semi_axes],
            Self::Cylinder { centre, axis, radius, half_length } => {
                let across = ((1.0 - axis) * (1.0 + axis)).max(DVec3::ZERO).map(f64::sqrt);
                let half = half_length * axis.abs() + radius * across;
                [centre - half, centre + half]
            }
            Self::Cuboid { minimum, maximum } => [minimum, maximum],
        }
    }

    /// The radius, mm, of a ball about the centre that holds the shape.
    pub(super) fn reach(&self) -> f64 {
        match *self {
            Self::Ellipsoid { semi_axes, .. } => semi_axes.max_element(),
            Self::Cylinder { radius, half_length, .. } => radius.hypot(half_length),
            Self::Cuboid { minimum, maximum } => 0.5 * (maximum - minimum).length(),
        }
    }

    /// Whether the point (mm) lies inside or on the surface.
    pub fn contains(&self, point: DVec3) -> bool {
        match *self {
            Self::Ellipsoid { centre, semi_axes } => ((point - centre) / semi_axes).length_squared() <= 1.0,
            Self::Cylinder { centre, axis, radius, half_length } => {
                let offset = point - centre;
                let along = offset.dot(axis);
                along.abs() <= half_length && (offset - along * axis).length_squared() <= radius * radius
            }
            Self::Cuboid { minimum, maximum } => point.cmpge(minimum) & point.cmple(maximum) == BVec3::TRUE,
        }
    }

    /// The parameters t between which the line `origin + t * direction` is inside, smaller one first; `None` when it
    /// misses. `direction` need not be a unit vector; t is in units of its length, and no direction (0, 0, 0) hits.
    ///
    /// The solution is relative to the point of the line that is nearest to the centre, so that a far origin costs no
    /// digits of the chord until the offset is added at the end.
    pub fn interval(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let (nearest, position) = approach(self.centre(), origin, direction)?;
        let [enter, leave] = self.interval_about_centre(position, direction)?;
        Some([nearest + enter, nearest + leave])
    }

    /// As `interval`, with the centre as the frame's origin and a position not far from it.
    fn interval_about_centre(&self, position: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        match *self {
            Self::Ellipsoid { semi_axes, .. } => ball(position / semi_axes, direction / semi_axes, 1.0),
            Self::Cylinder { axis, radius, half_length, .. } => {
                let ends = slab(position.dot(axis), direction.dot(axis), half_length)?;
                let (u, v) = axis.any_orthonormal_pair();
                let across = |w: DVec3| DVec3::new(w.dot(u), w.dot(v), 0.0);
                intersection(ends, ball(across(position), across(direction), radius)?)
            }
            Self::Cuboid { minimum, maximum } => {
                let half = 0.5 * (maximum - minimum);
                let x = slab(position.x, direction.x, half.x)?;
                let y = slab(position.y, direction.y, half.y)?;
                let z = slab(position.z, direction.z, half.z)?;
                intersection(intersection(x, y)?, z)
            }
        }
    }

    /// The coordinate axis (0, 1, 2) that is most nearly normal to the surface next to `point`.
    pub(super) fn normal_axis(&self, point: DVec3) -> usize {
        let offset = point - self.centre();
        let normal = match *self {
            Self::Ellipsoid { semi_axes, .. } => offset / (semi_axes * semi_axes),
            Self::Cylinder { axis, .. } => offset - offset.dot(axis) * axis,
            Self::Cuboid { minimum, maximum } => offset / (maximum - minimum),
        };
        normal.abs().max_position()
    }
}

/// The parameter at which the line `origin + t * direction` is nearest to `centre`, and that point relative to the centre;
/// `None` where there is none: no direction, or no numbers.
pub(crate) fn approach(centre: DVec3, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let offset = origin - centre;
    let nearest = -offset.dot(direction) / direction.length_squared();
    // Fused: the product of a large parameter and the direction is not rounded before it cancels the offset.
    nearest.is_finite().then(|| (nearest, direction.mul_add(DVec3::splat(nearest), offset)))
}

/// Where |position + t * velocity| ≤ radius: all t when the velocity is 0 and the position inside.
fn ball(position: DVec3, velocity: DVec3, radius: f64) -> Option<[f64; 2]> {
    let speed_squared = velocity.length_squared();
    if speed_squared == 0.0 {
        return (position.length() <= radius).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let middle = -position.dot(velocity) / speed_squared;
    let miss = velocity.mul_add(DVec3::splat(middle), position).length();
    // The factored discriminant keeps its digits for grazing lines, b² − 4ac does not.
    let discriminant = (radius - miss) * (radius + miss);
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let half = (discriminant / speed_squared).sqrt();
    Some([middle - half, middle + half])
}

/// Where |position + t * velocity| ≤ half: all t when the velocity is 0 and the position inside.
fn slab(position: f64, velocity: f64, half: f64) -> Option<[f64; 2]> {
    if velocity == 0.0 {
        return (position.abs() <= half).then_some([f64::NEG_INFINITY, f64::INFINITY]);
    }
    let (a, b) = ((-half - position) / velocity, (half - position) / velocity);
    Some([a.min(b), a.max(b)])
}

/// The part of two intervals that both have.
pub(crate) fn intersection(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    let (start, end) = (a[0].max(b[0]), a[1].min(b[1]));
    (start <= end).then_some([start, end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chord(shape: &Shape, origin: DVec3, direction: DVec3) -> f64 {
        shape.interval(origin, direction).map_or(0.0, |[a, b]| (b - a) * direction.length())
    }

    fn tilted() -> Shape {
        let axis = DVec3::new(2.0, -1.0, 2.0) / 3.0;
        Shape::Cylinder { centre: DVec3::new(3.0, 4.0, -5.0), axis, radius: 6.0, half_length: 40.0 }
    }

    #[test]
    fn axis_parallel_chords_follow_pythagoras() {
        let ball = Shape::sphere(DVec3::new(1.0, 2.0, 3.0), 5.0);
        let off = DVec3::new(1.0, 2.0 + 3.0, 3.0);
        for (direction, expected) in [(DVec3::X, 8.0), (DVec3::NEG_Z, 8.0), (DVec3::Y, 10.0)] {
            assert_eq!(chord(&ball, off, direction), expected, "{direction}");
        }
        let egg = Shape::Ellipsoid { centre: DVec3::ZERO, semi_axes: DVec3::new(10.0, 20.0, 40.0) };
        // x at y/b = 0.6 is 0.8 a.
        assert!((chord(&egg, DVec3::new(-500.0, 12.0, 0.0), DVec3::X) - 16.0).abs() < 1e-13);
    }

    #[test]
    fn the_sign_of_a_zero_does_not_matter() {
        for shape in
            [tilted(), Shape::Cuboid { minimum: DVec3::splat(-9.0), maximum: DVec3::new(1.0, 7.0, 3.0) }]
        {
            let origin = DVec3::new(-100.0, 0.0, 0.0);
            let plus = shape.interval(origin, DVec3::new(1.0, 0.0, 0.0)).unwrap();
            let minus = shape.interval(origin, DVec3::new(1.0, -0.0, -0.0)).unwrap();
            assert_eq!(plus, minus);
        }
    }

    #[test]
    fn tilted_cylinder_is_crossed_along_and_across_its_axis() {
        let Shape::Cylinder { centre, axis, radius, half_length } = tilted() else { unreachable!() };
        let along = chord(&tilted(), centre - 77.0 * axis, axis);
        assert!((along - 2.0 * half_length).abs() < 1e-12, "{along}");
        let across = DVec3::new(1.0, 2.0, 0.0) / 5.0_f64.sqrt();
        assert!((chord(&tilted(), centre + 9.0 * axis - 50.0 * across, across) - 2.0 * radius).abs() < 1e-12);
        // At an angle a to the axis a line through the centre is 2 r / sin a long while it misses the ends.
        let slanted = (axis + 2.0 * across).normalize();
        let sine = 2.0 / 5.0_f64.sqrt();
        assert!((chord(&tilted(), centre, slanted) - 2.0 * radius / sine).abs() < 1e-12);
        // A line parallel to the axis inside the radius is cut by the ends only, outside the radius it misses.
        assert!((chord(&tilted(), centre + 0.999 * radius * across, axis) - 2.0 * half_length).abs() < 1e-12);
        assert_eq!(chord(&tilted(), centre + 1.001 * radius * across, axis), 0.0);
    }

    #[test]
    fn cuboid_diagonal_and_lines_in_its_faces() {
        let cube = Shape::Cuboid { minimum: DVec3::ZERO, maximum: DVec3::splat(8.0) };
        assert!((chord(&cube, DVec3::splat(-4.0), DVec3::ONE) - 8.0 * 3.0_f64.sqrt()).abs() < 1e-13);
        assert_eq!(chord(&cube, DVec3::new(-3.0, 8.0, 5.0), DVec3::X), 8.0, "in a face");
        assert_eq!(chord(&cube, DVec3::new(-3.0, 8.0_f64.next_up(), 5.0), DVec3::X), 0.0, "beside it");
    }

    #[test]
    fn grazing_chords_keep_their_digits() {
        // Chord 2 √((R−b)(R+b)) with R − b exact in binary: b²−4ac would lose half of the digits. What may be lost
        // is the rounding of the two parameters, which are about 1000.
        let ball = Shape::sphere(DVec3::ZERO, 128.0);
        for power in 10..40 {
            let gap = 0.5_f64.powi(power);
            let exact = 2.0 * (gap * (256.0 - gap)).sqrt();
            let error = chord(&ball, DVec3::new(-1000.0, 128.0 - gap, 0.0), DVec3::X) - exact;
            assert!(error.abs() < 3e-13, "gap 2^-{power}: {error}");
        }
        // However grazing, a shift of the line by e changes the chord by at most √(8 R e).
        let oblique = DVec3::new(0.6, 0.0, 0.8);
        for gap in [1e-3, 1e-6, 1e-9, 1e-12] {
            let origin = DVec3::new(0.0, 100.0 - gap, 0.0) - 1e3 * oblique;
            let exact = 2.0 * (gap * (200.0 - gap)).sqrt();
            let error = chord(&Shape::sphere(DVec3::ZERO, 100.0), origin, oblique) - exact;
            assert!(error.abs() <= (8.0 * 100.0 * 1e3 * f64::EPSILON).sqrt(), "gap {gap}: {error}");
        }
    }

    #[test]
    fn grazing_chords_from_afar_keep_their_digits() {
        // All numbers are exact in binary, so that only the method can lose digits. An error e of the distance to
        // the centre changes this chord by e * 3e5; the parameters at 8e5 mm are good for 1e-9 mm.
        let gap = 0.5_f64.powi(30);
        let miss = 33.25 * DVec3::new(2.0, 1.0, -2.0);
        let radius = 3.0 * 33.25 + gap;
        let direction = DVec3::new(1.0, 2.0, 2.0);
        let exact = 2.0 * (gap * (2.0 * radius - gap)).sqrt();
        let error =
            chord(&Shape::sphere(DVec3::ZERO, radius), miss - 262_144.0 * direction, direction) - exact;
        assert!(error.abs() < 2e-8, "{error}");
    }

    #[test]
    fn far_origin_costs_only_the_rounding_of_the_input() {
        let far = 1e6;
        let direction = DVec3::new(2.0, 3.0, 6.0) / 7.0;
        let shapes = [tilted(), Shape::sphere(DVec3::new(5.0, 0.5, 0.25), 20.0), {
            Shape::Cuboid { minimum: DVec3::splat(-20.0), maximum: DVec3::splat(21.0) }
        }];
        for shape in shapes {
            let near = shape.centre() + DVec3::new(0.25, 0.5, -0.125);
            let [a, b] = shape.interval(near, direction).unwrap();
            let [c, d] = shape.interval(near - far * direction, direction).unwrap();
            assert!((c - far - a).abs() < 1e-9 && (d - far - b).abs() < 1e-9, "{shape:?}");
        }
    }

    #[test]
    fn zero_direction_and_nan_hit_nothing() {
        for shape in [tilted(), Shape::sphere(DVec3::ZERO, 9.0)] {
            assert_eq!(shape.interval(shape.centre(), DVec3::ZERO), None);
            assert_eq!(shape.interval(DVec3::NAN, DVec3::X), None);
        }
    }

    #[test]
    fn ends_of_the_interval_lie_on_the_surface_and_in_the_bounds() {
        let shapes = [
            tilted(),
            Shape::Ellipsoid { centre: DVec3::new(1.0, 2.0, 3.0), semi_axes: DVec3::new(9.0, 20.0, 14.0) },
            Shape::Cuboid { minimum: DVec3::new(-8.0, -3.0, -20.0), maximum: DVec3::new(20.0, 16.0, 1.0) },
        ];
        for shape in shapes {
            let [low, high] = shape.bounds();
            let mut hits = 0;
            for n in 0..200 {
                let angle = f64::from(n) * 2.4;
                let z = f64::from(n) / 100.0 - 0.995;
                let direction = DVec3::new(angle.cos(), angle.sin(), z);
                let offset = DVec3::new((3.0 * angle).sin(), (5.0 * angle).cos(), (7.0 * angle).sin());
                let origin = shape.centre() + 6.0 * offset - 90.0 * direction;
                let Some([a, b]) = shape.interval(origin, direction) else { continue };
                hits += 1;
                let at = |t: f64| origin + t * direction;
                assert!(shape.contains(at(a + 1e-9)) && shape.contains(at(b - 1e-9)), "inside: {shape:?}");
                assert!(!shape.contains(at(a - 1e-9)) && !shape.contains(at(b + 1e-9)), "outside: {shape:?}");
                for end in [at(a), at(b)] {
                    assert!((end - end.clamp(low, high)).length() < 1e-12, "bounds: {shape:?}");
                }
            }
            assert!(hits > 100);
        }
    }

    #[test]
    fn bounds_touch_a_tilted_cylinder() {
        // The lowest point in z of each end disc lies against the axis' projection.
        let Shape::Cylinder { centre, axis, radius, half_length } = tilted() else { unreachable!() };
        let downhill = (axis * axis.z - DVec3::Z).normalize();
        let lowest = centre - half_length * axis + radius * downhill;
        assert!((tilted().bounds()[0].z - lowest.z).abs() < 1e-12);
    }

    #[test]
    fn invalid_shapes_are_named() {
        let bad = [
            Shape::sphere(DVec3::ZERO, 0.0),
            Shape::sphere(DVec3::new(f64::NAN, 0.0, 0.0), 1.0),
            Shape::Cylinder {
                centre: DVec3::ZERO,
                axis: DVec3::new(0.0, 0.0, 1.1),
                radius: 1.0,
                half_length: 1.0,
            },
            Shape::Cuboid { minimum: DVec3::ONE, maximum: DVec3::ONE },
        ];
        for shape in bad {
            assert!(matches!(shape.validate(), Err(Error::InvalidArgument { .. })), "{shape:?}");
        }
        tilted().validate().unwrap();
    }
}
