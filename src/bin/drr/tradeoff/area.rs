//! A pixel has an area: how far rays through its centre, or a few of them, are from the mean over it.

use anyhow::Result;
use drr::accuracy::{Estimate, FLOOR, Sample};
use drr::engine::{Layers, SILENT};
use drr::{Algorithm, Projector, Scene};

use super::Study;
use super::setting::Setting;

/// Pixels that are looked at, about.
const PIXELS: usize = 800;
/// Decides which.
const SEED: u64 = 4;
/// Exact rays per side of a pixel that stand for all of it.
const TRUE_SIDE: usize = 6;

/// The right means of some pixels.
pub(super) struct Area {
    sample: Sample,
    line_integral: Vec<f64>,
    i0: f64,
    floor: f64,
}

impl Area {
    pub(super) fn new(study: &Study<'_>) -> Result<Self> {
        let sample = Sample::new(&study.poses(), study.scene.detector, PIXELS, SEED);
        let i0 = study.scene.spectral_model()?.i0();
        let projector = one_ray(study, &sample, &Setting::of(super::joseph()))?;
        let exact = |projector: &Projector, views: &[_]| {
            Ok(projector.reference(Algorithm::Exact, views, INTENSITY, SILENT)?.intensity)
        };
        let line_integral = mean(&sample, TRUE_SIDE, i0, |views| exact(&projector, views))?;
        let floor = FLOOR * line_integral.iter().copied().filter(|p| p.is_finite()).fold(0.0, f64::max);
        Ok(Self { sample, line_integral, i0, floor })
    }

    /// Of settings that differ in what they take of a pixel, against the mean, HU.
    pub(super) fn error(&self, study: &Study<'_>, setting: &Setting) -> Result<Option<Estimate>> {
        let takes_more = setting.method == Algorithm::DistanceDriven.into();
        if !takes_more && setting.method != super::joseph() || setting.early_exit {
            return Ok(None);
        }
        let projector = one_ray(study, &self.sample, setting)?;
        let own = mean(&self.sample, setting.supersampling, self.i0, |views| {
            let images = projector.project(views, INTENSITY, SILENT)?;
            Ok(images.intensity.into_iter().map(f64::from).collect())
        })?;
        let replicates = self.sample.split(&self.line_integral).zip(self.sample.split(&own));
        Ok(Estimate::of(
            replicates.map(|(right, own)| {
                let seen =
                    right.iter().zip(own).filter(|(right, _)| right.is_finite() && **right > self.floor);
                seen.map(|(right, own)| 1000.0 * (own - right) / right)
            }),
            self.sample.part(),
        ))
    }
}

const INTENSITY: Layers =
    Layers { intensity: true, line_integral: false, areal_density: false, bone_path: false };

fn one_ray(study: &Study<'_>, sample: &Sample, setting: &Setting) -> Result<Projector> {
    study.projector(Scene { detector: sample.size(), method: setting.method, ..study.scene.clone() })
}

/// The line integral of the mean intensity of `side` × `side` rays per pixel.
fn mean(
    sample: &Sample,
    side: usize,
    i0: f64,
    cast: impl Fn(&[drr::ViewRequest]) -> Result<Vec<f64>>,
) -> Result<Vec<f64>> {
    let offset = |n: usize| (n as f64 + 0.5) / side as f64 - 0.5;
    let mut sums = vec![0.0; sample.rays()];
    for n in 0..side * side {
        let views = sample.views([offset(n % side), offset(n / side)]);
        sums.iter_mut().zip(cast(&views)?).for_each(|(sum, intensity)| *sum += intensity);
    }
    let rays = (side * side) as f64;
    Ok(sums.into_iter().map(|sum| -(sum / rays / i0).ln()).collect())
}
