//! The float64 reference engine against exact rational arithmetic, on small volumes whose densities, and rays whose ends,
//! are dyadic fractions: every number of the problem is exact in float64, so that only the engine's own rounding is seen.
#![allow(missing_docs, reason = "a test program")]

mod support;

use std::sync::Arc;

use drr::engine::Backend;
use drr::geometry::{DetectorPose, Grid};
use drr::volume::Volume;
use drr::{Algorithm, Scene};
use glam::DVec3;
use num_rational::{BigRational, Ratio};
use support::{ALL, classification, noise, projector, quiet, requests};

const DIMENSIONS: [usize; 3] = [5, 4, 6];

fn rational(x: f64) -> BigRational {
    Ratio::from_float(x).expect("finite")
}

/// HU −1000 … −250 in steps of 125: densities are eighths.
fn hu(index: usize) -> i16 {
    -1000 + 125 * (noise(index as u64) * 7.0) as i16
}

fn density([i, j, k]: [usize; 3]) -> BigRational {
    rational(1.0 + f64::from(hu((k * DIMENSIONS[1] + j) * DIMENSIONS[0] + i)) / 1000.0)
}

/// A segment from `from` to `to` in index space; the parameter runs from 0 to 1.
struct Segment {
    from: [BigRational; 3],
    step: [BigRational; 3],
}

impl Segment {
    fn new(from: DVec3, to: DVec3) -> Self {
        let from = from.to_array().map(rational);
        let to = to.to_array().map(rational);
        let step = std::array::from_fn(|axis| &to[axis] - &from[axis]);
        Self { from, step }
    }

    fn at(&self, t: &BigRational) -> [BigRational; 3] {
        std::array::from_fn(|axis| &self.from[axis] + &self.step[axis] * t)
    }

    /// 0, 1, and every t between at which a coordinate is an integer + `offset`, ascending.
    fn cuts(&self, offset: f64) -> Vec<BigRational> {
        let (zero, one) = (rational(0.0), rational(1.0));
        let mut cuts = vec![zero.clone(), one.clone()];
        for (axis, n) in DIMENSIONS.into_iter().enumerate() {
            if self.step[axis] != zero {
                // The box's faces are cuts in either case.
                let planes = (-1..=n as i32).map(|plane| f64::from(plane) + offset);
                for plane in planes.chain([-0.5, n as f64 - 0.5]) {
                    let t = (rational(plane) - &self.from[axis]) / &self.step[axis];
                    if t > zero && t < one {
                        cuts.push(t);
                    }
                }
            }
        }
        cuts.sort();
        cuts.dedup();
        cuts
    }

    /// ∫ field dt, summing `piece(begin, middle, end)` over the pieces inside the box.
    fn integral(&self, offset: f64, piece: impl Fn([&[BigRational; 3]; 3]) -> BigRational) -> BigRational {
        let cuts = self.cuts(offset);
        let mut sum = rational(0.0);
        for pair in cuts.windows(2) {
            let middle = self.at(&((&pair[0] + &pair[1]) / rational(2.0)));
            let inside = |axis: usize| {
                middle[axis] >= rational(-0.5) && middle[axis] < rational(DIMENSIONS[axis] as f64 - 0.5)
            };
            if (0..3).all(inside) {
                sum += (&pair[1] - &pair[0]) * piece([&self.at(&pair[0]), &middle, &self.at(&pair[1])]);
            }
        }
        sum
    }

    /// Siddon's integral: every voxel is [i−½, i+½).
    fn siddon(&self) -> BigRational {
        self.integral(0.5, |[_, middle, _]| {
            density(std::array::from_fn(|axis| {
                let index = (&middle[axis] + rational(0.5)).floor().to_integer();
                usize::try_from(index).expect("inside")
            }))
        })
    }

    /// The integral of the trilinear field with edge values held: cubic on every piece, so Simpson's rule is exact.
    fn trilinear(&self) -> BigRational {
        self.integral(0.0, |[begin, middle, end]| {
            // Each piece lies in one cell, that of its middle; the cell's polynomial holds up to its ends.
            let cell = middle.clone().map(|x| x.floor());
            let value = |p: &[BigRational; 3]| trilinear_in(&cell, p);
            (value(begin) + value(middle) * rational(4.0) + value(end)) / rational(6.0)
        })
    }
}

/// The polynomial of one cell of the field at a point.
fn trilinear_in(cell: &[BigRational; 3], point: &[BigRational; 3]) -> BigRational {
    let mut sum = rational(0.0);
    for corner in 0..8_usize {
        let mut weight = rational(1.0);
        let at = std::array::from_fn(|axis| {
            let fraction = &point[axis] - &cell[axis];
            let upper = corner >> axis & 1;
            weight *= if upper == 1 { fraction } else { rational(1.0) - fraction };
            let index = &cell[axis] + rational(upper as f64);
            let last = rational(DIMENSIONS[axis] as f64 - 1.0);
            let held = index.clamp(rational(0.0), last).to_integer();
            usize::try_from(held).expect("clamped")
        });
        sum += weight * density(at);
    }
    sum
}

