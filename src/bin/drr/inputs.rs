//! What `project`, `plan`, `tradeoff`, `effects` and `bench` take, and the projector that comes of it.

use std::sync::Arc;

use anyhow::Result;
use clap::Args;
use drr::effects::Effects;
use drr::geometry::View;
use drr::volume::Volume;
use drr::{Context, Projector, Scene};

use crate::console::Console;
use crate::ct::{CtArguments, Loaded};
use crate::effect_arguments::{EffectArguments, argument_of};
use crate::method::MethodArguments;
use crate::physics::{Physics, PhysicsArguments};
use crate::views::{ViewArguments, Views};

#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Inputs {
    #[command(flatten)]
    pub(crate) ct: CtArguments,
    #[command(flatten)]
    pub(crate) views: ViewArguments,
    #[command(flatten)]
    physics: PhysicsArguments,
    #[command(flatten)]
    method: MethodArguments,
    #[command(flatten)]
    effects: EffectArguments,
}

/// Arguments that have been checked as far as they can be without the volume.
pub(crate) struct Setup<'a> {
    inputs: &'a Inputs,
    pub(crate) physics: Physics,
    pub(crate) context: Context,
    pub(crate) method: drr::Method,
    pub(crate) effects: Effects,
}

impl Inputs {
    /// Rays per side of a pixel.
    pub(crate) fn supersampling(&self) -> usize {
        self.method.supersample
    }

    /// Whether an effect, or a second detector layer, is asked for.
    pub(crate) fn has_effects(&self) -> bool {
        self.effects.any() || self.physics.layers() > 1
    }

    pub(crate) fn setup(&self) -> Result<Setup<'_>> {
        let (mut physics, method) = (self.physics.physics()?, self.method.method()?);
        let effects = self.effects.effects(&mut physics)?;
        Ok(Setup { inputs: self, physics, context: self.method.context()?, method, effects })
    }
}

impl Setup<'_> {
    /// Reads the volume.
    pub(crate) fn load(&self, console: Console) -> Result<Loaded> {
        self.context.install(|| self.inputs.ct.load(&self.physics.classification, console))
    }

    /// The views of a volume.
    pub(crate) fn views(&self, volume: &Volume) -> Result<Views> {
        self.inputs.views.views(volume.grid())
    }

    /// The scene of some views.
    pub(crate) fn scene(&self, views: &Views) -> Scene {
        Scene {
            detector: views.size,
            spectrum: self.physics.spectrum.clone(),
            materials: self.physics.materials.clone(),
            method: self.method,
            tolerance: self.inputs.method.tolerance(),
            expected_views: views.poses.iter().map(|&pose| View::Pose(pose)).collect(),
            supersampling: self.inputs.method.supersample,
            bone: self.physics.bone,
            detector_layers: self.physics.detector_layers.clone(),
            effects: self.effects.clone(),
        }
    }

    /// A projector for some views.
    pub(crate) fn projector(&self, volume: Arc<Volume>, views: &Views) -> Result<Projector> {
        self.projector_of(volume, self.scene(views))
    }

    /// Another context of the same kind, which knows nothing that this one has made.
    pub(crate) fn fresh_context(&self) -> Result<Context> {
        self.inputs.method.context()
    }

    /// What is projected, in words.
    pub(crate) fn name(&self) -> String {
        self.inputs.ct.name()
    }

    /// A projector of a scene.
    pub(crate) fn projector_of(&self, volume: Arc<Volume>, scene: Scene) -> Result<Projector> {
        Projector::new(&self.context, volume, scene).map_err(|error| {
            let argument = match &error {
                drr::Error::InvalidArgument { argument, .. } if argument.starts_with("scene.tolerance") => {
                    "--tolerance-hu or --preset"
                }
                drr::Error::InvalidArgument { argument, .. } => {
                    argument_of(argument).unwrap_or("--materials")
                }
                drr::Error::Unsupported(_) => "--engine, --algorithm, --sums, --storage",
                _ => "--materials",
            };
            anyhow::Error::new(error).context(argument)
        })
    }
}
