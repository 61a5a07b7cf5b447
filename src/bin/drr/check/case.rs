//! One hard case: what is projected, and what must come of it.

use std::sync::Arc;

use drr::engine::Layers;
use drr::geometry::{DetectorPose, Projection, View};
use drr::shared::ProjectionUniforms;
use drr::volume::Volume;
use drr::{Context, Scene, ViewRequest};
use glam::DVec3;

/// A hard case.
pub(crate) struct Case {
    /// The family it belongs to, a number of `families::TITLES`.
    pub(crate) family: usize,
    pub(crate) name: String,
    pub(crate) demand: Demand,
}

impl Case {
    fn new(family: usize, name: impl Into<String>, demand: Demand) -> Self {
        Self { family, name: name.into(), demand }
    }

    /// See [`Demand::Exact`].
    pub(crate) fn exact(family: usize, name: impl Into<String>, set: Set) -> Self {
        Self::new(family, name, Demand::Exact(set))
    }

    /// See [`Demand::NearFace`].
    pub(crate) fn near_face(family: usize, name: impl Into<String>, set: Set) -> Self {
        Self::new(family, name, Demand::NearFace(set))
    }

    /// See [`Demand::Vacuum`].
    pub(crate) fn vacuum(family: usize, name: impl Into<String>, set: Set) -> Self {
        Self::new(family, name, Demand::Vacuum(set))
    }

    /// See [`Demand::Same`].
    pub(crate) fn same(family: usize, name: impl Into<String>, sets: [Set; 2]) -> Self {
        Self::new(family, name, Demand::Same(Box::new(sets)))
    }

    /// See [`Demand::Refused`].
    pub(crate) fn refused<T>(
        family: usize,
        name: impl Into<String>,
        argument: &'static str,
        attempt: impl Fn(&Context) -> drr::Result<T> + Send + Sync + 'static,
    ) -> Self {
        let attempt = Box::new(move |context: &Context| attempt(context).map(drop));
        Self::new(family, format!("refused: {}", name.into()), Demand::Refused(argument, attempt))
    }
}

/// What must come of a case, on every engine and with every algorithm.
pub(crate) enum Demand {
    /// The exact answer, to rounding.
    Exact(Set),
    /// As `Exact`; but rounding decides on which side of a face a ray or its end lies: either side is right.
    NearFace(Set),
    /// Nothing in the way: exactly I0, and exactly 0 everywhere else.
    Vacuum(Set),
    /// The same bytes from both.
    Same(Box<[Set; 2]>),
    /// An error that names this argument.
    Refused(&'static str, Refusal),
}

/// Does what must be refused.
pub(crate) type Refusal = Box<dyn Fn(&Context) -> drr::Result<()> + Send + Sync>;

/// A volume, a scene and views of it.
#[derive(Clone)]
pub(crate) struct Set {
    pub(crate) volume: Arc<Volume>,
    pub(crate) scene: Scene,
    pub(crate) views: Vec<ViewRequest>,
    pub(crate) layers: Layers,
    /// The march's step, voxels.
    pub(crate) step: f64,
}

impl Set {
    /// One view through the volume, with the specification's scene.
    pub(crate) fn new(volume: Arc<Volume>, size: [usize; 2], view: View) -> Self {
        let scene = Scene::new(size).expect("the built-in scene is valid");
        Self { volume, scene, views: vec![view.into()], layers: Layers::ALL, step: 0.5 }
    }

    /// A pose both as it is and as the uniforms made from it, in float32: segments, and half-lines.
    pub(crate) fn posed(volume: Arc<Volume>, size: [usize; 2], pose: DetectorPose) -> Self {
        let mut set = Self::new(volume, size, View::Pose(pose));
        let projection = Projection::from_pose(&pose, size).expect("a valid pose");
        let uniforms = ProjectionUniforms::from(&projection);
        set.views.push(View::Projection(Projection::from(&uniforms)).into());
        set
    }

    /// The ray from `from` to `to`, world mm.
    pub(crate) fn ray(volume: Arc<Volume>, from: DVec3, to: DVec3) -> Self {
        Self::posed(volume, [1, 1], segment(from, to))
    }

    /// Without the uniforms, whose rounding moves the ray.
    pub(crate) fn pose_only(mut self) -> Self {
        self.views.truncate(1);
        self
    }

    pub(crate) fn with_scene(mut self, change: impl FnOnce(&mut Scene)) -> Self {
        change(&mut self.scene);
        self
    }
}

/// A detector of one pixel.
pub(crate) fn segment(from: DVec3, to: DVec3) -> DetectorPose {
    let (column_step, row_step) = (to - from).normalize().any_orthonormal_pair();
    DetectorPose { source: from, first_pixel: to, column_step, row_step }
}
