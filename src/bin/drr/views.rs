//! The views: where source and detector are.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::ViewRequest;
use drr::formats::{CArm, GeometryFile, PoseTable};
use drr::geometry::{DetectorPose, Grid, PatientOrientation, View};
use glam::DVec3;

use crate::value;

/// Width of the default detector, mm: 720 pixels of 0.9 mm, 432 mm in the plane through the volume's centre.
const DEFAULT_WIDTH_MM: f64 = 648.0;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Views")]
pub(crate) struct ViewArguments {
    /// One view per angle, degrees: the C-arm turns about the z axis through the volume's centre
    ///
    /// At 0 the source is in front of the patient (-y) and the detector behind; columns run along +x, rows along +z.
    #[arg(long, value_name = "A,B,...", value_delimiter = ',', default_value = "-6,6")]
    #[arg(value_parser = value::finite, allow_hyphen_values = true)]
    angles: Vec<f64>,
    /// Distance from the source to the axis of rotation, mm
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true, default_value = "1000")]
    sad: f64,
    /// Distance from the source to the detector, mm; rays end there
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true, default_value = "1500")]
    sdd: f64,
    /// Distance of pixel centres, mm [default: 648 / columns, which is 0.9 for 720]
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true)]
    pixel: Option<f64>,
    /// Columns and rows of pixels
    #[arg(long, value_name = "WxH", value_parser = value::size, allow_hyphen_values = true, default_value = "720x720")]
    size: [usize; 2],
    /// Poses instead of angles, as JSON, mm in the world:
    /// {"width":W,"height":H,"views":[{"source":[x,y,z],"first_pixel":[..],"column_step":[..],"row_step":[..]}]}
    ///
    /// Pixel (i,j) has its centre at first_pixel + i*column_step + j*row_step.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["angles", "sad", "sdd", "pixel", "size"])]
    geometry: Option<PathBuf>,
    /// One view per row of a table, CSV with a header, instead of angles: angle_degrees, or the twelve coordinates of a pose
    ///
    /// Beside angle_degrees there may be sad_mm, sdd_mm and pixel_mm, for which --sad, --sdd and --pixel stand otherwise,
    /// and offset_x_mm, offset_y_mm, offset_z_mm from the volume's centre to the C-arm's. The twelve are source_x_mm,
    /// source_y_mm, source_z_mm, and so first_pixel, column_step and row_step, as in --geometry. Either may have a column
    /// name: what the view's files are called. Columns may stand in any order; lines that start with # are comments. All
    /// views have --size.
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["angles", "geometry"])]
    views: Option<PathBuf>,
    /// The first view's number, from which views and rows are counted; it is in the names of files, and decides the noise
    #[arg(long, value_name = "N", default_value = "0", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32))]
    first_view: u32,
}

impl Default for ViewArguments {
    fn default() -> Self {
        Self {
            angles: vec![-6.0, 6.0],
            sad: 1000.0,
            sdd: 1500.0,
            pixel: None,
            size: [720, 720],
            geometry: None,
            views: None,
            first_view: 0,
        }
    }
}

/// The radius, mm, of the cylinder about the z axis through the volume's centre in which the volume is.
///
/// # Errors
/// For a source within it, and a detector that is not behind the axis.
pub(crate) fn check_outside(grid: &Grid, sad: f64, sdd: f64) -> Result<f64> {
    let matrix = grid.index_to_world().matrix3;
    let n = DVec3::from_array(grid.dimensions().map(|n| n as f64));
    let extent = |axis: DVec3| (matrix.transpose() * axis).abs().dot(n);
    let radius = 0.5 * extent(DVec3::X).hypot(extent(DVec3::Y));
    if !(sad > radius && sdd > sad) {
        bail!(
            "--sad is {sad} and --sdd {sdd}; valid: {radius:.0} < sad < sdd, mm, the source outside of the volume"
        );
    }
    Ok(radius)
}

/// One pose per view, with a common detector.
#[derive(Debug, Clone)]
pub(crate) struct Views {
    /// Columns and rows of pixels.
    pub(crate) size: [usize; 2],
    pub(crate) poses: Vec<DetectorPose>,
    /// The number of the first one.
    first: usize,
    named: Named,
    source_axis_mm: Option<f64>,
}

/// What views are called.
#[derive(Debug, Clone)]
enum Named {
    /// By their numbers.
    Plainly,
    /// By their numbers, so that names stand in the order of a table's rows.
    InOrder,
    /// As a table says.
    As(Vec<String>),
}

/// One view, as its files tell of it.
pub(crate) struct NamedView {
    pub(crate) name: String,
    /// What its noise follows from.
    pub(crate) number: usize,
    pub(crate) pose: DetectorPose,
    /// Distance from the source to the axis that it turns about, mm, where one was stated for all views.
    pub(crate) source_axis_mm: Option<f64>,
}

