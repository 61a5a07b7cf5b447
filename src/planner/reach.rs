//! What areal densities rays of a volume reach.

use std::sync::Arc;

use crate::accuracy::{FLOOR, Sample};
use crate::context::Context;
use crate::engine::{Images, Layers, SILENT};
use crate::error::Result;
use crate::method::{Algorithm, Energies};
use crate::physics::Quadrature;
use crate::projector::Projector;
use crate::scene::Scene;
use crate::volume::Volume;

/// How much more matter rays may meet than those that were cast to find out.
const BETWEEN_RAYS: f64 = 1.25;

/// How much matter rays of a volume meet: up to there few energies are to stand for all. Rays beyond are summed over all
/// energies, so that a reach that is too small costs time, one that is too large a few energies more, and neither the
/// bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// The largest areal density of each material, g/cm².
    pub areal_density: Vec<f64>,
    /// The largest line integral.
    pub line_integral: f64,
}

impl Reach {
    /// Of rays like those of some images, which have line integrals and areal densities, and somewhat beyond.
    pub(super) fn of<T: Copy + Default + Into<f64>>(images: &Images<T>) -> Self {
        let largest = |values: &[T]| {
            let finite = values.iter().map(|&value| value.into()).filter(|value| value.is_finite());
            finite.fold(0.0, f64::max)
        };
        let most = |material| {
            let views = 0..images.views;
            views.map(|view| largest(images.areal_density(view, material))).fold(0.0, f64::max)
        };
        let areal_density = (0..images.materials).map(|material| BETWEEN_RAYS * most(material)).collect();
        Self { areal_density, line_integral: largest(&images.line_integral) }
    }

    /// Of rays like those of a sample, cast with Joseph's rule on the engine `cpu`.
    pub(super) fn of_rays(
        context: &Context,
        volume: &Arc<Volume>,
        scene: &Scene,
        sample: &Sample,
    ) -> Result<Self> {
        let scene = scene.with_method(Algorithm::Joseph.into());
        let scene = Scene { detector: sample.size(), supersampling: 1, bone: None, ..scene };
        let projector = Projector::new(&context.on_cpu(), volume.clone(), scene)?;
        let layers = Layers { line_integral: true, areal_density: true, ..Layers::default() };
        Ok(Self::of(&projector.project(&sample.views([0.0; 2]), layers, SILENT)?))
    }

    /// The few energies that a scene's method asks for. `None` when it asks for all, or there are none.
    pub(crate) fn quadrature(&self, scene: &Scene) -> Result<Option<Quadrature>> {
        let Energies::Few { hu } = scene.method.energies else { return Ok(None) };
        let model = scene.spectral_model()?;
        Ok(Quadrature::new(&model, &self.areal_density, FLOOR * self.line_integral, 1e-3 * hu))
    }
}
