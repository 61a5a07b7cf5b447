//! HU from the slices of a series.

use std::path::{Path, PathBuf};

use glam::DMat3;

use super::files;
use super::object::{Frame, Object};
use super::series::Series;
use super::stack::{Place, Stack};
use crate::allocation::grow;
use crate::error::Result;
use crate::formats::{CtHeader, CtReader, Slice, VoxelKind, file_error};
use crate::geometry::AnatomicalDirection;

/// What padding is delivered as: below −1024 HU nothing is tissue, and density 0.
const PADDING_HU: i16 = -2048;
/// Tilts below this are rounding of positions, degrees.
const LEAST_TILT: f64 = 0.01;

/// A CT in DICOM: the slices of one series, one file each, or frames of one; compressed or not.
///
/// Slices are in order of their positions along their normal, whatever files are called. Their spacing is that of their
/// positions; those of a tilted gantry form a sheared grid. Padding is −2048 HU.
#[derive(Debug)]
pub struct DicomCt {
    header: CtHeader,
    objects: Vec<Object>,
    places: Vec<Place>,
    notes: Vec<String>,
    padding: Option<usize>,
}

impl DicomCt {
    /// Opens a folder, with those in it, or a file with several frames. `series` is the `SeriesInstanceUID` of one, which is
    /// needed where there are several.
    ///
    /// # Errors
    /// `File`, with the file at fault, where the slices are not those of one CT on one grid, or the pixels are stored in
    /// a way that is not read.
    pub fn open(path: &Path, series: Option<&str>) -> Result<Self> {
        Self::from_files(path, &files::list(path)?, series)
    }

    /// As `open`, for files that the caller has chosen; `name` stands for all of them in messages.
    pub fn from_files(name: &Path, files: &[PathBuf], series: Option<&str>) -> Result<Self> {
        let Series { objects, mut notes } = Series::choose(files::read(files)?, name, series)?;
        let stack = Stack::new(&objects).map_err(|reason| file_error(name, reason))?;
        notes.splice(0..0, describe(&objects, &stack));
        let Stack { grid, places } = stack;
        let header = CtHeader { grid, voxels: VoxelKind::Int16 };
        let mut ct = Self { header, objects, places, notes, padding: None };
        ct.check_finite()?;
        if !ct.fits_int16()? {
            ct.header.voxels = VoxelKind::Float32;
        }
        Ok(ct)
    }

    /// Whether float32 holds whatever the pixels may be.
    fn check_finite(&self) -> Result<()> {
        for object in &self.objects {
            let fits = |frame: &Frame| {
                object.stored.range().iter().all(|&stored| (frame.hu(stored) as f32).is_finite())
            };
            if let Some(Frame { slope, intercept, .. }) = object.frames.iter().find(|frame| !fits(frame)) {
                let reason = format!(
                    "RescaleSlope {slope} and RescaleIntercept {intercept} make values beyond float32"
                );
                return Err(file_error(&object.path, reason));
            }
        }
        Ok(())
    }

    /// Whether all HU are whole and at most as large as an int16 holds. Smaller ones are padding in any case.
    fn fits_int16(&self) -> Result<bool> {
        let largest = f64::from(i16::MAX);
        let frames =
            || self.objects.iter().flat_map(|object| object.frames.iter().map(move |frame| (object, frame)));
        if frames().any(|(_, frame)| frame.slope.fract() != 0.0 || frame.intercept.fract() != 0.0) {
            return Ok(false);
        }
        let fits = |(object, frame): (&Object, &Frame)| {
            object.stored.range().iter().all(|&stored| frame.hu(stored) <= largest)
        };
        if frames().all(fits) {
            return Ok(true);
        }
        for place in &self.places {
            let mut all_fit = true;
            self.hu(*place, |hu| all_fit &= hu.is_none_or(|hu| hu <= largest))?;
            if !all_fit {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Gives every voxel of a slice to `each`; padding is none.
    fn hu(&self, place: Place, mut each: impl FnMut(Option<f64>)) -> Result<()> {
        let object = &self.objects[place.object];
        let frame = &object.frames[place.frame];
        let (words, stored) = object.words(place.frame)?;
        for word in words {
            let stored = stored.value(word);
            let padding = object.padding.is_some_and(|[low, high]| (low..=high).contains(&stored));
            each((!padding).then(|| frame.hu(stored)));
        }
        Ok(())
    }

    fn read_as<T: Clone>(
        &self,
        zero: T,
        number: impl Fn(f64) -> T,
        consume: &mut dyn FnMut(usize, &[T]) -> Result<()>,
    ) -> Result<usize> {
        let [n0, n1, _] = self.header.grid.dimensions();
        let (mut voxels, mut padding) = (Vec::new(), 0);
        grow(&mut voxels, n0 * n1, zero, "a slice of voxels")?;
        for (k, &place) in self.places.iter().enumerate() {
            let mut rest = voxels.iter_mut();
            self.hu(place, |hu| {
                padding += usize::from(hu.is_none());
                if let Some(voxel) = rest.next() {
                    *voxel = number(hu.unwrap_or(PADDING_HU.into()));
                }
            })?;
            consume(k, &voxels)?;
        }
        Ok(padding)
    }
}

impl Frame {
    fn hu(&self, stored: i64) -> f64 {
        self.slope * stored as f64 + self.intercept
    }
}

impl CtReader for DicomCt {
    fn header(&self) -> &CtHeader {
        &self.header
    }

    fn read(&mut self, consume: &mut dyn FnMut(usize, Slice<'_>) -> Result<()>) -> Result<()> {
        let padding = match self.header.voxels {
            // Exact: `fits_int16` has established that; what is less becomes the smallest number.
            VoxelKind::Int16 => self.read_as(0, |hu| hu as i16, &mut |k, hu| consume(k, Slice::Int16(hu))),
            VoxelKind::Float32 => {
                self.read_as(0.0, |hu| hu as f32, &mut |k, hu| consume(k, Slice::Float32(hu)))
            }
        };
        self.padding = Some(padding?);
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let padding = self.padding.filter(|&count| count > 0);
        let padding = padding.map(|count| format!("{count} voxels are padding, which is vacuum"));
        self.notes.iter().cloned().chain(padding).collect()
    }
}

/// What a user may want to see.
fn describe(objects: &[Object], stack: &Stack) -> Vec<String> {
    let first = &objects[0];
    let description = first.description.as_deref().unwrap_or("without a description");
    let DMat3 { x_axis, y_axis, z_axis } = stack.grid.index_to_world().matrix3;
    let [i, j, k] = [x_axis, y_axis, z_axis].map(AnatomicalDirection::of);
    let mut notes = vec![
        format!("series {}, {description}", first.series),
        format!("pixels of a row run to {i}, rows to {j}, slices to {k} of the patient"),
    ];
    let tilt = stack.tilt();
    if tilt > LEAST_TILT {
        notes.push(format!(
            "the gantry was tilted by {tilt:.2}°: slices are kept where they are, in a sheared grid"
        ));
    }
    if objects.iter().any(|object| object.lossy) {
        notes.push("slices were compressed with loss".to_owned());
    }
    if let Some(unit) = objects.iter().flat_map(|object| &object.frames).find_map(|frame| frame.unit.as_ref())
    {
        notes.push(format!("warning: values are called {unit}, not HU, and are taken for HU"));
    }
    notes
}
