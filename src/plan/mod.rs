//! How a scene is simulated: the stages it calls for, what each costs and why, and what was left out.

mod effects;
mod measured;
mod signal;
mod stage;
#[cfg(test)]
mod tests;

pub use stage::{Omission, Stage};

use serde::Serialize;

use crate::effects::Effects;
use crate::engine::Backend;
use crate::error::{Error, Result};
use crate::exposure::Focus;
use crate::method::{Accumulation, Algorithm, Energies, Method, Storage};
use crate::physics::{MassAttenuation, Quadrature};
use crate::planner::{Choice, Decision, FocusChoice, LeftOut};
use crate::scene::Scene;
use crate::volume::{Volume, Voxels};

/// A projector's plan: a function of scene, volume and engine and, where the scene states a tolerance, of what was measured
/// and of the context's costs. It prints as text and serialises as JSON.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plan {
    /// Library version that made the plan.
    pub version: &'static str,
    /// Which engine runs it.
    pub engine: Backend,
    /// Width and height, pixels.
    pub detector: [usize; 2],
    /// Voxels along i, j, k.
    pub volume: [usize; 3],
    /// How it is computed.
    pub method: Method,
    /// Rays per pixel side.
    pub supersampling: usize,
    /// The materials that get an accumulator; the others cannot attenuate in this volume.
    pub materials: Vec<PlannedMaterial>,
    /// Energy bins with weight.
    pub energy_bins: usize,
    /// The few energies that are summed instead, for the rays whose areal densities are within its limits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quadrature: Option<Quadrature>,
    /// Why the method is what it is, where the scene states a tolerance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice>,
    /// Pixels that a GPU works on together, columns and rows, where one does. Changes the time and nothing else.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub block: Option<[usize; 2]>,
    /// What is simulated beside attenuation.
    #[serde(skip)]
    pub effects: Effects,
    /// How the focal spot is simulated, where the scene has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<FocusChoice>,
    /// Effects that the scene asks for and that change too little.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<LeftOut>,
    /// The part of the volume's bricks of 8×8×8 voxels that hold nothing; known to the engine `cpu` only, of
    /// volumes that are not small.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub empty: Option<f64>,
    /// What all of it took per view, s, where it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured_seconds: Option<f64>,
    /// What runs, in order.
    pub stages: Vec<Stage>,
    /// What does not run, and why.
    pub omissions: Vec<Omission>,
}

/// What looking for a ray's ends takes, samples (`benches/raycast.rs`, beside `benches/target_case.rs`).
const ENDS: f64 = 40.0;

/// A material with an accumulator.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PlannedMaterial {
    /// Its label in the volume, and its row in the attenuation table.
    pub label: u8,
    /// Its name.
    pub name: String,
}

impl Plan {
    /// Plans `scene` for `volume` on `engine`; `quadrature` is one of the scene's model, which the reference engine does
    /// without.
    ///
    /// # Errors
    /// `InvalidArgument` when the scene is not valid, or the volume carries a label that has no material;
    /// `Unsupported` when the engine does not have the scene's algorithm or cannot read the volume.
    pub fn new(
        scene: &Scene,
        volume: &Volume,
        engine: Backend,
        quadrature: Option<Quadrature>,
    ) -> Result<Self> {
        scene.validate()?;
        engine.check_reads(volume)?;
        let quadrature = quadrature.filter(|_| engine != Backend::Reference && !scene.has_effects());
        Self::check_method(scene.method, volume, engine)?;
        let names = scene.materials.names();
        Self::check_labels(names, volume)?;
        let attenuates = |label: usize| volume.materials()[label].max_density > 0.0;
        let materials: Vec<_> = (0..names.len())
            .filter(|&label| attenuates(label))
            .map(|label| PlannedMaterial { label: label as u8, name: names[label].clone() })
            .collect();
        let labels = materials.iter().fold(0, |labels, material| labels | 1 << material.label);
        let empty =
            if Self::looks_into(engine, volume) { Some(volume.occupancy()?.empty(labels)) } else { None };
        let mut plan = Self {
            empty,
            version: crate::VERSION,
            engine,
            detector: scene.detector,
            volume: volume.grid().dimensions(),
            method: Self::method(scene.method, quadrature.as_ref()),
            supersampling: scene.supersampling,
            energy_bins: scene.spectral_model()?.bins(),
            quadrature,
            choice: None,
            block: Self::block(engine, volume),
            effects: scene.effects.clone(),
            focus: None,
            left_out: Vec::new(),
            measured_seconds: None,
            stages: Vec::new(),
            omissions: Vec::new(),
            materials,
        };
        plan.stages = stage::stages(&plan, scene, volume);
        plan.omissions = stage::omissions(&plan, scene, volume);
        Ok(plan)
    }

