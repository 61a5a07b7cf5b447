//! `drr project`, and `drr` alone.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use drr::Projector;
use drr::accuracy::Certificate;
use drr::geometry::View;
use drr::planner::Effort;

use crate::batch::{Batch, Shard};
use crate::certificate;
use crate::console::Console;
use crate::format::Format;
use crate::inputs::Inputs;
use crate::job::{Done, Job};
use crate::layer::LayerName;
use crate::output::{Output, prepare};
use crate::report::Report;

/// Where files go unless the user says otherwise.
const DEFAULT_FOLDER: &str = "drr-output";

#[derive(Debug, Args)]
#[command(after_help = format!("{FILES}\n--views, for any number of views: drr project --help."))]
#[command(after_long_help = format!("{FILES}\n\n{BATCH}"))]
pub(crate) struct Arguments {
    #[command(flatten)]
    inputs: Inputs,
    /// Make part I of N of the rows of --views: row k, from 0, is in part (k mod N) + 1
    #[arg(long, value_name = "I/N", requires = "views", help_heading = "Views")]
    shard: Option<Shard>,
    /// Folder for the files; it is made where it is missing
    #[arg(long, short, value_name = "DIR", default_value = DEFAULT_FOLDER, help_heading = "Output")]
    output: PathBuf,
    /// Layers of the images
    #[arg(long, value_enum, value_name = "A,B,...", value_delimiter = ',', help_heading = "Output")]
    #[arg(default_value = "intensity,line_integral")]
    layers: Vec<LayerName>,
    /// Formats of the images
    #[arg(long, value_enum, value_name = "A,B,...", value_delimiter = ',', help_heading = "Output")]
    #[arg(default_value = "exr")]
    formats: Vec<Format>,
    /// Write every layer of every view also as a raw array
    #[arg(long, help_heading = "Output")]
    raw: bool,
    /// Do not cast rays again in float64 to measure the error
    #[arg(long, help_heading = "Output")]
    no_check: bool,
    /// Write report.html, too: pictures, plan, error, times and what it was made of, on one page with all in it
    #[arg(long, conflicts_with = "views", help_heading = "Output")]
    report: bool,
}

/// `drr project`.
pub(crate) fn run(arguments: &Arguments, console: Console) -> Result<ExitCode> {
    let setup = arguments.inputs.setup()?;
    if setup.physics.bone.is_none() && arguments.layers.contains(&LayerName::BonePath) {
        bail!("--layers: bone_path needs a material that is bone: one with \"bone\" in its name, or label 3");
    }
    let missing = |format: &&Format| format.needs().is_some_and(|layer| !arguments.layers.contains(&layer));
    if arguments.formats.iter().any(|format| missing(&format)) {
        bail!("--formats dicom writes line integrals; valid: with line_integral in --layers");
    }
    let loaded = setup.load(console)?;
    let loading = [loaded.reading, loaded.classifying].map(|time| time.as_secs_f64());
    let volume = Arc::new(loaded.volume);
    let views = setup.views(&volume)?;
    let projector = setup.projector(volume, &views)?;
    prepare(&arguments.output)?;
    console.say(format_args!("{}: {}", arguments.inputs.ct.name(), projector.plan().to_string().trim_end()));

    let poses: Vec<View> = views.poses.iter().map(|&pose| View::Pose(pose)).collect();
    let effort = Effort::new(&poses, projector.volume().grid(), projector.scene())?;
    let Arguments { layers, formats, raw, .. } = arguments;
    let output = Output::new(&setup, &projector, &arguments.output, layers, formats, *raw);
    let job = Job { setup: &setup, projector: &projector, views: &views, output: &output };
    let layers = crate::layer::layers(layers);
    let (mut wrote, done) = if arguments.inputs.views.is_table() {
        let shard = arguments.shard.unwrap_or(Shard::WHOLE);
        (Batch { job, shard, layers }.run(loading.iter().sum(), console)?, None)
    } else {
        let (wrote, done) = job.run(layers, &effort, loading, console)?;
        (wrote, Some(done))
    };
    let mut warnings = loaded.warnings;
    // Those were printed as they came.
    let told = warnings.len();
    if effort.slices == 0.0 {
        let text =
            "no ray meets the volume: are --origin, --sad, --sdd, --views or --geometry as they should be?";
        warnings.push(text.to_owned());
    }
    // Who wants it quiet wants it for a report alone.
    let measures = !arguments.no_check && (arguments.report || !console.is_quiet());
    let certificate = measures.then(|| projector.certify(&poses)).transpose()?;
    if let Some(certificate) = &certificate {
        console.say(certificate::lines(certificate, projector.plan()));
        warnings.extend(exceeded(certificate, &projector));
    }
    warnings[told..].iter().for_each(Console::warn);
    if let Some(Done { picture, images, times }) = done.as_ref().filter(|_| arguments.report) {
        let report = Report {
            setup: &setup,
            projector: &projector,
            views: &views,
            metadata: &output.metadata,
            picture,
            layers: output.pictured(&views, images)?,
            times,
            certificate: certificate.as_ref(),
            warnings: &warnings,
        };
        report.write(&arguments.output)?;
        wrote += ", report.html";
    }
    console.say(format_args!("wrote   {wrote} in {}", arguments.output.display()));
    Ok(ExitCode::SUCCESS)
}

