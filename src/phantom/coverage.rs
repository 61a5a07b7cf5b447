//! What share of a voxel's box a shape covers.

use glam::DVec3;

use super::Shape;

/// How a shape covers an axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Coverage {
    /// Not at all.
    Outside,
    /// Wholly.
    Inside,
    /// In part: by a share that is known in closed form.
    Share(f64),
    /// Perhaps in part: there is no closed form.
    Straddling,
}

impl Coverage {
    /// Of the box between two corners, mm.
    pub(super) fn of(shape: &Shape, minimum: DVec3, maximum: DVec3) -> Self {
        match *shape {
            Shape::Cuboid { minimum: low, maximum: high } => {
                let overlap = (high.min(maximum) - low.max(minimum)).max(DVec3::ZERO);
                Self::from_share((overlap / (maximum - minimum)).element_product())
            }
            Shape::Ellipsoid { centre, semi_axes } => {
                let (low, high) = ((minimum - centre) / semi_axes, (maximum - centre) / semi_axes);
                if DVec3::ZERO.clamp(low, high).length_squared() >= 1.0 {
                    Self::Outside
                } else if low.abs().max(high.abs()).length_squared() <= 1.0 {
                    Self::Inside
                } else {
                    Self::Straddling
                }
            }
            Shape::Cylinder { centre, axis, radius, half_length } => {
                let (low, high) = (minimum - centre, maximum - centre);
                match (0..3).find(|&along| axis[along].abs() == 1.0) {
                    Some(along) => Self::of_upright_cylinder(along, radius, half_length, low, high),
                    None => Self::of_tilted_cylinder(axis, radius, half_length, low, high),
                }
            }
        }
    }

    fn from_share(share: f64) -> Self {
        if share <= 0.0 {
            Self::Outside
        } else if share >= 1.0 {
            Self::Inside
        } else {
            Self::Share(share)
        }
    }

    fn of_upright_cylinder(along: usize, radius: f64, half_length: f64, low: DVec3, high: DVec3) -> Self {
        let overlap = (high[along].min(half_length) - low[along].max(-half_length)).max(0.0);
        let axial = overlap / (high[along] - low[along]);
        if axial == 0.0 {
            return Self::Outside;
        }
        let (u, v) = ((along + 1) % 3, (along + 2) % 3);
        Self::from_share(axial * disc_share(radius, [low[u], high[u]], [low[v], high[v]]))
    }

    fn of_tilted_cylinder(axis: DVec3, radius: f64, half_length: f64, low: DVec3, high: DVec3) -> Self {
        let middle = 0.5 * (low + high);
        let reach = 0.5 * (high - low).length();
        let along = middle.dot(axis).abs();
        let across = middle.cross(axis).length();
        if along >= half_length + reach || across >= radius + reach {
            Self::Outside
        } else if along <= half_length - reach && across <= radius - reach {
            Self::Inside
        } else {
            Self::Straddling
        }
    }
}

/// Share of the rectangle `x` × `y` inside the disc about the origin; exactly 0 and 1 when it is outside or inside.
fn disc_share(radius: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let nearest = 0.0_f64.clamp(x[0], x[1]).hypot(0.0_f64.clamp(y[0], y[1]));
    let farthest = x[0].abs().max(x[1].abs()).hypot(y[0].abs().max(y[1].abs()));
    if nearest >= radius {
        0.0
    } else if farthest <= radius {
        1.0
    } else {
        let corner = |x: f64, y: f64| (x * y).signum() * quadrant_area(radius, x.abs(), y.abs());
        let area = corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0]);
        (area / ((x[1] - x[0]) * (y[1] - y[0]))).clamp(0.0, 1.0)
    }
}

