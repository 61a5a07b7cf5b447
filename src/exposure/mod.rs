//! An exposure: the areal densities along the rays of some views, kept. Spectrum, detector, blur, scatter and noise make images
//! of it without another march.

mod channels;
mod development;
mod implants;
mod march;
mod passed;
mod ray_caster;
mod rays;
mod rows;
mod shot;
mod signals;
mod source;
mod sums;
mod times;

pub(crate) use channels::known_efficiency;
pub(crate) use march::March;
pub(crate) use ray_caster::RayCaster;
pub(crate) use rays::{from_point, pose_of};
pub(crate) use shot::{beamline, penumbra};
pub(crate) use source::Source;
pub use times::StageTimes;

use serde::Serialize;

use crate::context::Context;
use crate::effects::FocalSpot;
use crate::engine::{Images, Layers};
use crate::error::{Error, Result};
use crate::scene::Scene;
use development::Development;
use shot::Shot;

/// A number that images are made of: float32, or float64 where a twin shows what float32 costs.
pub trait Sample: Copy + Default + Into<f64> + Send + Sync + 'static {
    /// Whether sums over energies are float64 too.
    const EXACT: bool;
    /// The nearest such number.
    fn of(value: f64) -> Self;
}

impl Sample for f32 {
    const EXACT: bool = false;
    fn of(value: f64) -> Self {
        value as f32
    }
}

impl Sample for f64 {
    const EXACT: bool = true;
    fn of(value: f64) -> Self {
        value
    }
}

/// How a focal spot is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Focus {
    /// As a point: there is none, or it cannot be seen.
    Point,
    /// From points all over it, close enough that neighbours are at most half a pixel apart on the detector.
    Points,
    /// By one convolution, right at the depth of the volume's centre.
    Convolved,
}

/// What the rays of some views met: areal densities and, where the scene has bone, its path, ray by ray. It can be developed
/// any number of times, with other spectra, detectors and effects after the march. May be used from many threads at once.
pub struct Exposure<T> {
    context: Context,
    /// What the rays were cast for.
    scene: Scene,
    focus: Focus,
    shots: Vec<Shot<T>>,
}

impl<T: Sample> Exposure<T> {
    /// The views' number.
    pub fn views(&self) -> usize {
        self.shots.len()
    }

    /// Images as `scene` says, which may have another spectrum, other detector layers and other effects after the march than
    /// the exposure's; with what the stages took.
    ///
    /// # Errors
    /// `InvalidArgument`, with the field's name, where `scene` asks for other rays or other matter: detector size,
    /// supersampling, materials, bone, focal spot, implants; for a layer that it does not have; for an effect that needs to
    /// know where the detector is in a view given by a matrix. `OutOfMemory`.
    pub fn develop(&self, scene: &Scene, layers: Layers) -> Result<(Images<T>, StageTimes)> {
        scene.validate()?;
        self.check_rays(scene)?;
        scene.check_layers(layers)?;
        if self.focus == Focus::Convolved && !scene.effects.is_even_source() {
            let valid =
                "none of them in an exposure whose focal spot is one convolution, which would blur them too";
            return Err(Error::invalid("scene.effects' fall-off, heel or filters", "asked for", valid));
        }
        self.developed(scene, layers)
    }

    /// As [`Exposure::develop`], of a scene that is known to fit.
    pub(crate) fn developed(&self, scene: &Scene, layers: Layers) -> Result<(Images<T>, StageTimes)> {
        self.context.install(|| Development::new(scene, layers).images(self))
    }

    /// What decided the rays and what they met must be the same.
    fn check_rays(&self, scene: &Scene) -> Result<()> {
        let own = &self.scene;
        let bone = |bone: Option<u8>| bone.map_or("none".to_owned(), |label| label.to_string());
        let spot = |spot: &FocalSpot| format!("{} × {} mm", spot.width_mm, spot.height_mm);
        let spot = own.effects.focal_spot.as_ref().map_or("a point".to_owned(), spot);
        let fields: [(&str, bool, String); 7] = [
            ("scene.detector_width", own.detector[0] == scene.detector[0], own.detector[0].to_string()),
            ("scene.detector_height", own.detector[1] == scene.detector[1], own.detector[1].to_string()),
            ("scene.supersampling", own.supersampling == scene.supersampling, own.supersampling.to_string()),
            (
                "scene.materials",
                own.materials.names() == scene.materials.names(),
                own.materials.names().join(", "),
            ),
            ("scene.bone_material", own.bone == scene.bone, bone(own.bone)),
            ("scene.effects.focal_spot", own.effects.focal_spot == scene.effects.focal_spot, spot),
            (
                "scene.effects.implants",
                own.effects.implants == scene.effects.implants,
                format!("the {} implants", own.effects.implants.len()),
            ),
        ];
        match fields.into_iter().find(|(_, same, _)| !same) {
            Some((name, _, valid)) => {
                let valid = format!("{valid}, as in the exposure, whose rays have been cast");
                Err(Error::invalid(name, "another", valid))
            }
            None => Ok(()),
        }
    }
}
