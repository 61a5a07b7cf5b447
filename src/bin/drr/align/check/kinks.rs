//! Rays at kinks: of the sum of samples, where one of them crosses a face between two voxels.

use drr::parallel::{ParallelGeometry, ViewParameters};
use glam::{BVec3, DMat3, DVec3};

/// How far from a face float32 may take a sample for one on the other side, voxels.
const FLOAT32_VOXELS: f64 = 2e-4;

/// The samples of a ray at one pose.
struct Samples {
    back: DMat3,
    translation: DVec3,
    half: DVec3,
    geometry: ParallelGeometry,
}

impl Samples {
    fn new(geometry: &ParallelGeometry, view: &ViewParameters) -> Self {
        let motion = view.motion();
        let half = DVec3::from_array(geometry.dimensions.map(|n| 0.5 * (n as f64 - 1.0)));
        let back = motion.rotation().transpose();
        Self { back, translation: motion.translation, half, geometry: *geometry }
    }

    /// Index coordinates, of a volume centred on the origin.
    fn at(&self, pixel: usize, step: usize) -> DVec3 {
        let [nu, _] = self.geometry.detector;
        let world = self.geometry.pixel_position((pixel % nu) as f64, (pixel / nu) as f64)
            + self.geometry.step_position(step as f64) * DVec3::Y;
        self.back * (world - self.translation) / self.geometry.spacing + self.half
    }
}

/// Of each ray, whether no sample changes its voxel between the poses, and whether none comes near a face either.
pub(super) fn smooth_and_clear(
    geometry: &ParallelGeometry,
    at: &ViewParameters,
    moved: &[ViewParameters],
) -> [Vec<bool>; 2] {
    let middle = Samples::new(geometry, at);
    let moved: Vec<Samples> = moved.iter().map(|view| Samples::new(geometry, view)).collect();
    let size = DVec3::from_array(geometry.dimensions.map(|n| n as f64));
    let ray = |pixel: usize| {
        let (mut smooth, mut clear) = (true, true);
        for step in 0..geometry.steps {
            let q = middle.at(pixel, step);
            // Outside of these the field is 0.
            if (q.cmplt(DVec3::splat(-2.0)) | q.cmpgt(size + 1.0)) != BVec3::FALSE {
                continue;
            }
            let cell = q.floor();
            smooth &= moved.iter().all(|samples| samples.at(pixel, step).floor() == cell);
            let inside = q - cell;
            clear &= inside.min_element() > FLOAT32_VOXELS && inside.max_element() < 1.0 - FLOAT32_VOXELS;
        }
        (smooth, smooth && clear)
    };
    let (smooth, clear) = (0..geometry.pixels()).map(ray).unzip();
    [smooth, clear]
}
