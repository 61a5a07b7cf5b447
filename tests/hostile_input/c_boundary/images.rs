//! Projections, and what any image must be.

use drr::capi::effects::{DRR_EFFECT_BONE_PATH, DRR_EFFECT_POLYENERGETIC};
use drr::capi::outputs::{
    DRR_MAX_VIEWS, DrrOutputs, DrrReferenceOutputs, drr_outputs_init, drr_reference_outputs_init,
};
use drr::capi::projector::{DrrProjector, drr_projector_project, drr_projector_project_poses};
use drr::capi::reference::drr_reference_project;
use drr::capi::status::DrrStatus;

use super::call::succeeded;
use super::input::Input;
use super::memory::{Element, How, Place};
use super::scene::Accepted;
use super::views::{View, pose, view};
use super::volume::Extent;

/// Most views that are made.
const MOST_VIEWS: usize = 3;
/// Most exponentials and samples of one projection, so that an input takes milliseconds.
const MOST_WORK: usize = 1 << 20;
/// No calibration makes a voxel denser, g/cm³.
const LARGEST_DENSITY: f64 = 4.1;
/// Rounding of float32 sums over a few hundred terms.
const ROUNDING: f64 = 1e-5;

/// The number of views that is passed, and of those that are there: of a number that is refused no array can be made.
fn view_counts(input: &mut Input<'_>) -> (usize, usize) {
    match input.count(2, 0..MOST_VIEWS + 1) {
        n if n > DRR_MAX_VIEWS => (n, 1),
        n => (n.min(MOST_VIEWS), n.min(MOST_VIEWS)),
    }
}

/// What bounds the images of one view.
struct Bounds {
    i0: f64,
    /// Areal density of all materials together, g/cm².
    areal_density: f64,
    /// Optical depth in any energy.
    depth: f64,
    bone_path_mm: f64,
}

impl Bounds {
    fn of(scene: &Accepted, grid: &Extent, view: Option<&View>) -> Self {
        let areal_density = 0.1 * LARGEST_DENSITY * grid.diagonal_mm * (1.0 + ROUNDING);
        let attenuation = view.and_then(|view| view.largest_attenuation).unwrap_or(scene.largest_attenuation);
        Self {
            i0: view.and_then(|view| view.i0).unwrap_or(scene.i0),
            areal_density,
            depth: areal_density * attenuation * (1.0 + ROUNDING),
            bone_path_mm: grid.diagonal_mm * (1.0 + ROUNDING),
        }
    }
}

/// Projects by one of the three functions. Whether there are images.
pub(super) fn project(
    input: &mut Input<'_>,
    projector: *const DrrProjector,
    scene: &Accepted,
    grid: &Extent,
) -> bool {
    let size = [scene.scene.detector_width, scene.scene.detector_height];
    let (count, present) = view_counts(input);
    let rays = present * size[0] * size[1] * (scene.scene.supersampling as usize).pow(2);
    let per_ray =
        scene.scene.energy_count * scene.scene.material_count + 64 * grid.longest * scene.samples_per_voxel();
    let wanted: [How; 4] = std::array::from_fn(|_| if input.seldom() { How::Null } else { How::of(input) });
    let wanted = if rays.saturating_mul(per_ray) > MOST_WORK { [How::Null; 4] } else { wanted };
    let places =
        Places { wanted, pixels: present * size[0] * size[1], materials: scene.scene.material_count };
    let struct_size = |input: &mut Input<'_>| input.count(size_of::<DrrOutputs>(), 0..200);
    let handle = How::of(input).pass(projector);
    let how = How::of(input);
    match input.byte() % 3 {
        0 => {
            let poses: Vec<_> = (0..present).map(|_| pose(input, grid, size)).collect();
            let poses = how.pass(poses.as_ptr());
            let outputs = float32(struct_size(input));
            let bounds: Vec<_> = (0..present).map(|_| Bounds::of(scene, grid, None)).collect();
            places.twice(scene, &bounds, |places| {
                let outputs = outputs(places);
                // SAFETY: as many poses as are said, or a number that is refused; places for their images.
                unsafe { drr_projector_project_poses(handle, poses, count, &raw const outputs) }
            })
        }
        1 => {
            let views: Vec<_> = (0..present).map(|_| view(input, grid, &scene.scene)).collect();
            let uniforms: Vec<_> = views.iter().map(|view| view.uniforms).collect();
            let uniforms = how.pass(uniforms.as_ptr());
            let outputs = float32(struct_size(input));
            let bounds: Vec<_> = views.iter().map(|view| Bounds::of(scene, grid, Some(view))).collect();
            let made = places.twice(scene, &bounds, |places| {
                let outputs = outputs(places);
                // SAFETY: as above; the tables behind the addresses are there, or the address is misaligned.
                unsafe { drr_projector_project(handle, uniforms, count, &raw const outputs) }
            });
            let own_tables =
                views.iter().any(|view| view.uniforms.spectrumLutAddress | view.uniforms.muLutAddress != 0);
            assert!(!(made && own_tables) || scene.has(DRR_EFFECT_POLYENERGETIC), "tables of no use");
            made
        }
        _ => {
            let algorithm = input.code(3);
            let poses: Vec<_> = (0..present).map(|_| pose(input, grid, size)).collect();
            let poses = how.pass(poses.as_ptr());
            let struct_size = struct_size(input);
            let bounds: Vec<_> = (0..present).map(|_| Bounds::of(scene, grid, None)).collect();
            places.twice(scene, &bounds, |places| {
                let outputs = float64(struct_size, places);
                // SAFETY: as above.
                unsafe { drr_reference_project(handle, algorithm, poses, count, &raw const outputs) }
            })
        }
    }
}