impl ViewArguments {
    /// The default ones, but for angles, degrees, and detector.
    pub(crate) fn of(angles: Vec<f64>, size: [usize; 2]) -> Self {
        Self { angles, size, ..Self::default() }
    }

    /// Refuses a source within the volume's circle of rotation; poses of a file are taken as they are.
    pub(crate) fn check_outside(&self, grid: &Grid) -> Result<()> {
        if self.geometry.is_none() && self.views.is_none() {
            check_outside(grid, self.sad, self.sdd)?;
        }
        Ok(())
    }

    /// Whether they are the rows of a table.
    pub(crate) fn is_table(&self) -> bool {
        self.views.is_some()
    }

    /// The views of a volume on `grid`.
    pub(crate) fn views(&self, grid: &Grid) -> Result<Views> {
        let first = self.first_view as usize;
        if let Some(path) = &self.geometry {
            let file = GeometryFile::read(path).context("--geometry")?;
            let size = [file.width, file.height];
            return Ok(Views { size, poses: file.views, first, named: Named::Plainly, source_axis_mm: None });
        }
        let pixel = self.pixel.unwrap_or(DEFAULT_WIDTH_MM / self.size[0].max(1) as f64);
        if let Some(path) = &self.views {
            let (centre, size) = (grid.centre(), self.size);
            let c_arm = CArm { centre, size, sad_mm: self.sad, sdd_mm: self.sdd, pixel_mm: pixel };
            let PoseTable { poses, names } = PoseTable::read(path, &c_arm).context("--views")?;
            let named = names.map_or(Named::InOrder, Named::As);
            return Ok(Views { size, poses, first, named, source_axis_mm: None });
        }
        let pose =
            |&angle: &f64| DetectorPose::c_arm(grid.centre(), angle, self.sad, self.sdd, pixel, self.size);
        let poses: Vec<_> = self.angles.iter().map(pose).collect();
        poses.iter().try_for_each(DetectorPose::validate).context("--angles, --sad, --sdd, --pixel")?;
        Ok(Views { size: self.size, poses, first, named: Named::Plainly, source_axis_mm: Some(self.sad) })
    }
}

impl Views {
    /// What to ask a projector for.
    pub(crate) fn requests(&self) -> Vec<ViewRequest> {
        (0..self.poses.len()).map(|view| self.request(view)).collect()
    }

    /// The same for one of them.
    pub(crate) fn request(&self, view: usize) -> ViewRequest {
        ViewRequest { number: Some(self.first + view), ..View::Pose(self.poses[view]).into() }
    }

    pub(crate) fn named(&self, view: usize) -> NamedView {
        let number = self.first + view;
        let name = match &self.named {
            Named::Plainly => format!("view{number}"),
            Named::InOrder => format!("view{number:06}"),
            Named::As(names) => names[view].clone(),
        };
        NamedView { name, number, pose: self.poses[view], source_axis_mm: self.source_axis_mm }
    }

    /// Whether the head is at the last row of a view.
    pub(crate) fn head_last(&self, view: usize) -> bool {
        self.poses[view].row_step.z > 0.0
    }

    /// Where the sides of a view lie in the patient when it is turned so that the head is up.
    pub(crate) fn upright_orientation(&self, view: usize) -> PatientOrientation {
        let stored = PatientOrientation::of(&self.poses[view]);
        if self.head_last(view) { stored.upside_down() } else { stored }
    }

    /// The values of a view of `width` columns, turned so that the head is up.
    pub(crate) fn upright(&self, view: usize, values: &[f32], width: usize) -> Vec<f32> {
        if self.head_last(view) { last_row_first(values, width) } else { values.to_vec() }
    }
}

impl NamedView {
    /// Pose and values, `width` columns of them, turned so that the head is up and left and right are as the source sees them.
    pub(crate) fn seen_from_source(&self, values: &[f32], width: usize) -> (DetectorPose, Vec<f32>) {
        let (mut pose, mut values) = (self.pose, values.to_vec());
        if pose.row_step.z > 0.0 {
            pose.first_pixel += (values.len() / width - 1) as f64 * pose.row_step;
            pose.row_step = -pose.row_step;
            values = last_row_first(&values, width);
        }
        if pose.column_step.cross(pose.row_step).dot(pose.first_pixel - pose.source) < 0.0 {
            pose.first_pixel += (width - 1) as f64 * pose.column_step;
            pose.column_step = -pose.column_step;
            values.chunks_exact_mut(width).for_each(<[f32]>::reverse);
        }
        (pose, values)
    }
}

fn last_row_first(values: &[f32], width: usize) -> Vec<f32> {
    values.chunks_exact(width).rev().flatten().copied().collect()
}
