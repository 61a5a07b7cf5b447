//! The CT and its labels: which files, and how they become a volume.

use std::path::PathBuf;
use std::sync::mpsc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::formats::{
    CtReader, DicomCt, LabelReader, RawLayout, Slice, VoxelKind, is_raw, open_ct, open_labels,
};
use drr::geometry::Grid;
use drr::volume::{Classification, Volume, VolumeBuilder};
use glam::DVec3;

use crate::console::Console;
use crate::{default_ct, value};

#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Volume")]
pub(crate) struct CtArguments {
    /// CT in HU: a DICOM folder, NIfTI, MetaImage or NRRD, or raw int16 (little-endian, x fastest), which needs --dims and --spacing
    ///
    /// Without it, the CT that the command carries is projected. A DICOM folder may hold folders, and files that are no
    /// slices; one file will do where it has several frames.
    #[arg(long, value_name = "DIR|FILE")]
    ct: Option<PathBuf>,
    /// The series to read of a DICOM folder with several: its SeriesInstanceUID, which the command lists without this
    #[arg(long, value_name = "UID", requires = "ct", conflicts_with = "dims")]
    series: Option<String>,
    /// Voxels of a raw CT along x, y, z
    #[arg(long, value_name = "NX,NY,NZ", value_parser = value::dimensions, allow_hyphen_values = true, requires = "ct")]
    dims: Option<[usize; 3]>,
    /// Distance of voxel centres of a raw CT along x, y, z, mm
    #[arg(long, value_name = "SX,SY,SZ", value_parser = value::spacing, requires = "dims")]
    #[arg(allow_hyphen_values = true)]
    spacing: Option<DVec3>,
    /// Centre of voxel (0,0,0) of a raw CT in the world, mm [default: the volume is centred on 0,0,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = value::vector, requires = "dims")]
    #[arg(allow_hyphen_values = true)]
    origin: Option<DVec3>,
    /// Material label of every voxel, 0 to 7: NIfTI, MetaImage or NRRD on the grid of the CT, or raw uint8; labels win over --thresholds
    #[arg(long, value_name = "FILE")]
    labels: Option<PathBuf>,
}

/// A volume, and how long it took.
pub(crate) struct Loaded {
    pub(crate) volume: Volume,
    /// Reading and decompressing the files.
    pub(crate) reading: Duration,
    /// Making voxels of HU and labels.
    pub(crate) classifying: Duration,
    /// What the files say that may make images wrong.
    pub(crate) warnings: Vec<String>,
}

impl CtArguments {
    /// What is projected, in words.
    pub(crate) fn name(&self) -> String {
        self.ct.as_ref().map_or_else(|| default_ct::NAME.into(), |path| path.display().to_string())
    }

    /// Reads the CT, slice by slice; labels are read beside it on a thread of their own.
    pub(crate) fn load(&self, how: &Classification, console: Console) -> Result<Loaded> {
        let start = Instant::now();
        let mut ct = self.open()?;
        let grid = ct.header().grid;
        let mut labels = match &self.labels {
            Some(path) => Some(open_labels(path, &grid).context("--labels")?),
            None => None,
        };
        let mut builder = match ct.header().voxels {
            VoxelKind::Int16 => VolumeBuilder::int16(grid, how, labels.is_some())?,
            VoxelKind::Float32 => VolumeBuilder::float32(grid, how)?,
        };
        let bar = console.bar("reading", grid.dimensions()[2]);
        let mut classifying = Duration::ZERO;
        let mut push = |slice: Slice<'_>, labels: Option<&[u8]>| {
            let start = Instant::now();
            match slice {
                Slice::Int16(hu) => builder.push_int16(hu, labels)?,
                Slice::Float32(hu) => builder.push_float32(hu, labels)?,
            }
            classifying += start.elapsed();
            bar.inc(1);
            Ok(())
        };
        match &mut labels {
            Some(labels) => read_both(ct.as_mut(), labels.as_mut(), &mut push)?,
            None => ct.read(&mut |_, slice| push(slice, None)).context("--ct")?,
        }
        bar.finish_and_clear();
        let mut warnings = Vec::new();
        for note in ct.notes() {
            match note.strip_prefix("warning: ") {
                Some(warning) => {
                    Console::warn(format_args!("--ct: {warning}"));
                    warnings.push(format!("--ct: {warning}"));
                }
                None => console.say(format_args!("ct      {note}")),
            }
        }
        let finishing = Instant::now();
        let volume = builder.finish()?;
        classifying += finishing.elapsed();
        Ok(Loaded { volume, reading: start.elapsed().saturating_sub(classifying), classifying, warnings })
    }

    fn open(&self) -> Result<Box<dyn CtReader>> {
        let Some(path) = &self.ct else { return Ok(Box::new(default_ct::open()?)) };
        if let Some(series) = &self.series {
            return Ok(Box::new(DicomCt::open(path, Some(series)).context("--ct, --series")?));
        }
        let raw = is_raw(path);
        if !raw && self.dims.is_some() {
            bail!("--dims is given with a file that says itself what it holds; valid: only with a raw CT");
        }
        let layout = self.dims.map(|dimensions| self.layout(dimensions)).transpose()?;
        if raw && layout.is_none() {
            bail!(
                "--dims is missing: {} is not a DICOM folder or file, nor .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr, and raw voxels need it",
                path.display()
            );
        }
        open_ct(path, layout).context("--ct")
    }

    fn layout(&self, dimensions: [usize; 3]) -> Result<RawLayout> {
        let Some(spacing) = self.spacing else { bail!("--spacing is missing: a raw CT needs it") };
        let centred = Grid::centred(dimensions, spacing).context("--dims, --spacing")?;
        let origin = self.origin.unwrap_or(centred.index_to_world().translation);
        Ok(RawLayout { dimensions, spacing, origin })
    }
}

type Push<'a> = dyn FnMut(Slice<'_>, Option<&[u8]>) -> drr::Result<()> + 'a;

/// Hands over slices of CT and labels together. At most two slices of labels wait.
fn read_both(ct: &mut dyn CtReader, labels: &mut dyn LabelReader, push: &mut Push<'_>) -> Result<()> {
    let stopped = || drr::Error::Unsupported("the other file could not be read".into());
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::sync_channel::<Vec<u8>>(2);
        let reading = scope
            .spawn(move || labels.read(&mut |_, slice| sender.send(slice.to_vec()).map_err(|_| stopped())));
        let ct_read = ct.read(&mut |_, slice| {
            let labels = receiver.recv().map_err(|_| stopped())?;
            push(slice, Some(&labels))
        });
        // Lets the reader of labels stop when that of the CT has failed.
        drop(receiver);
        let labels_read = reading.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match (ct_read, labels_read) {
            (Ok(()), labels_read) => labels_read.context("--labels"),
            // Whichever is not the echo of the other.
            (Err(echo), Err(error)) if echo == stopped() => Err(error).context("--labels"),
            (Err(error), _) => Err(error).context("--ct, --labels"),
        }
    })
}
