//! Files of a projection: images of each view, a picture, the plan, raw layers.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use drr::Projector;
use drr::engine::Images;
use drr::formats::{ColourPicture, radiograph, write_raw_f32, write_raw_f64, write_text};

use crate::charts::mark_views;
use crate::format::{Format, ViewImage};
use crate::inputs::Setup;
use crate::layer::{Channel, LayerName, channels, planes};
use crate::metadata::Metadata;
use crate::report::Layer;
use crate::views::{NamedView, Views};

/// Most images in the picture.
const PICTURED: usize = 6;

/// A projection.
pub(crate) struct Rendered {
    pub(crate) images: Images<f32>,
    /// Not rounded, where the engine is the reference.
    pub(crate) unrounded: Option<Images<f64>>,
}

impl Rendered {
    /// Bytes that are held.
    pub(crate) fn bytes(&self) -> usize {
        let Images { intensity, line_integral, areal_density, bone_path, .. } = &self.images;
        let values: usize = [intensity, line_integral, areal_density, bone_path].map(Vec::len).iter().sum();
        values * (size_of::<f32>() + if self.unrounded.is_some() { size_of::<f64>() } else { 0 })
    }
}

impl From<Images<f32>> for Rendered {
    fn from(images: Images<f32>) -> Self {
        Self { images, unrounded: None }
    }
}

impl From<Images<f64>> for Rendered {
    fn from(images: Images<f64>) -> Self {
        Self { images: images.map(|&x| x as f32), unrounded: Some(images) }
    }
}

/// Where files go, and what they say.
pub(crate) struct Output<'a> {
    projector: &'a Projector,
    folder: &'a Path,
    layers: Vec<LayerName>,
    channels: Vec<Channel>,
    formats: Vec<Format>,
    raw: bool,
    pub(crate) metadata: Metadata,
}

/// Makes the folder where it is missing, and sees before the work whether files can be made in it.
pub(crate) fn prepare(folder: &Path) -> Result<()> {
    // Under a name of its own: other processes may be at the same.
    std::fs::create_dir_all(folder)
        .and_then(|()| tempfile::tempfile_in(folder))
        .map(drop)
        .with_context(|| format!("--output {}", folder.display()))
}

/// Each of some values where it first is.
fn once<T: Copy + PartialEq>(values: &[T]) -> Vec<T> {
    let is_first = |(n, value): &(usize, &T)| !values[..*n].contains(value);
    values.iter().enumerate().filter(is_first).map(|(_, &value)| value).collect()
}

impl<'a> Output<'a> {
    /// Files in `folder`, which [`prepare`] has seen; of each layer and in each format once.
    pub(crate) fn new(
        setup: &Setup<'_>,
        projector: &'a Projector,
        folder: &'a Path,
        layers: &[LayerName],
        formats: &[Format],
        raw: bool,
    ) -> Self {
        let (layers, formats) = (once(layers), once(formats));
        let channels = channels(projector, &layers);
        let names: Vec<_> = channels.iter().map(|channel| channel.name.clone()).collect();
        let metadata = Metadata::new(setup, projector, &names);
        Self { projector, folder, layers, channels, formats, raw, metadata }
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        self.folder
    }

    /// A view's image files, each with its format.
    pub(crate) fn files(&self, view: &NamedView) -> Vec<(Format, PathBuf)> {
        let of = |&format: &Format| {
            let files = format.files(&view.name, &self.channels).into_iter();
            files.map(move |name| (format, self.folder.join(name)))
        };
        self.formats.iter().flat_map(of).collect()
    }

    /// The same of some views, in words.
    pub(crate) fn in_words(&self, views: &[NamedView]) -> String {
        let of = |format: &Format| match views {
            [] => String::new(),
            [only] => format.in_words(&only.name),
            [first, .., last] => {
                format!("{} ... {}", format.in_words(&first.name), format.in_words(&last.name))
            }
        };
        self.formats.iter().map(of).collect::<Vec<_>>().join(", ")
    }

    /// Where a view's raw layers are, if they are wanted.
    pub(crate) fn raw(&self, view: &NamedView, unrounded: bool) -> Vec<PathBuf> {
        let ending = if unrounded { "f64" } else { "f32" };
        let path = |channel: &Channel| self.folder.join(format!("{}_{}.{ending}", view.name, channel.file));
        if self.raw { self.channels.iter().map(path).collect() } else { Vec::new() }
    }

    /// Writes one of the views that were rendered, `place` among them; raw layers first, which do not say what they are.
    pub(crate) fn write_view(&self, view: &NamedView, rendered: &Rendered, place: usize) -> Result<()> {
        let images = &rendered.images;
        let values = planes(images, &self.layers, place);
        match &rendered.unrounded {
            Some(images) => {
                let unrounded = planes(images, &self.layers, place);
                for (path, values) in self.raw(view, true).iter().zip(unrounded) {
                    write_raw_f64(path, values)?;
                }
            }
            None => {
                for (path, values) in self.raw(view, false).iter().zip(&values) {
                    write_raw_f32(path, values)?;
                }
            }
        }
        let metadata = self.metadata.of(view);
        let image = ViewImage { view, size: images.size, channels: &self.channels, values, metadata };
        Ok(self.formats.iter().try_for_each(|format| format.write(self.folder, &view.name, &image))?)
    }

    /// The layers of the first views, for a report.
    pub(crate) fn pictured(&self, views: &Views, images: &Images<f32>) -> Result<Vec<Vec<Layer>>> {
        let of = |view: usize| {
            let values = planes(images, &self.layers, view).into_iter();
            let layer = |(channel, values): (&Channel, &[f32])| {
                let upright = views.upright(view, values, images.size[0]);
                let sides = views.upright_orientation(view);
                Layer::new(channel.name.clone(), channel.layer.unit(), &upright, images.size, sides)
            };
            self.channels.iter().zip(values).map(layer).collect()
        };
        (0..images.views.min(PICTURED)).map(of).collect()
    }

    /// Views, and beside each other the detector's layers of each, as a radiologist expects them: bone bright, head up,
    /// the sides of the patient at the edges.
    pub(crate) fn write_picture(&self, views: &Views, images: &Images<f32>) -> Result<ColourPicture> {
        let ([width, height], layers) = (images.size, images.detector_layers);
        let shown = (images.views * layers).min(PICTURED);
        let image = |n: usize| images.of_detector_layer(&images.line_integral, n / layers, n % layers);
        let upright: Vec<Vec<f32>> = (0..shown).map(|n| views.upright(n / layers, image(n), width)).collect();
        let upright: Vec<_> = upright.iter().map(Vec::as_slice).collect();
        let mut picture = radiograph(&upright, width, height)?.to_colour();
        let sides: Vec<_> = (0..shown).map(|n| views.upright_orientation(n / layers)).collect();
        mark_views(&mut picture, images.size, &sides)?;
        picture.write_png(&self.folder.join("radiograph.png"))?;
        Ok(picture)
    }

    pub(crate) fn write_plan(&self) -> Result<()> {
        Ok(write_text(&self.folder.join("plan.json"), &(self.projector.plan().to_json() + "\n"))?)
    }
}
