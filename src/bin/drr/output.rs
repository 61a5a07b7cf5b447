//! Files of a projection: one OpenEXR per view, a picture, the plan, raw layers.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use clap::ValueEnum;
use drr::Projector;
use drr::engine::{Images, Layers};
use drr::formats::{ExrImage, radiograph, write_exr, write_raw_f32, write_raw_f64, write_text};

use crate::charts::mark_views;
use crate::inputs::Setup;
use crate::metadata::Metadata;
use crate::physics::file_name;
use crate::views::{NamedView, Views};

/// Most images in the picture.
const PICTURED: usize = 6;

/// A layer that can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(crate) enum LayerName {
    /// Detector signal in the units of the spectrum's weights; I0 where a ray meets nothing
    Intensity,
    /// p = -ln(I/I0), dimensionless
    LineIntegral,
    /// One layer per material, g/cm²
    ArealDensity,
    /// Length through voxels labelled bone, mm
    BonePath,
}

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
    raw: bool,
    pub(crate) metadata: Metadata,
}

/// The layers that the names stand for.
pub(crate) fn layers(names: &[LayerName]) -> Layers {
    let has = |name| names.contains(&name);
    Layers {
        intensity: has(LayerName::Intensity),
        line_integral: has(LayerName::LineIntegral),
        areal_density: has(LayerName::ArealDensity),
        bone_path: has(LayerName::BonePath),
    }
}

/// Makes the folder where it is missing, and sees before the work whether files can be made in it.
pub(crate) fn prepare(folder: &Path) -> Result<()> {
    // Under a name of its own: other processes may be at the same.
    std::fs::create_dir_all(folder)
        .and_then(|()| tempfile::tempfile_in(folder))
        .map(drop)
        .with_context(|| format!("--output {}", folder.display()))
}

impl<'a> Output<'a> {
    /// Files in `folder`, which [`prepare`] has seen; of each layer once.
    pub(crate) fn new(
        setup: &Setup<'_>,
        projector: &'a Projector,
        folder: &'a Path,
        layers: &[LayerName],
        raw: bool,
    ) -> Self {
        let mut once: Vec<LayerName> = Vec::new();
        for &layer in layers {
            if !once.contains(&layer) {
                once.push(layer);
            }
        }
        let channels: Vec<_> = channels(projector, &once).into_iter().map(|channel| channel.exr).collect();
        let metadata = Metadata::new(setup, projector, &channels);
        Self { projector, folder, layers: once, raw, metadata }
    }

    /// The folder.
    pub(crate) fn folder(&self) -> &Path {
        self.folder
    }

    /// Where a view's OpenEXR file is.
    pub(crate) fn exr(&self, view: &NamedView) -> PathBuf {
        self.folder.join(format!("{}.exr", view.name))
    }

    /// Where a view's raw layers are, if they are wanted.
    pub(crate) fn raw(&self, view: &NamedView, unrounded: bool) -> Vec<PathBuf> {
        let ending = if unrounded { "f64" } else { "f32" };
        let path = |channel: Channel| self.folder.join(format!("{}_{}.{ending}", view.name, channel.raw));
        let channels = if self.raw { channels(self.projector, &self.layers) } else { Vec::new() };
        channels.into_iter().map(path).collect()
    }

    /// Writes one of the views that were rendered, `place` among them; its OpenEXR file last.
    pub(crate) fn write_view(&self, view: &NamedView, rendered: &Rendered, place: usize) -> Result<()> {
        let images = &rendered.images;
        let planes = self.planes(images, place);
        match &rendered.unrounded {
            Some(images) => {
                for (path, values) in self.raw(view, true).iter().zip(self.planes(images, place)) {
                    write_raw_f64(path, values)?;
                }
            }
            None => {
                for (path, values) in self.raw(view, false).iter().zip(&planes) {
                    write_raw_f32(path, values)?;
                }
            }
        }
        let names = channels(self.projector, &self.layers).into_iter().map(|channel| channel.exr);
        let [width, height] = images.size;
        let layers = names.zip(planes).collect();
        Ok(write_exr(&self.exr(view), &ExrImage { width, height, layers, metadata: self.metadata.of(view) })?)
    }

