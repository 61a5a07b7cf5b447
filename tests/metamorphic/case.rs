//! A random scene: a small volume of several materials, a view of it, and an algorithm.

use std::sync::{Arc, LazyLock};

use drr::engine::{Backend, Images, Layers, SILENT};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::physics::{Calibration, DensitySegment, MassAttenuation, Thresholds};
use drr::volume::{Classification, Volume};
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::{DAffine3, DVec3};
use proptest::prelude::*;

use crate::pose::{aim, index_to_world};
use crate::support::noise;

/// Every algorithm, the march at several steps.
pub(crate) const ANY: &[Algorithm] = &[
    Algorithm::Joseph,
    Algorithm::March { step: 1.0 },
    Algorithm::March { step: 0.5 },
    Algorithm::March { step: 0.37 },
    Algorithm::March { step: 2.7 },
    Algorithm::Siddon,
    Algorithm::Exact,
    Algorithm::DistanceDriven,
];

/// Those that take a pixel for the ray through its middle.
pub(crate) const RAYS: &[Algorithm] = ANY.split_last().expect("there are some").1;

/// Labels 0 … 7.
const MATERIALS: [&str; 8] =
    ["air", "lung", "soft_tissue", "bone_cortical", "adipose", "muscle", "blood", "titanium"];

/// Largest density, g/cm³.
const DENSEST: u64 = 2;

/// Density and label, x fastest. Densities are in 1024ths of a g/cm³: their sums and multiples are exact.
#[derive(Clone)]
pub(crate) struct Voxels(pub Vec<(u16, u8)>);

/// A page of numbers would hide the geometry of a failure; the same seed makes the same voxels.
impl std::fmt::Debug for Voxels {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} voxels", self.0.len())
    }
}

impl Voxels {
    /// The same labels with other densities.
    pub(crate) fn with(&self, density: impl Fn(u16) -> u16) -> Self {
        Self(self.0.iter().map(|&(d, label)| (density(d), label)).collect())
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub dimensions: [usize; 3],
    pub voxels: Voxels,
    /// The label whose path is the bone path.
    pub bone: u8,
    /// Whether voxels are stored as 16-bit codes, or as float32 densities.
    pub coded: bool,
    pub index_to_world: DAffine3,
    pub pose: DetectorPose,
    /// Whether the view is the pose's matrix: half-lines that do not end at the pixel.
    pub matrix: bool,
    pub size: [usize; 2],
    pub algorithm: Algorithm,
}

/// Scenes with one of these algorithms.
pub(crate) fn cases(algorithms: &'static [Algorithm]) -> impl Strategy<Value = Case> {
    sized_cases(algorithms, [40, 12])
}

/// Scenes with detectors of at most `largest` pixels.
pub(crate) fn sized_cases(
    algorithms: &'static [Algorithm],
    largest: [usize; 2],
) -> impl Strategy<Value = Case> {
    let volume = (
        prop::array::uniform3(1..=12_usize),
        any::<u64>(),
        prop::sample::select(vec![1_u8, 2, 4, 8]),
        prop::sample::select(vec![false, false, false, true]),
    );
    let view = (index_to_world(), aim(), any::<bool>(), (1..=largest[0], 1..=largest[1]));
    (volume, view, prop::sample::select(algorithms)).prop_map(|(volume, view, algorithm)| {
        let (dimensions, seed, labels, coded) = volume;
        let (index_to_world, aim, matrix, (width, height)) = view;
        let random = |i: usize, below: u64| (noise(seed.wrapping_add(i as u64)) * below as f64) as u64;
        let voxel = |i: usize| {
            // A quarter of the voxels is vacuum.
            let density = if random(3 * i, 4) == 0 { 0 } else { random(3 * i + 1, 1024 * DENSEST) };
            (density as u16, random(3 * i + 2, u64::from(labels)) as u8)
        };
        Case {
            dimensions,
            voxels: Voxels((0..dimensions.iter().product()).map(voxel).collect()),
            bone: labels - 1,
            coded,
            index_to_world,
            pose: aim.at(index_to_world, dimensions, [width, height]),
            matrix,
            size: [width, height],
            algorithm,
        }
    })
}

/// 1024ths of a g/cm³ from HU −1000 on, times `scale`.
pub(crate) fn calibration(scale: f64) -> Calibration {
    let slope = scale / 1024.0;
    let segment = DensitySegment { first_hu: -1000.0, end_hu: 4000.0, intercept: 1000.0 * slope, slope };
    Calibration::new("1024ths", vec![segment]).expect("valid")
}

impl Case {
    pub(crate) fn grid(&self) -> Grid {
        Grid::new(self.dimensions, self.index_to_world).expect("invertible")
    }