fn to_f64(x: &BigRational) -> f64 {
    // Good to an ulp or two: 120 bits of quotient, then float64.
    let scale = BigRational::from_integer((1_u128 << 100).into());
    let scaled = (x * &scale).round().to_integer();
    scaled.to_string().parse::<f64>().expect("a decimal integer") / 2_f64.powi(100)
}

/// Rays by their ends: generic, axis-parallel, in faces and along edges, through corners, starting and ending inside.
fn rays() -> Vec<(&'static str, DVec3, DVec3)> {
    let v = DVec3::new;
    let mut rays = vec![
        ("along x", v(-9.0, 1.25, 2.75), v(12.0, 1.25, 2.75)),
        ("along -y", v(1.5, 20.0, 2.25), v(1.5, -20.0, 2.25)),
        ("along z, through centres", v(2.0, 1.0, -30.0), v(2.0, 1.0, 31.0)),
        ("in the outer half voxel", v(-7.0, -0.375, 5.25), v(11.0, -0.375, 5.25)),
        ("space diagonal", v(-2.5, -2.5, -2.5), v(7.5, 7.5, 7.5)),
        ("through corners", v(-1.5, 4.5, -0.5), v(4.5, -1.5, 5.5)),
        ("a tilt of 2^-30", v(-8.0, 1.25, 2.75), v(8.0, 1.25 + 2_f64.powi(-30), 2.75)),
        ("a tilt of 2^-45", v(-8.0, 1.25, 2.75), v(8.0, 1.25 + 2_f64.powi(-45), 2.75)),
        ("source inside", v(2.25, 1.5, 3.125), v(9.0, 8.0, -4.0)),
        ("both in one voxel", v(2.125, 1.0625, 3.25), v(1.75, 0.75, 3.375)),
        ("source on a corner of the box", v(-0.5, -0.5, -0.5), v(6.0, 3.0, 7.0)),
        ("touching an edge of the box", v(-1.5, 0.5, 2.0), v(0.5, -1.5, 2.0)),
        ("missing", v(-9.0, 9.0, 2.0), v(9.0, 9.5, 2.0)),
        ("from 2^20 away", v(-1_048_576.0, 1.0, 2.0), v(9.0, 2.0, 3.0)),
    ];
    for k in 0..40 {
        let coordinate = |n: u64| (128.0 * noise(1000 + 6 * k + n)).round() / 8.0 - 6.0;
        rays.push((
            "generic",
            v(coordinate(0), coordinate(1), coordinate(2)),
            v(coordinate(3), coordinate(4), coordinate(5)),
        ));
    }
    rays
}

#[test]
fn the_reference_engine_is_exact_to_rounding() {
    // The centre, (n−1)/2, and the spacing are exact too.
    let grid = Grid::axis_aligned(DIMENSIONS, DVec3::ONE, DVec3::ZERO).expect("valid");
    let values: Vec<i16> = (0..grid.voxel_count()).map(hu).collect();
    let labels = vec![2; values.len()];
    let volume =
        Arc::new(Volume::from_int16(grid, &values, Some(&labels), &classification()).expect("valid"));
    let projector = projector(Backend::Reference, &volume, Scene::new([1, 1]).expect("valid"));
    let mut hits = 0;
    for (name, from, to) in rays() {
        let across = (to - from).normalize().any_orthonormal_vector();
        let pose = DetectorPose {
            source: from,
            first_pixel: to,
            column_step: across,
            row_step: (to - from).normalize().cross(across),
        };
        let segment = Segment::new(from, to);
        for (algorithm, integral) in
            [(Algorithm::Siddon, segment.siddon()), (Algorithm::Exact, segment.trilinear())]
        {
            // mm, and mm to cm.
            let exact = 0.1 * (to - from).length() * to_f64(&integral);
            let images = projector.reference(algorithm, &requests([pose]), ALL, &quiet).expect("projects");
            let got = images.areal_density(0, 2)[0];
            // A64 of hard-cases.md: 1e-13 S + 8 u64 D V, in g/cm²; D is the largest coordinate, V < 1 g/cm³.
            let largest = from.abs().max(to.abs()).max_element().max(6.0);
            let bound = 1e-13 * exact + 0.1 * 8.0 * 1.1e-16 * largest;
            let error = (got - exact).abs();
            assert!(
                error <= bound,
                "{algorithm:?}, {name}: {got} for {exact}, error {error:.2e} > {bound:.2e}"
            );
            hits += usize::from(exact > 0.0);
        }
    }
    assert!(hits > 50, "only {hits} rays hit");
}
