//! What areal densities rays of a volume reach.

use std::sync::Arc;

use crate::engine::cpu::Cpu;
use crate::engine::{Backend, Engine as _, Images, Job, Layers, Progress, SILENT, ViewJob};
use crate::error::{Error, Result};
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
/// How much more matter rays may meet than those that were cast.
const BETWEEN_RAYS: f64 = 1.25;

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
            *areal = areal.max(BETWEEN_RAYS * largest(values));
        }
        Ok(Some(Self { areal_density, line_integral: largest(&images.line_integral) }))
    }

    /// The few energies that a scene asks for: their error is that part of p or of a twentieth of the largest p. `None`
    /// when it asks for all, or there are none.
    ///
    /// # Errors
    /// `InvalidArgument` when the scene is not valid or has not as many materials.
    pub fn quadrature(&self, scene: &Scene) -> Result<Option<Quadrature>> {
        scene.validate()?;
        let (given, materials) = (self.areal_density.len(), scene.materials.names().len());
        if given != materials {
            return Err(Error::invalid(
                "reach.areal_density",
                given,
                format!("{materials}, one per material"),
            ));
        }
        let Energies::Few { hu } = scene.method.energies else { return Ok(None) };
        let model = scene.spectral_model()?;
        Ok(Quadrature::new(&model, &self.areal_density, 0.05 * self.line_integral, 1e-3 * hu))
    }
}

fn cast(scene: &Scene, volume: &Arc<Volume>) -> Result<Images<f32>> {
    let plan = Plan::new(scene, volume, Backend::Cpu, None)?;
    // Where a grid is so odd that a view of it cannot be set up, the others have to do.
    let views = ANGLES.iter().filter_map(|&angle| {
        let view = View::Pose(pose(volume.grid(), angle));
        let beam = Beam::new(&view, volume.grid(), scene.detector).ok()?;
        Some(ViewJob { beam, early_exit: false, spectral: None, lut_addresses: [0, 0] })
    });
    let views: Vec<_> = views.collect();
    let layers = Layers { line_integral: true, areal_density: true, ..Layers::default() };
    let job = Job { views: &views, layers, progress: Progress::new(SILENT) };
    Cpu::new(volume.clone(), scene, &plan)?.project(&job)
}

/// A view of the whole volume: its detector covers the shadow of the sphere around it.
fn pose(grid: &Grid, angle: f64) -> DetectorPose {
    let [n0, n1, n2] = grid.dimensions().map(|n| n as f64);
    let diagonals = [[n0, n1, n2], [n0, n1, -n2], [n0, -n1, n2], [-n0, n1, n2]];
    let radius =
        diagonals.map(|diagonal| 0.5 * grid.length_mm(diagonal.into())).into_iter().fold(0.0, f64::max);
    let source = SOURCE_MM.max(2.0 * radius);
    let detector = source + radius;
    let half = detector * radius / (source * source - radius * radius).sqrt();
    DetectorPose::c_arm(grid.centre(), angle, source, detector, 2.0 * half / SIDE as f64, [SIDE; 2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Grid;
    use crate::physics::{Calibration, Thresholds};
    use crate::volume::Classification;
    use glam::DVec3;

    /// Water, 60 mm × 100 mm × 40 mm, far from the origin of a world that it is turned in.
    fn slab() -> Arc<Volume> {
        let columns = [DVec3::new(0.0, 2.0, 0.0), DVec3::new(-2.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 2.0)];
        let matrix3 = glam::DMat3::from_cols(columns[0], columns[1], columns[2]);
        let translation = DVec3::new(300.0, -700.0, 1000.0);
        let grid = Grid::new([30, 50, 20], glam::DAffine3 { matrix3, translation }).expect("valid");
        let how = Classification::named(Calibration::DEFAULT, Thresholds::DEFAULT).expect("built in");
        Arc::new(Volume::from_int16(grid, &vec![0; grid.voxel_count()], None, &how).expect("valid"))
    }

    #[test]
    fn views_from_all_around_meet_all_that_there_is() {
        let (volume, scene) = (slab(), Scene::new([4, 4]).expect("valid"));
        let reach = Reach::of_c_arms(&scene, &volume).expect("valid").expect("not in a texture");
        let density = volume.materials()[2].max_density;
        let across = 10.0 * density * BETWEEN_RAYS;
        assert_eq!([0, 1, 3].map(|m| reach.areal_density[m]), [0.0; 3], "soft tissue alone");
        // The slab's longest side, and at most the diagonal of its cross-section and a little of its height.
        let longest = across * (1.0_f64 + 0.36 + 0.02).sqrt();
        let soft = reach.areal_density[2];
        assert!(soft > 0.99 * across && soft < longest, "{soft} for {across} … {longest}");
        let exact =
            scene.spectral_model().expect("valid").line_integral(&[0.0, 0.0, soft / BETWEEN_RAYS, 0.0]);
        assert!((reach.line_integral - exact).abs() < 1e-4, "{} for {exact}", reach.line_integral);
    }

    #[test]
    fn few_energies_are_as_good_as_the_scene_asks() {
        let mut scene = Scene::new([4, 4]).expect("valid");
        let reach = Reach::of_c_arms(&scene, &slab()).expect("valid").expect("not in a texture");
        assert_eq!(reach.quadrature(&scene).expect("valid"), None, "all energies are asked for");
        let mut counts = [0.1, 1.0, 10.0].map(|hu| {
            scene.method.energies = Energies::Few { hu };
            let quadrature = reach.quadrature(&scene).expect("valid").expect("there are few");
            assert!(quadrature.bound() <= 1e-3 * hu, "{} for {hu} HU", quadrature.bound());
            assert_eq!(quadrature.floor(), 0.05 * reach.line_integral);
            quadrature.nodes().len()
        });
        counts.reverse();
        assert!(counts.is_sorted() && counts[0] < counts[2], "{counts:?}");
        let short = Reach { areal_density: vec![1.0], ..reach };
        assert!(short.quadrature(&scene).is_err(), "one material of four");
    }
}
