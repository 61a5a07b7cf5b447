//! Views that were measured.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::formats::{GeometryFile, read_views};
use drr::geometry::Grid;
use drr::parallel::ParallelGeometry;
use glam::DVec3;

use super::Scan;
use super::acquisition::Geometry;
use crate::line_integrals::read_line_integrals;
use crate::object::ObjectArguments;
use crate::value;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Measured views")]
pub(super) struct MeasuredArguments {
    /// Line integrals -ln(I/I0), float32, little-endian, view by view and row by row; needs --views or --geometry, and
    /// --volume
    #[arg(long, value_name = "FILE.f32", requires = "volume", requires = "from")]
    #[arg(conflicts_with_all = ["ct", "phantom", "beam", "count", "photons", "voxels"])]
    measured: Option<PathBuf>,
    /// The views of a parallel beam: columns alpha_degrees,beta_degrees,phi_degrees,dx_mm,dz_mm; needs --size and
    /// --pixel
    ///
    /// The beam runs along y; the object is turned by R = R_y(beta) R_x(alpha) R_z(phi) about its centre, and shifted.
    /// Columns of pixels see growing x, rows growing z.
    #[arg(long, value_name = "FILE.csv", requires = "measured", group = "from")]
    views: Option<PathBuf>,
    /// The poses of a cone beam, as JSON; see drr project --help
    #[arg(long, value_name = "FILE.json", requires = "measured", group = "from")]
    geometry: Option<PathBuf>,
    /// Columns and rows of a parallel beam's pixels
    #[arg(long, value_name = "WxH", value_parser = value::size, allow_hyphen_values = true, requires = "measured")]
    size: Option<[usize; 2]>,
    /// Distance of a parallel beam's pixels, mm: along columns and rows, or one number for both
    #[arg(long, value_name = "MM[,MM]", value_parser = pitch, allow_hyphen_values = true, requires = "measured")]
    pixel: Option<[f64; 2]>,
    /// Voxels along x, y, z, centred on 0,0,0
    #[arg(long, value_name = "NX,NY,NZ", value_parser = value::dimensions, allow_hyphen_values = true)]
    #[arg(requires = "measured", requires = "voxel")]
    volume: Option<[usize; 3]>,
    /// Distance of voxel centres, mm: along x, y, z
    #[arg(long, value_name = "SX,SY,SZ", value_parser = value::spacing, allow_hyphen_values = true)]
    #[arg(requires = "measured")]
    voxel: Option<DVec3>,
}

/// One number, or two.
fn pitch(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<_> = text.split(',').map(|part| value::positive(part.trim())).collect();
    match &parts[..] {
        [Ok(both)] => Ok([*both; 2]),
        [Ok(columns), Ok(rows)] => Ok([*columns, *rows]),
        _ => Err("expected one or two numbers above 0, mm".into()),
    }
}

impl MeasuredArguments {
    /// Whether the beam is parallel; `None` where nothing was measured.
    pub(super) fn is_parallel(&self) -> Option<bool> {
        self.measured.as_ref().map(|_| self.views.is_some())
    }

    /// What was measured, if anything was.
    pub(super) fn scan(&self, object: &ObjectArguments) -> Result<Option<Scan>> {
        let Some(path) = &self.measured else { return Ok(None) };
        let (Some(dimensions), Some(spacing)) = (self.volume, self.voxel) else {
            bail!("--measured needs --volume and --voxel: what is to be reconstructed");
        };
        let start = std::time::Instant::now();
        let (kev, water) = (object.kev, object.water()?);
        let grid = Grid::centred(dimensions, spacing).context("--volume, --voxel")?;
        let geometry = self.geometry(dimensions, spacing)?;
        let [width, height] = geometry.size();
        let data = read_line_integrals(path, geometry.count() * width * height)?;
        let (name, seconds) = (path.display().to_string(), start.elapsed().as_secs_f64());
        Ok(Some(Scan { name, geometry, hidden: None, grid, data, truth: None, kev, water, seconds }))
    }

    fn geometry(&self, dimensions: [usize; 3], spacing: DVec3) -> Result<Geometry> {
        if let Some(path) = &self.views {
            return Ok(Geometry::Parallel(
                self.detector(dimensions, spacing)?,
                read_views(path).context("--views")?,
            ));
        }
        let Some(path) = &self.geometry else { bail!("--measured needs --views or --geometry") };
        let file = GeometryFile::read(path).context("--geometry")?;
        Ok(Geometry::Cone { size: [file.width, file.height], poses: file.views })
    }

    fn detector(&self, dimensions: [usize; 3], spacing: DVec3) -> Result<ParallelGeometry> {
        let (Some(size), Some(pixel)) = (self.size, self.pixel) else {
            bail!("--size and --pixel are missing: the views of a parallel beam need them");
        };
        let geometry = ParallelGeometry::new(dimensions, spacing, size, pixel);
        geometry.validate().context("--size, --pixel, --volume, --voxel")?;
        Ok(geometry)
    }
}
