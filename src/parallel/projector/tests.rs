//! Derivatives against differences, sums against closed forms.

use glam::DVec3;

use super::*;
use crate::engine::Backend;

/// Values without any symmetry.
fn volume(dimensions: [usize; 3]) -> Vec<f64> {
    let [nx, ny, nz] = dimensions;
    let value = |n: usize| {
        let [x, y, z] = [n % nx, n / nx % ny, n / (nx * ny)].map(|i| i as f64);
        1.0 + (0.9 * x + 0.3 * y * z).sin() + 0.1 * ((n * 7919 % 1009) as f64 / 1009.0)
    };
    (0..nx * ny * nz).map(value).collect()
}

fn geometry() -> ParallelGeometry {
    let geometry = ParallelGeometry::new([9, 12, 10], DVec3::new(1.0, 1.3, 0.8), [11, 13], [0.9, 0.7]);
    ParallelGeometry { centre: DVec3::new(0.4, -3.0, 0.2), detector_centre: [0.1, -0.3], ..geometry }
}

fn projector(quadrature: Quadrature) -> ParallelProjector<f64> {
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    ParallelProjector::new(&context, geometry(), quadrature, &volume(geometry().dimensions)).expect("valid")
}

const VIEW: ViewParameters = ViewParameters { alpha: 0.123, beta: -0.071, phi: 0.617, dx: 0.33, dz: -0.41 };

#[test]
fn derivatives_are_those_of_differences() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let rays = RaySelection::default();
        let jacobian = projector.view_jacobian(&VIEW, rays).expect("valid");
        for k in 0..5 {
            let moved = |by: f64| {
                let mut view = VIEW.to_array();
                view[k] += by;
                projector.forward_project_view(&ViewParameters::from_array(view), rays).expect("valid")
            };
            let h = 1e-7;
            let largest = jacobian.derivatives[k].iter().fold(0.0_f64, |most, d| most.max(d.abs()));
            let (after, before) = (moved(h), moved(-h));
            let differences = after.iter().zip(&before).map(|(a, b)| 0.5 * (a - b) / h);
            let off =
                differences.zip(&jacobian.derivatives[k]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-7 * largest, "{quadrature:?}, parameter {k}: {off:e} of {largest:e}");
        }
    }
}
