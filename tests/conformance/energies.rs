//! Few energies: within their bound where it holds, and byte for byte the sum over all where it does not.

use std::sync::Arc;

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::Grid;
use drr::physics::Quadrature;
use drr::planner::Reach;
use drr::volume::Volume;
use drr::{Algorithm, Context, Energies, Method, Projector, Scene, ViewRequest};

use crate::Test;
use crate::support::{awkward_grid, poses, projector, requests, volume};
use crate::twin::{kinds, worse};
use crate::views::of_several_tubes;

pub(super) const TESTS: [Test; 5] = [
    ("few_energies_keep_their_bound", few_energies_keep_their_bound),
    ("few_energies_of_the_planner_keep_their_bound", few_energies_of_the_planner_keep_their_bound),
    ("beyond_the_limits_all_energies_are_summed", beyond_the_limits_all_energies_are_summed),
    ("few_energies_leave_an_empty_ray_alone", few_energies_leave_an_empty_ray_alone),
    ("few_energies_leave_a_view_s_own_tables_alone", few_energies_leave_a_view_s_own_tables_alone),
];

const SIZE: [usize; 2] = [40, 28];

/// What the scenes ask for, HU: far above the rounding of float32.
const HU: f64 = 1.0;

/// Of a line integral p, relative and absolute.
const ROUNDING: [f64; 2] = [2e-6, 1e-6];

fn scene(algorithm: Algorithm, energies: Energies) -> Scene {
    Scene { method: Method { energies, ..algorithm.into() }, ..Scene::new(SIZE).expect("valid") }
}

/// A volume, views of it from every side, and what their rays meet.
struct Case {
    backend: Backend,
    algorithm: Algorithm,
    grid: Grid,
    volume: Arc<Volume>,
    views: Vec<ViewRequest>,
    /// The engine, summing over all energies.
    all: Projector,
    truth: Images<f64>,
}

impl Case {
    fn of(backend: Backend, algorithm: Algorithm) -> Self {
        let grid = awkward_grid([50, 41, 43]);
        let volume = volume(grid);
        let views = requests(poses(&grid, SIZE).into_iter().map(|(_, pose)| pose));
        let all = projector(backend, &volume, scene(algorithm, Energies::All));
        let truth = all.reference(algorithm, &views, Layers::ALL, SILENT).expect("projects");
        Self { backend, algorithm, grid, volume, views, all, truth }
    }

    /// The engine with few energies, for that part of the matter that its rays meet.
    fn few(&self, part: f64) -> Projector {
        let mut areal_density = vec![0.0_f64; self.truth.materials];
        for (plane, values) in self.truth.areal_density.chunks(SIZE[0] * SIZE[1]).enumerate() {
            let most = &mut areal_density[plane % self.truth.materials];
            *most = values.iter().map(|areal| part * areal).fold(*most, f64::max);
        }
        let line_integral = self.truth.line_integral.iter().copied().fold(0.0, f64::max);
        let reach = Reach { areal_density, line_integral };
        let context = Context::new(self.backend, 2).expect("threads start");
        let scene = scene(self.algorithm, Energies::Few { hu: HU });
        Projector::with_reach(&context, self.volume.clone(), scene, &reach).expect("valid")
    }

    /// The areal densities of a ray, as the engine returned them.
    fn areal_density(images: &Images<f32>, ray: usize) -> Vec<f64> {
        let pixels = SIZE[0] * SIZE[1];
        let place = |m| (ray / pixels * images.materials + m) * pixels + ray % pixels;
        (0..images.materials).map(|m| f64::from(images.areal_density[place(m)])).collect()
    }

    /// Holds every ray to the bound; the largest error that is not the rounding of float32's.
    fn keeps_the_bound(&self, few: &Projector) -> f64 {
        let quadrature = quadrature(few);
        let images = few.project(&self.views, Layers::ALL, SILENT).expect("projects");
        let i0 = few.scene().spectrum.total();
        let mut largest = 0.0;
        for (ray, &truth) in self.truth.line_integral.iter().enumerate() {
            let bound = quadrature.bound() * truth.max(quadrature.floor());
            let rounding = ROUNDING[0] * truth + ROUNDING[1];
            let p = f64::from(images.line_integral[ray]);
            let of_intensity = -(f64::from(images.intensity[ray]) / i0).ln();
            let error = worse((p - truth).abs(), (of_intensity - truth).abs());
            assert!(error <= bound + rounding, "{:?}: ray {ray}: {error:e} for {bound:e}", self.algorithm);
            largest = worse(largest, error - rounding);
        }
        largest
    }
}

