//! The volume that is projected, and the parallel beam's geometry.

use anyhow::{Context as _, Result, bail};
use drr::geometry::{AnatomicalDirection, Grid, PatientOrientation};
use drr::parallel::{ParallelGeometry, ViewParameters};
use drr::{Context, MAX_DETECTOR};
use glam::{DMat3, DVec3};

use super::Arguments;
use crate::console::Console;
use crate::object::Attenuation;

/// A detector's part of the volume's height where it has no size of its own: the ends of a CT are cut, and what sees
/// them would be aligned by edges that no patient has.
const INNER: f64 = 0.8;

/// Samples per voxel along the beam: with one, what sums of samples lose moves a view by a fiftieth of a degree.
const PER_VOXEL: u32 = 2;
/// Columns of a detector that has no size of its own.
const COLUMNS: f64 = 256.0;

/// A volume of attenuation, seen by a detector.
pub(super) struct Scene {
    /// What it is, in words.
    pub(super) name: String,
    pub(super) geometry: ParallelGeometry,
    /// 1/mm, x fastest.
    pub(super) volume: Vec<f32>,
    /// Whether the head is at the volume's last slice.
    pub(super) head_last: bool,
    /// The world's directions of the volume's axes.
    axes: DMat3,
}

impl Scene {
    /// Means of the object's voxels, no more than `--voxels` a side.
    pub(super) fn new(arguments: &Arguments, context: &Context, console: Console) -> Result<Self> {
        let load = || arguments.object.load(arguments.voxels, 1, console)?.means(arguments.voxels, 0);
        let Attenuation { grid, values } = context.install(load)?;
        let geometry = with_detector(&grid, arguments)?;
        let head_last = grid.index_to_world().matrix3.z_axis.z >= 0.0;
        let axes = grid.index_to_world().matrix3;
        Ok(Self { name: arguments.object.name(), geometry, volume: values, head_last, axes })
    }

    /// Where the sides of a view lie in the patient when the head is up: it is the object that turns.
    pub(super) fn upright_orientation(&self, parameters: &ViewParameters) -> PatientOrientation {
        let seen = parameters.motion().rotation().transpose();
        let in_patient = |axis: DVec3| {
            let own = seen * axis;
            AnatomicalDirection::of((0..3).map(|n| own[n] * self.axes.col(n).normalize()).sum())
        };
        let stored = PatientOrientation { row: in_patient(DVec3::X), column: in_patient(DVec3::Z) };
        if self.head_last { stored.upside_down() } else { stored }
    }

    /// In words.
    pub(super) fn text(&self) -> String {
        let ([nx, ny, nz], [nu, nv]) = (self.geometry.dimensions, self.geometry.detector);
        let ([vx, vy, vz], [du, dv]) = (self.geometry.spacing.to_array(), self.geometry.pixel);
        format!(
            "{}: {nx}×{ny}×{nz} voxels of {vx:.2}×{vy:.2}×{vz:.2} mm, {nu}×{nv} pixels of {du:.2}×{dv:.2} mm",
            self.name
        )
    }
}

/// A detector as wide as the volume, or as asked for; the volume's centre is the origin.
fn with_detector(grid: &Grid, arguments: &Arguments) -> Result<ParallelGeometry> {
    let (dimensions, spacing) = (grid.dimensions(), grid.spacing());
    let extent: [f64; 3] = std::array::from_fn(|axis| dimensions[axis] as f64 * spacing[axis]);
    let width = extent[0].max(extent[1]);
    let pixel = [arguments.pixel.unwrap_or(width / COLUMNS); 2];
    let width = (width / pixel[0] - 1e-9).ceil().max(1.0);
    let height = (INNER * extent[2] / pixel[1]).floor().max(1.0);
    if let (Some(pixel), None) = (arguments.pixel, arguments.size)
        && width.max(height) > MAX_DETECTOR as f64
    {
        bail!(
            "--pixel is {pixel:e}; valid: mm, of which up to {MAX_DETECTOR} cover the volume's {:.0} mm, or give --size",
            extent.into_iter().fold(0.0, f64::max)
        );
    }
    let detector = arguments.size.unwrap_or([width as usize, height as usize]);
    let geometry = ParallelGeometry {
        step: spacing.y / f64::from(PER_VOXEL),
        steps: PER_VOXEL as usize * dimensions[1],
        ..ParallelGeometry::new(dimensions, spacing, detector, pixel)
    };
    geometry.validate().context("--size, --pixel")?;
    Ok(geometry)
}
