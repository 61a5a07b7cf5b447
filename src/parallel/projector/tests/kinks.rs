//! Where rays run in faces of cells the image has kinks: derivatives are those of the upper cells.

use super::*;

#[test]
fn angles_have_the_derivative_of_the_upper_cells() {
    // Of an object that is not turned: half of a ray's samples would enter upper cells, half lower ones. The upper
    // cells' slopes are the limit of derivatives where all samples are a little above the faces: one element of the
    // generalised Jacobian (Clarke).
    let geometry = ParallelGeometry::new([8, 9, 10], DVec3::ONE, [8, 10], [1.0, 1.0]);
    let context = Context::new(Backend::Cpu, 1).expect("threads");
    let volume = volume(geometry.dimensions);
    let projector = ParallelProjector::new(&context, geometry, Quadrature::Steps, &volume).expect("valid");
    let rays = RaySelection::default();
    let still = projector.view_jacobian(&ViewParameters::default(), rays).expect("valid");
    let h = 1e-9;
    let above = ViewParameters { dx: -h, dz: -h, ..ViewParameters::default() };
    let above = projector.view_jacobian(&above, rays).expect("valid");
    let most = largest(still.image.iter().copied());
    for k in 0..3 {
        let off = largest(still.derivatives[k].iter().zip(&above.derivatives[k]).map(|(a, b)| a - b));
        assert!(off < 2e-8 * most, "{k}: {off:e}");
        let moved = |by: f64| {
            let mut view = [0.0; 5];
            view[k] = by;
            projector.forward_project_view(&ViewParameters::from_array(view), rays).expect("valid")
        };
        let (after, before) = (moved(1e-6), moved(-1e-6));
        let kink = |n: usize| (after[n] - 2.0 * still.image[n] + before[n]) * 1e6;
        let kink = largest((0..geometry.pixels()).map(kink));
        assert!(kink > 10.0, "{k}: the sides' derivatives differ by {kink:e}");
    }
}