/// `drr` alone: every layer of two views of the CT that the command carries.
pub(crate) fn main_job(console: Console) -> Result<ExitCode> {
    let layers = LayerName::value_variants().to_vec();
    let arguments = Arguments {
        inputs: Inputs::default(),
        shard: None,
        output: DEFAULT_FOLDER.into(),
        layers,
        formats: vec![Format::Exr],
        raw: false,
        no_check: false,
        report: false,
    };
    run(&arguments, console)
}

/// That the error is larger than the tolerance, where it is.
fn exceeded(certificate: &Certificate, projector: &Projector) -> Option<String> {
    let allowed = projector.scene().tolerance?.hu;
    let hu = certificate.total.hu.filter(|hu| hu.rms > allowed)?;
    Some(format!(
        "{:.3} HU are more than the {allowed} that are allowed: on these rays, others than the method was chosen by",
        hu.rms
    ))
}

/// What is written.
const FILES: &str = "\
Files in DIR, N counting views from 0: viewN.exr (float32 layers; geometry, physics and method as attributes),
radiograph.png (the first 6 images side by side, bone bright, head up; letters at the edges are the patient's sides),
plan.json; with --report also report.html. --formats: tiff is viewN.tiff (a page of float32 per layer with its name in
PageName, and in ImageDescription, as JSON, what OpenEXR has as attributes); png16 is viewN_LAYER.png (16 bits; value =
drr.offset + drr.scale * sample, both in its text chunks, from 0 to the largest value of the file); dicom is
viewN_line_integral.dcm, an RT Image of 16 bits, head up, with what the others say, as JSON, in ImageComments. Elsewhere
rows are stored as the pose has them, of a C-arm the feet first; drr.patient_orientation is DICOM's (0020,0020),
directions of rows and of columns, of rows as the pose has them. --raw adds viewN_LAYER.f32 and viewN_areal_density_MATERIAL.f32 (little-endian, row by row, pixel (i,j) at
j*width + i), or .f64, not rounded, with --engine reference. Of a detector with two layers intensity and line integral
are intensity.LAYER, line_integral.LAYER (raw: viewN_intensity_LAYER.f32), and both are in the picture. A file appears
under its name only when it is complete.";

/// Many views; tests/command/batch.rs runs the example.
const BATCH: &str = "\
Many views: --views FILE.csv has one per row, for example

  name,angle_degrees,sad_mm,offset_z_mm
  case1_a,-6,1000,0
  case1_b,6.5,1010,-12.5

They are projected and written a few at a time, so that memory does not grow with their number: NAME.exr, or
view000000.exr, view000001.exr, ... without a column name, and so with other formats; plan.json; made_of.json; no
picture and no report. Row k, counted from 0, has the bytes of a call of its own with the same pose and --first-view k:
noise follows from the seed and this number, whatever else is made beside it. What --tolerance-hu, --preset,
--few-energies and --focal-spot decide is decided for all rows, in every shard.

A run that was stopped goes on where it was: views of which all files are there are not made again. A file that was made of another
CT, scene, method or pose than its row asks for is not replaced, but an error; so is a folder whose made_of.json, which
the first process writes, says something else. Several processes may fill one folder, each with its shard of the rows:

  # Two processes on one machine
  drr project --ct chest.nii --views views.csv --output out --threads 8 --shard 1/2 &
  drr project --ct chest.nii --views views.csv --output out --threads 8 --shard 2/2 &
  wait

  # GNU parallel
  seq 8 | parallel drr project --ct chest.nii --views views.csv --output out --shard {}/8

  # Slurm: a script, and a folder that all machines see
  #SBATCH --array=1-50
  drr project --ct chest.nii --views views.csv --output out --shard $SLURM_ARRAY_TASK_ID/50

For Ray and others a shard is a task; one that failed is started again. --shard K/N, with N the number of rows, makes
row K-1 alone. Bytes are the same for any number of threads; processors of different kinds may round differently.";
