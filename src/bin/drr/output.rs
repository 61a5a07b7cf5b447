//! Files of a projection: one OpenEXR per view, a picture, the plan, raw layers.

use std::path::Path;

use anyhow::{Context as _, Result};
use clap::ValueEnum;
use drr::Projector;
use drr::engine::{Images, Layers};
use drr::formats::{
    ExrImage, radiograph, write_exr, write_png_gray8, write_raw_f32, write_raw_f64, write_text,
};
use drr::physics::Spectrum;
use glam::DVec3;

use crate::inputs::Setup;
use crate::physics::file_name;
use crate::views::Views;

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

/// A projection in the precision of its engine.
pub(crate) enum Rendered {
    Single(Images<f32>),
    Double(Images<f64>),
}

/// Everything that the files say.
pub(crate) struct Output<'a> {
    pub(crate) setup: &'a Setup<'a>,
    pub(crate) projector: &'a Projector,
    pub(crate) views: &'a Views,
    pub(crate) layers: &'a [LayerName],
    pub(crate) rendered: &'a Rendered,
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
    let probe = folder.join(".drr.part");
    std::fs::create_dir_all(folder)
        .and_then(|()| std::fs::write(&probe, []))
        .and_then(|()| std::fs::remove_file(&probe))
        .with_context(|| format!("--output {}", folder.display()))
}

