//! `drr phantom`.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::formats::{NiftiWriter, is_nifti};
use drr::geometry::Grid;
use drr::phantom::Phantom;
use glam::DVec3;

use crate::console::Console;
use crate::value;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Name of the phantom; see --list
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// Print the names of the phantoms
    #[arg(long)]
    list: bool,
    /// Voxels along x, y, z
    #[arg(long, value_name = "NX,NY,NZ", value_parser = value::dimensions, allow_hyphen_values = true, default_value = "360,360,332")]
    size: [usize; 3],
    /// Distance of voxel centres, mm; the volume is centred on 0,0,0 [default: what covers 360 x 360 x 332.5 mm]
    #[arg(long, value_name = "SX,SY,SZ", value_parser = value::spacing, allow_hyphen_values = true)]
    spacing: Option<DVec3>,
    /// Add a fixed pseudo-random -15 ... +16 HU to the voxels of the first part (of thorax: the body)
    #[arg(long)]
    noise: bool,
    /// The CT, int16 HU: .nii or .nii.gz
    #[arg(long, short, value_name = "FILE", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// The material of every voxel, uint8 (0 air, 1 lung, 2 soft tissue, 3 bone): .nii or .nii.gz
    #[arg(long, value_name = "FILE")]
    labels_output: Option<PathBuf>,
}

/// `drr phantom`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let (Some(name), Some(output), false) = (&arguments.name, &arguments.output, arguments.list) else {
        for name in Phantom::names() {
            Console::answer(name);
        }
        return Ok(ExitCode::SUCCESS);
    };
    for (argument, path) in
        [("--output", Some(output)), ("--labels-output", arguments.labels_output.as_ref())]
    {
        if let Some(path) = path
            && !is_nifti(path)
        {
            bail!("{argument} is {}; valid: a name that ends in .nii or .nii.gz", path.display());
        }
    }
    let phantom = Phantom::named(name).context("NAME")?.with_noise(arguments.noise);
    let grid = match arguments.spacing {
        Some(spacing) => Grid::centred(arguments.size, spacing),
        None => phantom.grid(arguments.size),
    };
    let grid = grid.context("--size, --spacing")?;
    let mut ct = NiftiWriter::<i16>::create(output, &grid).context("--output")?;
    let labels = arguments.labels_output.as_ref().map(|path| NiftiWriter::<u8>::create(path, &grid));
    let mut labels = labels.transpose().context("--labels-output")?;
    let bar = console.bar("voxelising", grid.dimensions()[2]);
    phantom.voxelise(&grid, |_, hu, materials| {
        bar.inc(1);
        ct.push_slice(hu)?;
        labels.as_mut().map_or(Ok(()), |labels| labels.push_slice(materials))
    })?;
    bar.finish_and_clear();
    ct.finish().context("--output")?;
    labels.map_or(Ok(()), NiftiWriter::finish).context("--labels-output")?;
    let [n0, n1, n2] = grid.dimensions();
    console.say(format_args!("{name}: {n0}×{n1}×{n2} voxels in {}", output.display()));
    Ok(ExitCode::SUCCESS)
}