    /// The same for one ray per pixel of a detector of another size, without effects.
    #[must_use]
    pub(crate) fn of_rays(&self, detector: [usize; 2]) -> Self {
        let effects = Effects::default();
        Self { detector, supersampling: 1, effects, focus: None, ..self.clone() }
    }

    /// The same with what was decided about the scene's effects.
    #[must_use]
    pub(crate) fn with_effects(self, decision: Decision, scene: &Scene, volume: &Volume) -> Self {
        let Decision { effects, focus, left_out } = decision;
        let mut plan = Self { effects, focus, left_out, ..self };
        plan.stages = stage::stages(&plan, scene, volume);
        plan.omissions = stage::omissions(&plan, scene, volume);
        plan
    }

    /// Whether a plan asks where a volume is empty. To find out of fewer voxels than there are codes costs more than it saves.
    pub(crate) fn looks_into(engine: Backend, volume: &Volume) -> bool {
        engine == Backend::Cpu && volume.grid().voxel_count() >= 1 << 16
    }

    /// Whether to look where each ray first and last meets something pays: it costs as much as some samples, and saves those
    /// before and behind. Rays that are swept together pass over empty bricks in any case.
    pub(crate) fn looks_for_ends(&self) -> bool {
        self.empty.is_some_and(|empty| empty * self.samples_per_ray() as f64 >= ENDS)
    }

    /// As it is computed: without a quadrature over every energy.
    fn method(asked: Method, quadrature: Option<&Quadrature>) -> Method {
        let energies = if quadrature.is_some() { asked.energies } else { Energies::All };
        Method { energies, ..asked }
    }

    /// # Errors
    /// `Unsupported` when the engine does not have the method.
    fn check_method(method: Method, volume: &Volume, engine: Backend) -> Result<()> {
        let lacks = |what: String| Err(Error::Unsupported(what));
        if engine != Backend::Reference && method.algorithm == Algorithm::Exact {
            return lacks("algorithm exact runs on the reference engine only".into());
        }
        if !matches!(engine, Backend::Reference | Backend::Cpu)
            && method.algorithm == Algorithm::DistanceDriven
        {
            return lacks(format!(
                "the engine {} does not have the algorithm distance_driven",
                engine.name()
            ));
        }
        if engine != Backend::Cpu && method.accumulation != Accumulation::Blocked {
            return lacks(format!("the engine {} has blocked sums only", engine.name()));
        }
        if method.storage == Storage::Byte {
            if engine != Backend::Cpu {
                return lacks(format!("the engine {} does not have 8-bit voxels", engine.name()));
            }
            if !matches!(volume.voxels(), Voxels::Coded { .. }) {
                return lacks("8-bit voxels are made of integer HU only".into());
            }
        }
        Ok(())
    }

    /// As measured on an H100 (`benches/README.md`); for Apple's GPUs the specification's.
    fn block(engine: Backend, volume: &Volume) -> Option<[usize; 2]> {
        let labels = volume.materials().iter().filter(|material| material.labelled).count();
        match engine {
            // Threads that run together part where their rays meet other materials: less in a squarer tile.
            Backend::Cuda if labels > 1 => Some([8, 16]),
            Backend::Cuda => Some([16, 8]),
            Backend::Metal => Some([16, 16]),
            Backend::Reference | Backend::Cpu | Backend::Host => None,
        }
    }