impl Output<'_> {
    /// Writes everything into `folder`, which [`prepare`] has seen.
    pub(crate) fn write(&self, folder: &Path, raw: bool) -> Result<()> {
        let rounded;
        let images = match self.rendered {
            Rendered::Single(images) => images,
            Rendered::Double(images) => {
                rounded = images.map(|&x| x as f32);
                &rounded
            }
        };
        for view in 0..images.views {
            let layers = self.named(images, view).map(|(name, values)| (name.exr, values)).collect();
            let [width, height] = images.size;
            let image = ExrImage { width, height, layers, metadata: self.metadata(view) };
            write_exr(&folder.join(format!("view{view}.exr")), &image)?;
            if raw {
                self.write_raw(folder, view)?;
            }
        }
        self.write_picture(folder, images)?;
        Ok(write_text(&folder.join("plan.json"), &(self.projector.plan().to_json() + "\n"))?)
    }

    fn write_raw(&self, folder: &Path, view: usize) -> Result<()> {
        let path = |name: &str, ending| folder.join(format!("view{view}_{name}.{ending}"));
        match self.rendered {
            Rendered::Single(images) => {
                for (name, values) in self.named(images, view) {
                    write_raw_f32(&path(&name.raw, "f32"), values)?;
                }
            }
            Rendered::Double(images) => {
                for (name, values) in self.named(images, view) {
                    write_raw_f64(&path(&name.raw, "f64"), values)?;
                }
            }
        }
        Ok(())
    }

    /// The layers of a view that were asked for.
    fn named<'a, T: Copy + Default>(
        &'a self,
        images: &'a Images<T>,
        view: usize,
    ) -> impl Iterator<Item = (Name, &'a [T])> {
        let signal = move |name: &'static str, layer: &'a [T]| {
            let detector_layers = 0..images.detector_layers;
            let named = detector_layers
                .map(|l| (self.of_detector_layer(name, l), images.of_detector_layer(layer, view, l)));
            named.collect::<Vec<_>>()
        };
        self.layers.iter().flat_map(move |layer| match layer {
            LayerName::Intensity => signal("intensity", &images.intensity),
            LayerName::LineIntegral => signal("line_integral", &images.line_integral),
            LayerName::BonePath => vec![(Name::of("bone_path"), images.view(&images.bone_path, view))],
            LayerName::ArealDensity => {
                let names = self.projector.scene().materials.names().iter().enumerate();
                names.map(|(m, name)| (Name::of_material(name), images.areal_density(view, m))).collect()
            }
        })
    }

    /// The name of one of a detector's layers: plain where there is one.
    fn of_detector_layer(&self, name: &str, layer: usize) -> Name {
        let scene = self.projector.scene();
        if scene.layers() == 1 {
            return Name::of(name);
        }
        let own = file_name(scene.detector_layers[layer].name());
        let alike = scene.detector_layers.iter().filter(|other| file_name(other.name()) == own).count() > 1;
        let own = if alike { format!("{own}_{}", layer + 1) } else { own };
        Name { exr: format!("{name}.{own}"), raw: format!("{name}_{own}") }
    }

    /// Views, and beside each other the detector's layers of each, as a radiologist expects them: bone bright, head up.
    fn write_picture(&self, folder: &Path, images: &Images<f32>) -> Result<()> {
        let ([width, height], layers) = (images.size, images.detector_layers);
        let shown = (images.views * layers).min(PICTURED);
        let image = |n: usize| images.of_detector_layer(&images.line_integral, n / layers, n % layers);
        let upright: Vec<Vec<f32>> =
            (0..shown).map(|n| self.views.upright(n / layers, image(n), width)).collect();
        let picture = radiograph(&upright.iter().map(Vec::as_slice).collect::<Vec<_>>(), width, height)?;
        let path = folder.join("radiograph.png");
        Ok(write_png_gray8(&path, picture.width, picture.height, &picture.to_gray8())?)
    }

    fn metadata(&self, view: usize) -> Vec<(String, String)> {
        let (scene, pose) = (self.projector.scene(), self.views.poses[view]);
        let physics = &self.setup.physics;
        let mm = |v: DVec3| format!("{} {} {}", v.x, v.y, v.z);
        let layers =
            "intensity: weights of the spectrum; line_integral: 1; areal_density: g/cm\u{b2}; bone_path: mm";
        [
            ("version", format!("drr {}", drr::VERSION)),
            ("view", view.to_string()),
            ("world", "LPS, mm".into()),
            ("source", mm(pose.source)),
            ("first_pixel", mm(pose.first_pixel)),
            ("column_step", mm(pose.column_step)),
            ("row_step", mm(pose.row_step)),
            (
                "pixel",
                "column i, row j: first_pixel + i column_step + j row_step; row 0 is stored first".into(),
            ),
            ("units", layers.into()),
            ("spectrum", self.detected(|spectrum| spectrum.name().into())),
            ("spectrum_energies", scene.spectrum.grid().to_string()),
            ("i0", self.detected(|spectrum| spectrum.total().to_string())),
            ("materials", scene.materials.names().join(", ")),
            ("calibration", physics.classification.calibration.name().into()),
            ("thresholds", physics.classification.thresholds.name().into()),
            ("algorithm", self.projector.plan().method.to_string()),
            ("supersampling", scene.supersampling.to_string()),
            ("effects", self.effects()),
            ("engine", self.setup.context.backend().name().into()),
        ]
        .map(|(name, value): (&str, String)| (format!("drr.{name}"), value))
        .into()
    }

    /// Something of the spectrum that each of the detector's layers sees.
    fn detected(&self, text: impl Fn(&Spectrum) -> String) -> String {
        let scene = self.projector.scene();
        let layers = (0..scene.layers()).filter_map(|layer| scene.detected(layer).ok());
        layers.map(|spectrum| text(&spectrum)).collect::<Vec<_>>().join(", ")
    }

    /// What was simulated beside attenuation.
    fn effects(&self) -> String {
        let stages = self.projector.plan().stages.iter().filter(|stage| stage.is_effect());
        let effects: Vec<_> = stages.map(|stage| format!("{}: {}", stage.name, stage.what)).collect();
        if effects.is_empty() { "none".into() } else { effects.join("; ") }
    }
}

/// What a layer is called.
struct Name {
    /// In OpenEXR, where a dot makes a group.
    exr: String,
    /// In the names of raw files.
    raw: String,
}

impl Name {
    fn of(name: &str) -> Self {
        Self { exr: name.into(), raw: name.into() }
    }

    fn of_material(material: &str) -> Self {
        let raw = format!("areal_density_{}", file_name(material));
        Self { exr: format!("areal_density.{material}"), raw }
    }
}