    /// The layers of a view that were asked for, in the order of [`channels`].
    fn planes<'b, T: Copy + Default>(&self, images: &'b Images<T>, view: usize) -> Vec<&'b [T]> {
        let signal = |layer: &'b [T]| {
            (0..images.detector_layers).map(|l| images.of_detector_layer(layer, view, l)).collect::<Vec<_>>()
        };
        let of = |layer: &LayerName| match layer {
            LayerName::Intensity => signal(&images.intensity),
            LayerName::LineIntegral => signal(&images.line_integral),
            LayerName::BonePath => vec![images.view(&images.bone_path, view)],
            LayerName::ArealDensity => (0..images.materials).map(|m| images.areal_density(view, m)).collect(),
        };
        self.layers.iter().flat_map(of).collect()
    }

    /// Views, and beside each other the detector's layers of each, as a radiologist expects them: bone bright, head up,
    /// the sides of the patient at the edges.
    pub(crate) fn write_picture(&self, views: &Views, images: &Images<f32>) -> Result<()> {
        let ([width, height], layers) = (images.size, images.detector_layers);
        let shown = (images.views * layers).min(PICTURED);
        let image = |n: usize| images.of_detector_layer(&images.line_integral, n / layers, n % layers);
        let upright: Vec<Vec<f32>> = (0..shown).map(|n| views.upright(n / layers, image(n), width)).collect();
        let upright: Vec<_> = upright.iter().map(Vec::as_slice).collect();
        let mut picture = radiograph(&upright, width, height)?.to_colour();
        let sides: Vec<_> = (0..shown).map(|n| views.upright_orientation(n / layers)).collect();
        mark_views(&mut picture, images.size, &sides)?;
        Ok(picture.write_png(&self.folder.join("radiograph.png"))?)
    }

    pub(crate) fn write_plan(&self) -> Result<()> {
        Ok(write_text(&self.folder.join("plan.json"), &(self.projector.plan().to_json() + "\n"))?)
    }
}

/// What a layer is called.
struct Channel {
    /// In OpenEXR, where a dot makes a group.
    exr: String,
    /// In the names of raw files.
    raw: String,
}

/// Those of the layers' images, in order.
fn channels(projector: &Projector, layers: &[LayerName]) -> Vec<Channel> {
    let scene = projector.scene();
    let signal =
        |name: &str| (0..scene.layers()).map(|l| Channel::of_detector_layer(projector, name, l)).collect();
    let of = |layer: &LayerName| match layer {
        LayerName::Intensity => signal("intensity"),
        LayerName::LineIntegral => signal("line_integral"),
        LayerName::BonePath => vec![Channel::of("bone_path")],
        LayerName::ArealDensity => scene.materials.names().iter().map(|m| Channel::of_material(m)).collect(),
    };
    layers.iter().flat_map(of).collect()
}

impl Channel {
    fn of(name: &str) -> Self {
        Self { exr: name.into(), raw: name.into() }
    }

    fn of_material(material: &str) -> Self {
        let raw = format!("areal_density_{}", file_name(material));
        Self { exr: format!("areal_density.{material}"), raw }
    }

    /// One of a detector's layers: plain where there is one.
    fn of_detector_layer(projector: &Projector, name: &str, layer: usize) -> Self {
        let scene = projector.scene();
        if scene.layers() == 1 {
            return Self::of(name);
        }
        let own = file_name(scene.detector_layers[layer].name());
        let alike = scene.detector_layers.iter().filter(|other| file_name(other.name()) == own).count() > 1;
        let own = if alike { format!("{own}_{}", layer + 1) } else { own };
        Self { exr: format!("{name}.{own}"), raw: format!("{name}_{own}") }
    }
}
