//! The layers of images: which there are, what they are called and what their values are.

use clap::ValueEnum;
use drr::Projector;
use drr::engine::{Images, Layers};

use crate::physics::file_name;

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

impl LayerName {
    /// What its values are in.
    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Intensity => "weights of the spectrum",
            Self::LineIntegral => "1",
            Self::ArealDensity => "g/cm\u{b2}",
            Self::BonePath => "mm",
        }
    }
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

/// The images of a view that some layers have, in the order of [`channels`].
pub(crate) fn planes<'a, T: Copy + Default>(
    images: &'a Images<T>,
    layers: &[LayerName],
    view: usize,
) -> Vec<&'a [T]> {
    let signal = |layer: &'a [T]| {
        (0..images.detector_layers).map(|l| images.of_detector_layer(layer, view, l)).collect::<Vec<_>>()
    };
    let of = |layer: &LayerName| match layer {
        LayerName::Intensity => signal(&images.intensity),
        LayerName::LineIntegral => signal(&images.line_integral),
        LayerName::BonePath => vec![images.view(&images.bone_path, view)],
        LayerName::ArealDensity => (0..images.materials).map(|m| images.areal_density(view, m)).collect(),
    };
    layers.iter().flat_map(of).collect()
}

/// What one of the images of a view is called.
#[derive(Debug)]
pub(crate) struct Channel {
    /// In OpenEXR, where a dot makes a group.
    pub(crate) name: String,
    /// In the names of files that have this image alone.
    pub(crate) file: String,
    pub(crate) layer: LayerName,
}

/// Those of the layers' images, in order.
pub(crate) fn channels(projector: &Projector, layers: &[LayerName]) -> Vec<Channel> {
    let scene = projector.scene();
    let of = |&layer: &LayerName| {
        let signal = |name: &str| {
            (0..scene.layers()).map(|l| Channel::of_detector_layer(projector, name, l, layer)).collect()
        };
        match layer {
            LayerName::Intensity => signal("intensity"),
            LayerName::LineIntegral => signal("line_integral"),
            LayerName::BonePath => vec![Channel::of("bone_path", layer)],
            LayerName::ArealDensity => {
                scene.materials.names().iter().map(|m| Channel::of_material(m, layer)).collect()
            }
        }
    };
    layers.iter().flat_map(of).collect()
}

impl Channel {
    fn of(name: &str, layer: LayerName) -> Self {
        Self { name: name.into(), file: name.into(), layer }
    }

    fn of_material(material: &str, layer: LayerName) -> Self {
        let file = format!("areal_density_{}", file_name(material));
        Self { name: format!("areal_density.{material}"), file, layer }
    }

    /// One of a detector's layers: plain where there is one.
    fn of_detector_layer(projector: &Projector, name: &str, number: usize, layer: LayerName) -> Self {
        let scene = projector.scene();
        if scene.layers() == 1 {
            return Self::of(name, layer);
        }
        let own = file_name(scene.detector_layers[number].name());
        let alike = scene.detector_layers.iter().filter(|other| file_name(other.name()) == own).count() > 1;
        let own = if alike { format!("{own}_{}", number + 1) } else { own };
        Self { name: format!("{name}.{own}"), file: format!("{name}_{own}"), layer }
    }
}
