//! Where views are taken from, and what they show.

use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use clap::ValueEnum;
use drr::alignment::PhotonNoise;
use drr::engine::Layers;
use drr::formats::{GeometryFile, write_views};
use drr::geometry::{DetectorPose, Grid, Projection, View};
use drr::parallel::{ParallelGeometry, ViewParameters};
use drr::physics::Spectrum;
use drr::{Algorithm, Context, Projector, Scene, ViewRequest};
use glam::{DMat4, DVec3};

use crate::console::Console;
use crate::object::Object;
use crate::views::check_outside;

/// Pixels around the volume's shadow, so that what moves a little stays on the detector.
const MARGIN: usize = 2;

/// Rays per pixel and side, and the distance of their samples in voxels, that data are simulated with: a pixel sees all
/// of the voxels before it, and what sampling is off by is far below any noise.
const RAYS: usize = 2;
const STEP: f64 = 0.25;

/// How rays run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BeamName {
    /// Along one direction; the object turns about its z axis over 180 degrees
    Parallel,
    /// From a point; source and detector turn about the object's z axis over 360 degrees
    Cone,
}

/// All views.
#[derive(Debug, Clone)]
pub(crate) enum Geometry {
    /// The object's centre is the origin.
    Parallel(ParallelGeometry, Vec<ViewParameters>),
    /// In the object's world.
    Cone { size: [usize; 2], poses: Vec<DetectorPose> },
}

/// Distances of a cone beam, mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Distances {
    /// From the source to the axis of rotation.
    pub(crate) sad: f64,
    /// From the source to the detector.
    pub(crate) sdd: f64,
}

impl Geometry {
    /// Evenly spread views on a detector that sees all of the volume, a pixel about as large as a voxel.
    pub(crate) fn around(grid: &Grid, beam: BeamName, views: usize, distances: Distances) -> Result<Self> {
        match beam {
            BeamName::Parallel => {
                let view =
                    |n| ViewParameters { phi: PI * n as f64 / views as f64, ..ViewParameters::default() };
                Ok(Self::Parallel(parallel(grid), (0..views).map(view).collect()))
            }
            BeamName::Cone => cone(grid, views, distances),
        }
    }

    /// Writes it as the command reads it; the file's name.
    pub(crate) fn write(&self, folder: &Path) -> Result<&'static str> {
        match self {
            Self::Parallel(_, views) => {
                write_views(&folder.join("views.csv"), views)?;
                Ok("views.csv")
            }
            Self::Cone { size: [width, height], poses } => {
                let file = GeometryFile { width: *width, height: *height, views: poses.clone() };
                file.write(&folder.join("geometry.json"))?;
                Ok("geometry.json")
            }
        }
    }

    /// Columns and rows of pixels.
    pub(crate) fn size(&self) -> [usize; 2] {
        match self {
            Self::Parallel(geometry, _) => geometry.detector,
            Self::Cone { size, .. } => *size,
        }
    }

    /// Number of views.
    pub(crate) fn count(&self) -> usize {
        match self {
            Self::Parallel(_, views) => views.len(),
            Self::Cone { poses, .. } => poses.len(),
        }
    }

    /// As views of an object on this grid: a parallel beam is along the grid's own second axis.
    pub(crate) fn views(&self, grid: &Grid) -> Result<Vec<View>> {
        match self {
            Self::Parallel(geometry, views) => {
                let own = geometry.grid()?.index_to_world() * grid.index_to_world().inverse();
                let moved = |view| {
                    let Projection { matrix, source } = geometry.projection(view);
                    View::Projection(Projection { matrix: matrix * DMat4::from(own), source })
                };
                Ok(views.iter().map(moved).collect())
            }
            Self::Cone { poses, .. } => Ok(poses.iter().copied().map(View::Pose).collect()),
        }
    }

    /// In words.
    pub(crate) fn describe(&self) -> String {
        let [width, height] = self.size();
        let beam = match self {
            Self::Parallel(..) => "parallel",
            Self::Cone { .. } => "cone-beam",
        };
        format!("{} {beam} views of {width}×{height} pixels", self.count())
    }
}

/// Volume and detector of a parallel beam along the grid's second axis; its centre is the origin.
pub(crate) fn parallel(grid: &Grid) -> ParallelGeometry {
    let (spacing, dimensions) = (grid.spacing(), grid.dimensions());
    let pixel = [spacing.x.min(spacing.y), spacing.z];
    let size = DVec3::from_array(dimensions.map(|n| n as f64)) * spacing;
    let columns = (size.x.hypot(size.y) / pixel[0]).ceil() as usize + 2 * MARGIN;
    ParallelGeometry::new(dimensions, spacing, [columns, dimensions[2] + 2 * MARGIN], pixel)
}

fn cone(grid: &Grid, views: usize, Distances { sad, sdd }: Distances) -> Result<Geometry> {
    let matrix = grid.index_to_world().matrix3;
    let extent = |axis: DVec3| {
        let n = DVec3::from_array(grid.dimensions().map(|n| n as f64));
        (matrix.transpose() * axis).abs().dot(n)
    };
    let radius = check_outside(grid, sad, sdd)?;
    let pixel = grid.smallest_spacing() * sdd / sad;
    // The shadow of a cylinder about the axis; its upper rim is largest where it is nearest to the source.
    let width = 2.0 * sdd * radius / (sad * sad - radius * radius).sqrt();
    let height = extent(DVec3::Z) * sdd / (sad - radius);
    let size = [width, height].map(|length| (length / pixel).ceil() as usize + 2 * MARGIN);
    let pose =
        |n: usize| DetectorPose::c_arm(grid.centre(), 360.0 * n as f64 / views as f64, sad, sdd, pixel, size);
    Ok(Geometry::Cone { size, poses: (0..views).map(pose).collect() })
}

/// Line integrals of the object, of its own voxels, which are finer than those of a reconstruction, with several rays
/// per pixel and samples per voxel: no algorithm is given what it has made itself.
pub(crate) fn simulate(
    context: &Context,
    object: &Object,
    kev: f64,
    (geometry, grid): (&Geometry, &Grid),
    noise: Option<PhotonNoise>,
    console: Console,
) -> Result<Vec<f32>> {
    let scene = Scene {
        spectrum: Spectrum::monoenergetic(kev)?,
        materials: object.materials.clone(),
        bone: None,
        method: Algorithm::March { step: STEP }.into(),
        supersampling: RAYS,
        ..Scene::new(geometry.size())?
    };
    let projector = Projector::new(context, Arc::clone(&object.volume), scene)?;
    let views = geometry.views(grid)?;
    let requests: Vec<ViewRequest> = views.into_iter().map(Into::into).collect();
    let bar = console.bar("simulating", projector.rays(&requests));
    let progress = |rays: usize| {
        bar.inc(rays as u64);
        ControlFlow::Continue(())
    };
    let layers = Layers { line_integral: true, ..Layers::default() };
    let images = projector.project(&requests, layers, &progress)?;
    bar.finish_and_clear();
    let [width, height] = geometry.size();
    let mut data = images.line_integral;
    if let Some(noise) = noise {
        let views = data.chunks_exact_mut(width * height).enumerate();
        context.install(|| views.for_each(|(view, image)| noise.apply(view, width, image)));
    }
    Ok(data)
}
