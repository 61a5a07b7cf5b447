//! Images against closed forms, and what they must be when the object moves.

use super::*;

#[test]
fn a_gaussian_blob_projects_to_its_closed_form() {
    // Voxels are σ/5: linear interpolation errs by h²/8 Σ|∂²f| at most, along the central ray by h²/(2σ²) of its
    // integral.
    let (sigma, n) = (5.0_f64, 60);
    let geometry = ParallelGeometry::new([n; 3], DVec3::ONE, [25, 27], [1.3, 1.1]);
    let centre = DVec3::new(2.3, -1.7, 3.1);
    let value = |index: usize| {
        let at = DVec3::new((index % n) as f64, (index / n % n) as f64, (index / (n * n)) as f64) - 29.5;
        (-0.5 * (at - centre).length_squared() / (sigma * sigma)).exp()
    };
    let values: Vec<f64> = (0..n * n * n).map(value).collect();
    let peak = sigma * std::f64::consts::TAU.sqrt();
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    let moved = VIEW.motion().rotation() * centre + VIEW.motion().translation;
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = ParallelProjector::new(&context, geometry, quadrature, &values).expect("valid");
        let image = projector.forward_project_view(&VIEW, RaySelection::default()).expect("valid");
        let exact = |pixel: usize| {
            let from = geometry.pixel_position((pixel % 25) as f64, (pixel / 25) as f64) - moved;
            peak * (-0.5 * (from.x * from.x + from.z * from.z) / (sigma * sigma)).exp()
        };
        let off = largest(image.iter().enumerate().map(|(pixel, value)| value - exact(pixel))) / peak;
        assert!(off < 0.5 / (sigma * sigma), "{quadrature:?}: {off:e}");
    }
}

#[test]
fn an_object_moved_by_whole_pixels_moves_its_image() {
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let projector = projector(quadrature);
        let image = |view: &ViewParameters| {
            projector.forward_project_view(view, RaySelection::default()).expect("valid")
        };
        let still = image(&VIEW);
        // Three columns of 0.9 mm, two rows of 0.7 mm.
        let moved = image(&ViewParameters { dx: VIEW.dx + 2.7, dz: VIEW.dz - 1.4, ..VIEW });
        let pixels = (3..11).flat_map(|u| (0..11).map(move |v| (u, v)));
        let off = largest(pixels.map(|(u, v)| moved[v * 11 + u] - still[(v + 2) * 11 + u - 3]));
        assert!(off < 1e-14 * largest(still.iter().copied()), "{quadrature:?}: {off:e}");
    }
}

#[test]
fn a_quarter_turn_about_z_permutes_the_axes() {
    // R_z(90°) takes x to y and y to −x: the volume turned by it, seen at φ, is the volume seen at φ + 90°.
    let geometry = ParallelGeometry { centre: DVec3::ZERO, ..geometry() };
    let [nx, ny, nz] = geometry.dimensions;
    let values = volume(geometry.dimensions);
    let mut turned = vec![0.0; values.len()];
    for (n, value) in values.iter().enumerate() {
        let [i, j, k] = [n % nx, n / nx % ny, n / (nx * ny)];
        turned[(k * nx + i) * ny + ny - 1 - j] = *value;
    }
    let other = ParallelGeometry {
        dimensions: [ny, nx, nz],
        spacing: DVec3::new(geometry.spacing.y, geometry.spacing.x, geometry.spacing.z),
        ..geometry
    };
    let context = Context::new(Backend::Cpu, 2).expect("threads");
    for quadrature in [Quadrature::Steps, Quadrature::Exact] {
        let of = |geometry: ParallelGeometry, values: &[f64], phi: f64| {
            let projector = ParallelProjector::new(&context, geometry, quadrature, values).expect("valid");
            let view = ViewParameters { phi, ..VIEW };
            projector.view_jacobian(&view, RaySelection::default()).expect("valid")
        };
        let later = of(geometry, &values, VIEW.phi + std::f64::consts::FRAC_PI_2);
        let turned = of(other, &turned, VIEW.phi);
        let planes = later.derivatives.iter().zip(&turned.derivatives);
        for (a, b) in planes.chain([(&later.image, &turned.image)]) {
            let off = largest(a.iter().zip(b).map(|(a, b)| a - b)) / largest(a.iter().copied());
            assert!(off < 4e-14, "{quadrature:?}: {off:e}");
        }
    }
}
