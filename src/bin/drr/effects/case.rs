//! One scene that is timed.

use std::time::Instant;

use anyhow::Result;
use drr::engine::{Images, Layers, SILENT};
use drr::{Exposure, Projector, Scene};

use super::Study;

/// What is timed.
const LAYERS: Layers =
    Layers { intensity: true, line_integral: true, areal_density: false, bone_path: false };

/// What a case is beside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Beside {
    /// The plain projection itself.
    Nothing,
    /// The plain projection, which it adds to.
    Plain,
    /// The case before it, which is no effect and is not shown.
    Previous,
    /// Nothing: it takes the place of a projection.
    Instead,
}

/// A scene, and how it is timed.
pub(super) struct Case {
    pub(super) name: &'static str,
    /// Its parameters.
    pub(super) what: String,
    pub(super) beside: Beside,
    pub(super) run: Run,
}

/// How images are made.
pub(super) enum Run {
    /// By a projection.
    Project(Box<Projector>),
    /// By a projection that finds nothing made before it.
    First(Box<Scene>),
    /// Of rays that have been cast.
    Develop(Box<Exposure<f32>>, Box<Scene>),
}

impl Run {
    /// Images of all views, and the seconds that they took.
    pub(super) fn timed(&self, study: &Study<'_>) -> Result<(Images<f32>, f64)> {
        let requests = study.requests();
        let start;
        let images = match self {
            Self::Project(projector) => {
                start = Instant::now();
                projector.project(&requests, LAYERS, SILENT)?
            }
            Self::First(scene) => {
                let context = study.setup.fresh_context()?;
                let projector = Projector::new(&context, study.volume.clone(), (**scene).clone())?;
                start = Instant::now();
                projector.project(&requests, LAYERS, SILENT)?
            }
            Self::Develop(exposure, scene) => {
                start = Instant::now();
                exposure.develop(scene, LAYERS)?.0
            }
        };
        Ok((images, start.elapsed().as_secs_f64()))
    }
}