fn float32(struct_size: usize) -> impl Fn([*mut f32; 4]) -> DrrOutputs {
    move |[intensity, line_integral, areal_density, bone_path_mm]| {
        let mut outputs = std::mem::MaybeUninit::uninit();
        // SAFETY: a place for one struct; it is filled on success.
        let defaults: DrrOutputs = unsafe {
            assert!(succeeded(drr_outputs_init(outputs.as_mut_ptr())));
            outputs.assume_init()
        };
        assert_eq!(defaults.struct_size, size_of::<DrrOutputs>());
        DrrOutputs { struct_size, intensity, line_integral, areal_density, bone_path_mm, ..defaults }
    }
}

fn float64(struct_size: usize, places: [*mut f64; 4]) -> DrrReferenceOutputs {
    let [intensity, line_integral, areal_density, bone_path_mm] = places;
    let mut outputs = std::mem::MaybeUninit::uninit();
    // SAFETY: a place for one struct; it is filled on success.
    let defaults: DrrReferenceOutputs = unsafe {
        assert!(succeeded(drr_reference_outputs_init(outputs.as_mut_ptr())));
        outputs.assume_init()
    };
    assert_eq!(defaults.struct_size, size_of::<DrrReferenceOutputs>());
    DrrReferenceOutputs { struct_size, intensity, line_integral, areal_density, bone_path_mm, ..defaults }
}

/// Places for intensity, line integral, areal density and bone path.
struct Places {
    wanted: [How; 4],
    /// Of all views together.
    pixels: usize,
    materials: usize,
}

impl Places {
    /// Calls twice; checks the images, or that nothing was written. Whether the call succeeded.
    fn twice<T: Element>(
        &self,
        scene: &Accepted,
        bounds: &[Bounds],
        call: impl Fn([*mut T; 4]) -> DrrStatus,
    ) -> bool {
        let once = || {
            let signals = self.pixels * scene.layers();
            let counts = [signals, signals, self.pixels * self.materials, self.pixels];
            let mut places: [Place<T>; 4] = std::array::from_fn(|i| Place::new(self.wanted[i], counts[i]));
            let made = succeeded(call(places.each_mut().map(Place::pointer)));
            if !made {
                places.iter().for_each(Place::assert_untouched);
            }
            made.then_some(places)
        };
        let (first, second) = (once(), once());
        assert_eq!(first.is_some(), second.is_some(), "the same call, another status");
        let (Some(first), Some(second)) = (first, second) else { return false };
        for (a, b) in first.iter().zip(&second) {
            assert!(a.written() == b.written(), "the same call, other images");
        }
        assert!(self.wanted.contains(&How::Good) && !self.wanted.contains(&How::Misaligned));
        assert!(self.wanted[3] == How::Null || scene.has(DRR_EFFECT_BONE_PATH));
        let images = first.each_ref().map(Place::written);
        if scene.has_effects() {
            // Noise goes below 0 and scatter above the primary: what is left is that there are numbers.
            let numbers = images.iter().flat_map(|image| image.iter()).all(|&value| !value.into().is_nan());
            assert!(numbers, "NaN");
        } else {
            self.check(bounds, &images);
        }
        true
    }

    fn check<T: Element>(&self, bounds: &[Bounds], images: &[&[T]; 4]) {
        let pixels = self.pixels / bounds.len();
        let of_view = |image: &[T], v: usize, planes: usize| -> Vec<f64> {
            let view = v * planes * pixels..(v + 1) * planes * pixels;
            image.get(view).unwrap_or_default().iter().map(|&value| value.into()).collect()
        };
        for (v, bounds) in bounds.iter().enumerate() {
            for i in of_view(images[0], v, 1) {
                // A denormal I0 is rounded to its own unit.
                let most = bounds.i0 * (1.0 + 1e-6) + 1.5e-45;
                assert!((0.0..=most).contains(&i), "intensity {i:e} of {:e}", bounds.i0);
            }
            for p in of_view(images[1], v, 1) {
                let most = bounds.depth + ROUNDING;
                assert!((-1e-6..=most).contains(&p), "line integral {p:e}, depth at most {:e}", bounds.depth);
            }
            let areal = of_view(images[2], v, self.materials);
            for pixel in 0..areal.len() / self.materials {
                let each = (0..self.materials).map(|m| areal[m * pixels + pixel]);
                assert!(each.clone().all(|a| a >= 0.0), "{:?} g/cm²", each.collect::<Vec<_>>());
                let all: f64 = each.sum();
                assert!(all <= bounds.areal_density, "{all:e} of {:e} g/cm²", bounds.areal_density);
            }
            for bone in of_view(images[3], v, 1) {
                assert!(
                    (0.0..=bounds.bone_path_mm).contains(&bone),
                    "{bone:e} of {:e} mm",
                    bounds.bone_path_mm
                );
            }
        }
    }
}