/// Area of the disc about the origin within [0, x] × [0, y].
fn quadrant_area(radius: f64, x: f64, y: f64) -> f64 {
    let (x, y) = (x.min(radius), y.min(radius));
    let half_chord = |at: f64| ((radius - at) * (radius + at)).sqrt();
    let flat = half_chord(y);
    if x <= flat {
        return x * y;
    }
    // A rectangle up to where the circle comes down to y, then the area under the circle.
    let primitive = |at: f64| {
        let height = half_chord(at);
        0.5 * (at * height + radius * radius * at.atan2(height))
    };
    flat * y + primitive(x) - primitive(flat)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// Midpoint rule over x of the exact height of the disc within the rectangle.
    fn by_quadrature(radius: f64, x: [f64; 2], y: [f64; 2]) -> f64 {
        let n = 20_000;
        let height = |at: f64| {
            let half = (radius * radius - at * at).max(0.0).sqrt();
            (y[1].min(half) - y[0].max(-half)).max(0.0)
        };
        let step = (x[1] - x[0]) / f64::from(n);
        (0..n).map(|i| height(x[0] + (f64::from(i) + 0.5) * step)).sum::<f64>() * step
            / ((x[1] - x[0]) * (y[1] - y[0]))
    }

    #[test]
    fn disc_share_of_known_rectangles() {
        assert_eq!(disc_share(100.0, [-1.0, 2.0], [3.0, 4.0]), 1.0);
        assert_eq!(disc_share(1.0, [1.0, 2.0], [0.0, 1.0]), 0.0);
        assert!((disc_share(1.0, [0.0, 1.0], [0.0, 1.0]) - PI / 4.0).abs() < 1e-15, "quarter");
        assert!((disc_share(1.0, [-9.0, 0.0], [-9.0, 9.0]) - PI / 2.0 / 162.0).abs() < 1e-15, "half");
        assert!((disc_share(1.0, [-2.0, 2.0], [-2.0, 2.0]) - PI / 16.0).abs() < 1e-15, "whole disc");
        // A strip |y| ≤ 1/2 of the unit disc: π/3 + √3/2.
        let strip = disc_share(1.0, [-1.0, 1.0], [-0.5, 0.5]) * 2.0;
        assert!((strip - (PI / 3.0 + 0.75_f64.sqrt())).abs() < 1e-14, "{strip}");
    }

    #[test]
    fn disc_share_agrees_with_quadrature() {
        for radius in [1.0, 7.3, 100.0] {
            for n in 0..40 {
                let angle = f64::from(n) * 0.9;
                let centre = [radius * angle.cos(), radius * angle.sin()];
                for size in [0.1, 0.5, 3.0] {
                    let x = [centre[0] - 0.3 * size, centre[0] + 0.7 * size];
                    let y = [centre[1] - 0.6 * size, centre[1] + 0.4 * size];
                    let (exact, approximate) = (disc_share(radius, x, y), by_quadrature(radius, x, y));
                    assert!(
                        (exact - approximate).abs() < 3e-6,
                        "{radius} {x:?} {y:?}: {exact} {approximate}"
                    );
                }
            }
        }
    }

    #[test]
    fn shares_are_true_of_random_points() {
        let shapes = [
            Shape::Ellipsoid { centre: DVec3::new(0.2, 0.1, 0.0), semi_axes: DVec3::new(3.0, 2.0, 1.5) },
            Shape::Cylinder {
                centre: DVec3::new(0.1, 0.0, 0.3),
                axis: DVec3::new(2.0, -1.0, 2.0) / 3.0,
                radius: 1.5,
                half_length: 2.5,
            },
            Shape::Cylinder {
                centre: DVec3::new(0.1, 0.0, 0.3),
                axis: DVec3::NEG_X,
                radius: 1.5,
                half_length: 2.5,
            },
            Shape::Cuboid { minimum: DVec3::new(-2.2, -1.7, -1.3), maximum: DVec3::new(2.6, 1.4, 2.8) },
        ];
        for shape in shapes {
            let mut seen = [0; 4];
            for n in 0..9 * 9 * 9 {
                let low = DVec3::new(f64::from(n % 9), f64::from(n / 9 % 9), f64::from(n / 81)) - 4.5;
                let high = low + 1.0;
                let m = 12;
                let inside = (0..m * m * m)
                    .map(|p| DVec3::new(f64::from(p % m), f64::from(p / m % m), f64::from(p / m / m)))
                    .filter(|p| shape.contains(low + (p + 0.5) / f64::from(m)))
                    .count();
                let share = inside as f64 / f64::from(m * m * m);
                match Coverage::of(&shape, low, high) {
                    Coverage::Outside => {
                        assert_eq!(inside, 0, "{shape:?} {low}");
                        seen[0] += 1;
                    }
                    Coverage::Inside => {
                        assert_eq!(share, 1.0, "{shape:?} {low}");
                        seen[1] += 1;
                    }
                    Coverage::Share(exact) => {
                        assert!((exact - share).abs() < 0.13, "{shape:?} {low}: {exact} {share}");
                        seen[2] += 1;
                    }
                    Coverage::Straddling => seen[3] += 1,
                }
            }
            let closed_form = seen[2] > 0;
            assert!(seen[0] > 0 && seen[1] > 0 && (closed_form != (seen[3] > 0)), "{shape:?}: {seen:?}");
        }
    }
}
