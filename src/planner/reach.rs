//! What areal densities rays of a volume reach.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::cpu::Cpu;
use crate::engine::{Backend, Engine as _, Images, Job, Layers, Progress, SILENT, ViewJob};
use crate::error::Result;
use crate::geometry::{DetectorPose, Grid, View};
use crate::method::{Algorithm, Energies};
use crate::physics::Quadrature;
use crate::plan::Plan;
use crate::raycast::Beam;
use crate::scene::Scene;
use crate::volume::{Volume, Voxels};

/// Pixels a side of the views that are cast.
const SIDE: usize = 48;
/// Degrees between them: over half a turn, because the other half sees the same from behind.
const ANGLES: [f64; 6] = [0.0, 30.0, 60.0, 90.0, 120.0, 150.0];
/// The source's distance from the volume's centre, mm, unless the volume is larger.
const SOURCE_MM: f64 = 1000.0;

/// How much matter rays of a volume meet: up to there few energies are to stand for all. Rays beyond are summed over all
/// energies, so that a reach that is too small costs time, one that is too large a few energies more, and neither the
/// bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// The largest areal density of each material, g/cm².
    pub areal_density: Vec<f64>,
    /// The largest line integral.
    pub line_integral: f64,
}

impl Reach {
    /// Of C-arm views from all around, by Joseph's rays on the engine `cpu`; `None` for a volume that it cannot read.
    ///
    /// # Errors
    /// As [`Plan::new`]; `OutOfMemory`.
    pub fn of_c_arms(scene: &Scene, volume: &Arc<Volume>) -> Result<Option<Self>> {
        if matches!(volume.voxels(), Voxels::Texture { .. }) {
            return Ok(None);
        }
        let scene = Scene {
            detector: [SIDE; 2],
            method: Algorithm::Joseph.into(),
            supersampling: 1,
            bone: None,
            ..scene.clone()
        };
        let images = cast(&scene, volume)?;
        let largest = |values: &[f32]| values.iter().copied().map(f64::from).fold(0.0, f64::max);
        let mut areal_density = vec![0.0_f64; images.materials];
        for (plane, values) in images.areal_density.chunks(SIDE * SIDE).enumerate() {
            let areal = &mut areal_density[plane % images.materials];
            *areal = areal.max(largest(values));
        }
        Ok(Some(Self { areal_density, line_integral: largest(&images.line_integral) }))
    }

    /// As much of every material again as a part of what there is: rays between those that were cast.
    #[must_use]
    pub fn stretched(mut self, by: f64) -> Self {
        self.areal_density.iter_mut().for_each(|areal| *areal *= by);
        self
    }

    /// The few energies that a scene asks for: their error is that part of p or of a twentieth of the largest p. `None`
    /// when it asks for all, or there are none.
    ///
    /// # Errors
    /// `InvalidArgument` when the scene is not valid.
    pub fn quadrature(&self, scene: &Scene) -> Result<Option<Quadrature>> {
        let Energies::Few { hu } = scene.method.energies else { return Ok(None) };
        let model = scene.spectral_model()?;
        Ok(Quadrature::new(&model, &self.areal_density, 0.05 * self.line_integral, 1e-3 * hu))
    }
}

fn cast(scene: &Scene, volume: &Arc<Volume>) -> Result<Images<f32>> {
    let plan = Plan::new(scene, volume, Backend::Cpu, None)?;
    let views = ANGLES.iter().map(|&angle| {
        let view = View::Pose(pose(volume.grid(), angle));
        let beam = Beam::new(&view, volume.grid(), scene.detector)?;
        Ok(ViewJob { beam, early_exit: false, spectral: None, lut_addresses: [0, 0] })
    });
    let views = views.collect::<Result<Vec<_>>>()?;
    let layers = Layers { line_integral: true, areal_density: true, ..Layers::default() };
    let job = Job { views: &views, layers, progress: Progress::new(SILENT) };
    Cpu::new(volume.clone(), scene, &plan)?.project(&job)
}

/// A view of the whole volume: its detector covers the shadow of the sphere around it.
fn pose(grid: &Grid, angle: f64) -> DetectorPose {
    let voxels = DVec3::from_array(grid.dimensions().map(|n| n as f64));
    let corners =
        (0..4).map(|n| [1.0, if n & 1 == 0 { 1.0 } else { -1.0 }, if n & 2 == 0 { 1.0 } else { -1.0 }]);
    let diagonals = corners.map(|signs| grid.length_mm(DVec3::from_array(signs) * voxels));
    let radius = 0.5 * diagonals.fold(0.0, f64::max);
    let source = SOURCE_MM.max(2.0 * radius);
    let detector = source + radius;
    let half = detector * radius / (source * source - radius * radius).sqrt();
    DetectorPose::c_arm(grid.centre(), angle, source, detector, 2.0 * half / SIDE as f64, [SIDE; 2])
}