fn quadrature(projector: &Projector) -> &Quadrature {
    let quadrature = projector.plan().quadrature.as_ref().expect("few energies are enough");
    assert!(quadrature.bound() <= 1e-3 * HU);
    assert!(2 * quadrature.nodes().len() < projector.plan().energy_bins, "{quadrature:?}");
    quadrature
}

/// Intensity and line integral of a ray, bit for bit.
fn bits(images: &Images<f32>, ray: usize) -> [u32; 2] {
    [images.intensity[ray].to_bits(), images.line_integral[ray].to_bits()]
}

fn few_energies_keep_their_bound(backend: Backend) {
    for &algorithm in kinds(backend) {
        let case = Case::of(backend, algorithm);
        let largest = case.keeps_the_bound(&case.few(1.01));
        assert!(largest > 1e-5, "{algorithm:?}: {largest:e}: all energies are summed");
    }
}

/// With limits that some of the rays lie beyond.
fn few_energies_of_the_planner_keep_their_bound(backend: Backend) {
    let case = Case::of(backend, Algorithm::Joseph);
    let few = projector(backend, &case.volume, scene(case.algorithm, Energies::Few { hu: HU }));
    let largest = case.keeps_the_bound(&few);
    assert!(largest > 1e-5, "{largest:e}: all energies are summed");
    let images = few.project(&case.views, Layers::ALL, SILENT).expect("projects");
    let within = (0..images.intensity.len())
        .filter(|&ray| quadrature(&few).holds(&Case::areal_density(&images, ray)))
        .count();
    assert!(within > images.intensity.len() / 2, "{within} rays within the limits");
    assert!(few.plan().to_string().contains(" bins ("), "{}", few.plan());
}

fn beyond_the_limits_all_energies_are_summed(backend: Backend) {
    for &algorithm in kinds(backend) {
        let case = Case::of(backend, algorithm);
        let few = case.few(0.5);
        case.keeps_the_bound(&few);
        let [all, some] = [&case.all, &few]
            .map(|projector| projector.project(&case.views, Layers::ALL, SILENT).expect("projects"));
        assert!(all.areal_density == some.areal_density && all.bone_path == some.bone_path);
        let (mut beyond, mut changed) = (0, 0);
        for ray in 0..all.intensity.len() {
            let same = bits(&all, ray) == bits(&some, ray);
            if quadrature(&few).holds(&Case::areal_density(&some, ray)) {
                changed += usize::from(!same);
            } else {
                assert!(same, "{algorithm:?}: ray {ray} lies beyond and differs");
                beyond += 1;
            }
        }
        assert!(beyond > 50 && changed > 50, "{algorithm:?}: {beyond} beyond, {changed} changed");
    }
}

fn few_energies_leave_an_empty_ray_alone(backend: Backend) {
    let case = Case::of(backend, Algorithm::Joseph);
    let few = case.few(1.01);
    let images = few.project(&case.views, Layers::ALL, SILENT).expect("projects");
    let i0 = few.scene().spectrum.total() as f32;
    let empty: Vec<usize> = (0..images.intensity.len())
        .filter(|&ray| Case::areal_density(&images, ray).iter().all(|&areal| areal == 0.0))
        .collect();
    assert!(empty.len() > 100, "{} empty rays", empty.len());
    for ray in empty {
        assert_eq!(bits(&images, ray), [i0.to_bits(), 0], "ray {ray}");
    }
}

fn few_energies_leave_a_view_s_own_tables_alone(backend: Backend) {
    for &algorithm in kinds(backend) {
        let case = Case::of(backend, algorithm);
        let few = case.few(1.01);
        let views = of_several_tubes(&case.grid, few.scene(), SIZE);
        let [all, some] = [&case.all, &few]
            .map(|projector| projector.project(&views, Layers::ALL, SILENT).expect("projects"));
        for (v, view) in views.iter().enumerate() {
            let alone = few.project(std::slice::from_ref(view), Layers::ALL, SILENT).expect("projects");
            let [of_all, of_some] = [&all, &some]
                .map(|images| [images.view(&images.intensity, v), images.view(&images.line_integral, v)]);
            assert!(of_some == [&alone.intensity[..], &alone.line_integral], "{algorithm:?}: view {v} alone");
            let own = view.spectral.is_some();
            assert_eq!(of_all == of_some, own, "{algorithm:?}: view {v}");
        }
    }
}