    /// # Errors
    /// `InvalidArgument` when a label has no material, or another than it was made for.
    pub(crate) fn check_labels(names: &[String], volume: &Volume) -> Result<()> {
        let labelled = volume.materials().iter().rposition(|m| m.labelled).unwrap_or(0);
        if labelled >= names.len() {
            return Err(Error::invalid(
                "scene.material_count",
                names.len(),
                format!("at least {}: the volume has voxels with label {labelled}", labelled + 1),
            ));
        }
        Self::check_classes(names, volume)
    }

    /// Labels that thresholds made mean certain materials; a scene with other built-in materials is a mistake. Names that
    /// are not built in are the caller's own and cannot be compared.
    fn check_classes(names: &[String], volume: &Volume) -> Result<()> {
        let Some(classes) = volume.classes() else { return Ok(()) };
        let known = MassAttenuation::material_names();
        for (label, (name, class)) in names.iter().zip(classes).enumerate() {
            if volume.materials()[label].labelled && name != class && known.contains(&name.as_str()) {
                let valid =
                    format!("{class}, as the volume's thresholds classified its voxels with label {label}");
                return Err(Error::invalid(format!("scene.materials[{label}]"), name, valid));
            }
        }
        Ok(())
    }

    /// Rays per view.
    pub fn rays_per_view(&self) -> usize {
        self.detector[0] * self.detector[1] * self.supersampling * self.supersampling
    }

    /// Points of the focal spot that rays are cast from.
    pub(crate) fn focal_points(&self) -> usize {
        let spread = self.focus.as_ref().filter(|choice| choice.focus == Focus::Points);
        spread.map_or(1, |choice| choice.points[0] * choice.points[1])
    }

    /// Most samples of the volume that one ray can take.
    pub fn samples_per_ray(&self) -> usize {
        let slices = self.volume.iter().copied().max().unwrap_or(0) as f64;
        match self.method.algorithm {
            // A footprint is one, however many voxels it covers.
            Algorithm::Joseph | Algorithm::DistanceDriven => slices as usize,
            Algorithm::March { step } => (slices / step).ceil() as usize,
            // A slab of the driving axis holds at most three voxels of a ray.
            Algorithm::Siddon => 3 * slices as usize,
            // Each crossing of a grid plane starts a cell; two quadrature nodes per cell.
            Algorithm::Exact => 2 * (self.volume.iter().sum::<usize>() + 3),
        }
    }

    /// The plan as pretty JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}"))
    }
}

impl std::fmt::Display for Plan {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [width, height] = self.detector;
        let [n0, n1, n2] = self.volume;
        let engine = match self.engine {
            Backend::Cpu => "cpu engine (float32)",
            Backend::Reference => "reference engine (float64)",
            Backend::Host => "host engine (float32, the GPU kernels' text as host code)",
            Backend::Cuda => "cuda engine (float32 on an NVIDIA GPU)",
            Backend::Metal => "metal engine (float32 on an Apple GPU)",
        };
        writeln!(f, "{width}×{height} pixels from {n0}×{n1}×{n2} voxels on the {engine}")?;
        if let Some(choice) = &self.choice {
            writeln!(f, "{choice}")?;
        }
        for stage in &self.stages {
            let when = if stage.on_request { "may" } else { "run" };
            writeln!(f, "  {when}   {:<14} {}", stage.name, stage.what)?;
            writeln!(f, "        {:<14} because {}", "", stage.reason)?;
            writeln!(
                f,
                "        {:<14} cost per view: {}{}; error: {}",
                "",
                stage.cost,
                stage.time(),
                stage.error
            )?;
        }
        if let Some(seconds) = self.measured_seconds {
            writeln!(f, "  took  {:<14} {seconds:.3} s per view, measured", "in all")?;
        }
        for omission in &self.omissions {
            writeln!(f, "  skip  {:<14} {}", omission.name, omission.reason)?;
        }
        Ok(())
    }
}
