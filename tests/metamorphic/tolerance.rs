//! How far two images of the same rays may differ, and the assertions.

use drr::ViewRequest;
use drr::engine::{Backend, Images};
use drr::geometry::DetectorPose;
use glam::DVec3;
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

use crate::case::Case;

/// Bounds of the layers that are linear in the volume, laid out as they are.
pub(crate) struct Tolerance {
    areal_density: Vec<f64>,
    bone_path: Vec<f64>,
}

impl Tolerance {
    /// With S = ∫v dl, V the largest v, X half the volume's diagonal and D the largest coordinate: float64 gives
    /// S to 1e-13 S + 8 u64 D V, float32 to 1e-6 S + 8 u32 X V + 8 u64 D V. The second part allows for a ray
    /// displaced by 8 u X or 8 u D. In rays that graze a face or an edge, S ranges over more than twice the bound when
    /// they are displaced so little; there S may be that of any of them, and the range is the bound.
    pub(crate) fn of(case: &Case, engine: Backend) -> Self {
        let grid = case.grid();
        let sides = DVec3::from_array(case.dimensions.map(|n| n as f64));
        let half_diagonal = 0.5 * grid.length_mm(sides);
        let far = largest_coordinate(case);
        let set_up = 8.0 * 0.5 * f64::EPSILON * far;
        let (relative, shift) = match engine {
            Backend::Reference => (1e-13, set_up),
            _ => (1e-6, 8.0 * 0.5 * f64::from(f32::EPSILON) * half_diagonal + set_up),
        };
        let mut displaced = vec![case.pose];
        for axis in DVec3::AXES {
            for shift in [shift, -shift] {
                let by = shift * axis;
                displaced.push(DetectorPose {
                    source: case.pose.source + by,
                    first_pixel: case.pose.first_pixel + by,
                    ..case.pose
                });
            }
        }
        let views: Vec<ViewRequest> =
            displaced.into_iter().map(|pose| Case { pose, ..case.clone() }.view()).collect();
        let images = case.project_views(Backend::Reference, &views);
        let densest = |label: usize| {
            let voxels = case.voxels.0.iter().filter(|(_, l)| usize::from(*l) == label);
            voxels.map(|&(d, _)| f64::from(d) / 1024.0).fold(0.0, f64::max)
        };
        let bound = |layer: &[f64], largest: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let pixels = layer.len() / views.len();
            let at = |p: usize| {
                let values = (0..views.len()).map(|v| layer[v * pixels + p]);
                let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
                let (bound, range) = (relative * layer[p] + shift * largest(p), high - low);
                if range > 2.0 * bound { range } else { bound }
            };
            (0..pixels).map(at).collect()
        };
        let plane = case.size[0] * case.size[1];
        Self {
            // mm to cm.
            areal_density: bound(&images.areal_density, &|p| 0.1 * densest(p / plane)),
            bone_path: bound(&images.bone_path, &|_| 1.0),
        }
    }

    /// Of a sum of images, each with its own.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        Self {
            areal_density: add(&self.areal_density, &other.areal_density),
            bone_path: add(&self.bone_path, &other.bone_path),
        }
    }

    /// Whether `got` and `expected` agree in the layers that are linear in the volume.
    pub(crate) fn check(&self, got: &Images<f64>, expected: &Images<f64>) -> Result<(), TestCaseError> {
        for (layer, got, expected, bounds) in [
            ("areal density", &got.areal_density, &expected.areal_density, &self.areal_density),
            ("bone path", &got.bone_path, &expected.bone_path, &self.bone_path),
        ] {
            prop_assert_eq!(got.len(), expected.len());
            for (p, ((a, b), bound)) in got.iter().zip(expected).zip(bounds).enumerate() {
                prop_assert!((a - b).abs() <= *bound, "{layer} {p}: {a:e} for {b:e}, bound {bound:.1e}");
            }
        }
        Ok(())
    }
}

fn largest_coordinate(case: &Case) -> f64 {
    let [width, height] = case.size.map(|n| n as f64);
    let pixels = [[0.0, 0.0], [width, 0.0], [0.0, height], [width, height]];
    let corners = (0..8_usize).map(|corner| {
        let upper = |axis: usize| if corner >> axis & 1 == 1 { case.dimensions[axis] as f64 } else { 0.0 };
        case.index_to_world.transform_point3(DVec3::from_array([0, 1, 2].map(upper)) - 0.5)
    });
    let points = corners.chain(pixels.map(|[i, j]| case.pose.pixel(i, j))).chain([case.pose.source]);
    points.map(|p| p.abs().max_element()).fold(0.0, f64::max)
}

/// The layers that are linear in the volume, added.
pub(crate) fn sum(a: &Images<f64>, b: &Images<f64>) -> Images<f64> {
    let add = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a + b).collect();
    Images {
        areal_density: add(&a.areal_density, &b.areal_density),
        bone_path: add(&a.bone_path, &b.bone_path),
        ..a.clone()
    }
}

/// Every bit of every layer.
pub(crate) fn identical(got: &Images<f64>, expected: &Images<f64>) -> Result<(), TestCaseError> {
    let bits = |images: &Images<f64>| {
        [&images.intensity, &images.line_integral, &images.areal_density, &images.bone_path]
            .map(|layer| layer.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
    };
    prop_assert_eq!(bits(got), bits(expected));
    Ok(())
}