    pub(crate) fn volume(&self, calibration: Calibration) -> Arc<Volume> {
        let thresholds = Thresholds::named(Thresholds::DEFAULT).expect("built in");
        let how = Classification { calibration, thresholds };
        let hu = self.voxels.0.iter().map(|&(d, _)| d as i16 - 1000);
        let labels: Vec<u8> = self.voxels.0.iter().map(|&(_, label)| label).collect();
        let labels = Some(&labels[..]);
        let volume = if self.coded {
            Volume::from_int16(self.grid(), &hu.collect::<Vec<_>>(), labels, &how)
        } else {
            Volume::from_float32(self.grid(), &hu.map(f32::from).collect::<Vec<_>>(), labels, &how)
        };
        Arc::new(volume.expect("valid"))
    }

    pub(crate) fn view(&self) -> ViewRequest {
        if self.matrix {
            View::Projection(Projection::from_pose(&self.pose, self.size).expect("valid")).into()
        } else {
            View::Pose(self.pose).into()
        }
    }

    /// The engines that have the algorithm.
    pub(crate) fn engines(&self) -> &'static [Backend] {
        let both = &[Backend::Reference, Backend::Cpu];
        if self.algorithm == Algorithm::Exact { &both[..1] } else { both }
    }

    pub(crate) fn projector(&self, context: &Context, volume: Arc<Volume>) -> Projector {
        static DEFAULT: LazyLock<Scene> = LazyLock::new(|| {
            let scene = Scene::new([1, 1]).expect("valid");
            let materials = MassAttenuation::named(&MATERIALS, *scene.spectrum.grid()).expect("tabulated");
            Scene { materials, ..scene }
        });
        let scene = Scene {
            detector: self.size,
            method: self.algorithm.into(),
            bone: Some(self.bone),
            ..DEFAULT.clone()
        };
        Projector::new(context, volume, scene).expect("valid")
    }

    /// All layers of `views`.
    pub(crate) fn project_views(&self, engine: Backend, views: &[ViewRequest]) -> Images<f64> {
        self.project_volume(engine, self.volume(calibration(1.0)), views, Layers::ALL)
    }

    pub(crate) fn project_volume(
        &self,
        engine: Backend,
        volume: Arc<Volume>,
        views: &[ViewRequest],
        layers: Layers,
    ) -> Images<f64> {
        static CONTEXTS: LazyLock<[Context; 2]> = LazyLock::new(|| {
            [Backend::Cpu, Backend::Reference].map(|engine| Context::new(engine, 2).expect("threads start"))
        });
        let context = &CONTEXTS[usize::from(engine == Backend::Reference)];
        run(&self.projector(context, volume), views, layers)
    }

    /// All layers of the case's view.
    pub(crate) fn project(&self, engine: Backend) -> Images<f64> {
        self.project_views(engine, &[self.view()])
    }

    /// The scene with voxels read through `to_old`, a map from new to old indices along the axes; where it leaves the
    /// volume, vacuum that is not bone. Every voxel keeps its place in the world.
    pub(crate) fn reindexed(&self, dimensions: [usize; 3], to_old: DAffine3) -> Self {
        let [n0, n1, n2] = self.dimensions;
        let voxel = |i: usize| {
            let [m0, m1, _] = dimensions;
            let new = DVec3::from_array([i % m0, i / m0 % m1, i / (m0 * m1)].map(|x| x as f64));
            let [x, y, z] = to_old.transform_point3(new).to_array().map(|x| x as isize);
            let inside = |x: isize, n: usize| usize::try_from(x).ok().filter(|&x| x < n);
            let old = (inside(z, n2)? * n1 + inside(y, n1)?) * n0 + inside(x, n0)?;
            Some(self.voxels.0[old])
        };
        let vacuum = (0, u8::from(self.bone == 0));
        let voxels = (0..dimensions.iter().product()).map(|i| voxel(i).unwrap_or(vacuum));
        let index_to_world = self.index_to_world * to_old;
        Self { dimensions, voxels: Voxels(voxels.collect()), index_to_world, ..self.clone() }
    }

    /// The scene with volume, source and detector moved by `map`.
    pub(crate) fn moved(&self, map: DAffine3) -> Self {
        let pose = DetectorPose {
            source: map.transform_point3(self.pose.source),
            first_pixel: map.transform_point3(self.pose.first_pixel),
            column_step: map.transform_vector3(self.pose.column_step),
            row_step: map.transform_vector3(self.pose.row_step),
        };
        Self { index_to_world: map * self.index_to_world, pose, ..self.clone() }
    }
}

/// Widened to float64. The reference engine's own images are of that width.
pub(crate) fn run(projector: &Projector, views: &[ViewRequest], layers: Layers) -> Images<f64> {
    match projector.plan().engine {
        Backend::Reference => {
            projector.reference(projector.plan().method.algorithm, views, layers, SILENT).expect("projects")
        }
        _ => projector.project(views, layers, SILENT).expect("projects").map(|&x| f64::from(x)),
    }
}
