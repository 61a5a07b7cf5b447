//! What `project`, `plan`, `tradeoff` and `bench` take, and the projector that comes of it.

use std::sync::Arc;

use anyhow::Result;
use clap::Args;
use drr::geometry::View;
use drr::volume::Volume;
use drr::{Context, Projector, Scene, ViewRequest};

use crate::console::Console;
use crate::ct::{CtArguments, Loaded};
use crate::method::MethodArguments;
use crate::physics::{Physics, PhysicsArguments};
use crate::views::{ViewArguments, Views};

#[derive(Debug, Clone, Default, Args)]
pub(crate) struct Inputs {
    #[command(flatten)]
    pub(crate) ct: CtArguments,
    #[command(flatten)]
    views: ViewArguments,
    #[command(flatten)]
    physics: PhysicsArguments,
    #[command(flatten)]
    method: MethodArguments,
}

/// Arguments that have been checked as far as they can be without the volume.
pub(crate) struct Setup<'a> {
    inputs: &'a Inputs,
    pub(crate) physics: Physics,
    pub(crate) context: Context,
    pub(crate) method: drr::Method,
}

impl Inputs {
    /// Rays per side of a pixel.
    pub(crate) fn supersampling(&self) -> usize {
        self.method.supersample
    }

    pub(crate) fn setup(&self) -> Result<Setup<'_>> {
        let (physics, method) = (self.physics.physics()?, self.method.method()?);
        Ok(Setup { inputs: self, physics, context: self.method.context()?, method })
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
        }
    }

    /// A projector for some views.
    pub(crate) fn projector(&self, volume: Arc<Volume>, views: &Views) -> Result<Projector> {
        self.projector_of(volume, self.scene(views))
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
                drr::Error::Unsupported(_) => "--engine, --algorithm, --sums, --storage",
                _ => "--materials",
            };
            anyhow::Error::new(error).context(argument)
        })
    }
}

impl Views {
    /// What to ask a projector for.
    pub(crate) fn requests(&self) -> Vec<ViewRequest> {
        self.poses.iter().map(|&pose| View::Pose(pose).into()).collect()
    }
}
