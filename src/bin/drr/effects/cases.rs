//! The effects, one after the other as a photon meets them, with typical parameters.

use anyhow::Result;
use drr::effects::{
    DetectorBlur, Effects, FillFactor, Filter, FocalSpot, Heel, Implant, ImplantShape, Noise, Profile,
    Scatter,
};
use drr::engine::SILENT;
use drr::physics::{DetectorResponse, Material, Spectrum};
use drr::{Focus, Scene, Tolerance};
use glam::DVec3;

use super::Study;
use super::case::{Beside, Case, Run};

/// A common small focal spot: IEC 60336's 0.6, taken as its nominal value.
const SPOT: FocalSpot = FocalSpot { width_mm: 0.6, height_mm: 0.6 };
/// Photons of the source per pixel.
const PHOTONS: f64 = 20_000.0;
const ELECTRONIC: f64 = 20.0;
/// The part of a tolerance whose root mean square a focal spot must nearly miss as a point, so that it is convolved.
const NEARLY: f64 = 0.99;

/// What cannot be measured here, and why.
pub(super) type LeftOut = (&'static str, String);

/// Every case that there is for the study's scene.
pub(super) fn all(study: &Study<'_>) -> Result<(Vec<Case>, Vec<LeftOut>)> {
    let mut cases = Cases { study, all: Vec::new(), left_out: Vec::new() };
    cases.add("plain", "attenuation by the CT alone".into(), Beside::Nothing, study.scene.clone())?;
    cases.source();
    cases.object();
    cases.focal_spot();
    cases.scatter();
    cases.detector();
    cases.noise();
    cases.everything();
    cases.again();
    Ok((cases.all, cases.left_out))
}

struct Cases<'a> {
    study: &'a Study<'a>,
    all: Vec<Case>,
    left_out: Vec<LeftOut>,
}

impl Cases<'_> {
    fn add(&mut self, name: &'static str, what: String, beside: Beside, scene: Scene) -> Result<()> {
        let run = Run::Project(Box::new(self.study.projector(scene)?));
        self.all.push(Case { name, what, beside, run });
        Ok(())
    }

    /// Adds a case beside the plain one, or notes why there is none.
    fn try_add(&mut self, name: &'static str, what: &str, scene: Result<Scene>) {
        let added = scene.and_then(|scene| self.add(name, what.into(), Beside::Plain, scene));
        self.note(name, added);
    }

    fn note(&mut self, name: &'static str, added: Result<()>) {
        if let Err(error) = added {
            self.left_out.push((name, format!("{error:#}")));
        }
    }

    /// The plain scene with effects.
    fn with(&self, change: impl FnOnce(&mut Effects)) -> Scene {
        let mut scene = self.study.scene.clone();
        change(&mut scene.effects);
        scene
    }

    fn filter(&self, material: &str, profile: Profile) -> Result<Filter> {
        Ok(Filter::named(material, *self.study.scene.spectrum.grid(), profile)?)
    }

    fn copper(&self) -> Result<Filter> {
        self.filter("copper", Profile::Flat { mm: 0.1 })
    }

    fn bow_tie(&self) -> Result<Filter> {
        let (degrees, mm) = (vec![-15.0, -8.0, 0.0, 8.0, 15.0], vec![20.0, 8.0, 1.0, 8.0, 20.0]);
        self.filter("aluminium", Profile::BowTie { degrees, mm })
    }

    fn layers(&self, names: &[&str]) -> Result<Vec<DetectorResponse>> {
        let grid = *self.study.scene.spectrum.grid();
        Ok(names.iter().map(|name| DetectorResponse::named(name, grid)).collect::<drr::Result<_>>()?)
    }

    /// A titanium rod across the volume's centre, 80 mm long and 8 mm thick.
    fn implanted(&self, mut scene: Scene) -> Result<Scene> {
        let material = scene.materials.names().len();
        scene.materials = scene.materials.with("titanium")?;
        let (centre, half) = (self.study.volume.grid().centre(), DVec3::new(20.0, 0.0, 35.0));
        let shape = ImplantShape::Rod { ends: [centre - half, centre + half], radius: 4.0 };
        let density = Material::named("titanium")?.reference_density();
        scene.effects.implants.push(Implant { shape, material: material as u8, density });
        Ok(scene)
    }

    fn blur() -> Result<DetectorBlur> {
        Ok(DetectorBlur::gaussians(&[(0.85, 0.25), (0.15, 2.0)])?)
    }

    fn quantum(electronic_photons: f64) -> Noise {
        Noise { photons_per_pixel: PHOTONS, quantum: true, electronic_photons, seed: 0 }
    }

    fn source(&mut self) {
        self.try_add("fall-off", "cos³θ", Ok(self.with(|effects| effects.fall_off = true)));
        let heel = self.with(|effects| effects.heel = Some(Heel::TYPICAL));
        self.try_add("heel", "12°, 5 µm of tungsten", Ok(heel));
        let copper = self.copper().map(|filter| self.with(|effects| effects.filters.push(filter)));
        self.try_add("filter", "0.1 mm copper", copper);
        let bow_tie = self.bow_tie().map(|filter| self.with(|effects| effects.filters.push(filter)));
        self.try_add("bow-tie", "1 to 20 mm aluminium over ±15°", bow_tie);
    }

    fn object(&mut self) {
        let implanted = self.implanted(self.study.scene.clone());
        self.try_add("implant", "a rod of titanium, 81 × 8 mm", implanted);
    }

    fn focal_spot(&mut self) {
        let spot = self.with(|effects| effects.focal_spot = Some(SPOT));
        let points = Scene { tolerance: None, ..spot.clone() };
        let convolved = self.convolved(&spot);
        self.try_add("focal spot, points", "0.6 mm, from points all over it", Ok(points));
        match convolved {
            Ok(Some((plain, spot))) => {
                let tolerance = plain.tolerance.map_or(String::new(), |tolerance| tolerance.to_string());
                let what = format!("0.6 mm, by one convolution; both with a tolerance of {tolerance}");
                let added = self
                    .add("plain, tolerance", String::new(), Beside::Nothing, plain)
                    .and_then(|()| self.add("focal spot, convolved", what, Beside::Previous, spot));
                self.note("focal spot, convolved", added);
            }
            Ok(None) => {
                let why = "no tolerance makes the planner choose one here: what a point source misses, a convolution misses too";
                self.left_out.push(("focal spot, convolved", why.into()));
            }
            Err(error) => self.left_out.push(("focal spot, convolved", format!("{error:#}"))),
        }
    }

    /// Plain and with the spot, with a tolerance that a point source nearly keeps and a convolution does.
    fn convolved(&self, spot: &Scene) -> Result<Option<(Scene, Scene)>> {
        let with = |hu: f64, scene: &Scene| {
            let tolerance = Some(Tolerance { hu, mm: f64::INFINITY });
            Scene { tolerance, method: drr::Algorithm::Joseph.into(), ..scene.clone() }
        };
        let loose = self.study.projector(with(1000.0, spot))?;
        let choice = loose.plan().focus.as_ref();
        let point = choice.and_then(|c| c.errors.iter().find(|(focus, _)| *focus == Focus::Point));
        let point = point.map(|(_, error)| error.filter(|error| error.rms_high > 0.0));
        let Some((error, allowed)) = point.flatten().zip(choice.and_then(|c| c.allowed_hu)) else {
            return Ok(None);
        };
        let hu = NEARLY * error.rms_high * 1000.0 / allowed;
        let scene = with(hu, spot);
        let projector = self.study.projector(scene.clone())?;
        let focus = projector.plan().focus.as_ref().map(|choice| choice.focus);
        Ok((focus == Some(Focus::Convolved)).then(|| (with(hu, &self.study.scene), scene)))
    }

    fn scatter(&mut self) {
        let scene = self.with(|effects| effects.scatter = Some(Scatter::default()));
        self.try_add("scatter", "kernels known", Ok(scene.clone()));
        if self.all.last().is_some_and(|case| case.name == "scatter") {
            let what = "and its kernels, of 40000 photons per thickness".into();
            let run = Run::First(Box::new(scene));
            self.all.push(Case { name: "scatter, first time", what, beside: Beside::Plain, run });
        }
    }

    fn detector(&mut self) {
        let layers = self.layers(&["top_energy", "bottom_energy"]);
        let dual = layers.map(|detector_layers| Scene { detector_layers, ..self.study.scene.clone() });
        self.try_add("dual layer", "both images of one march", dual);
        let blur = Self::blur().map(|blur| self.with(|effects| effects.detector_blur = Some(blur)));
        self.try_add("detector blur", "σ 0.25 mm, and 15 % with 2 mm", blur);
        let fill = FillFactor::new(0.7).map(|fill| self.with(|effects| effects.fill_factor = Some(fill)));
        let fill = fill.map_err(anyhow::Error::from);
        let four = fill.as_ref().ok().map(|scene| Scene { supersampling: 2, ..scene.clone() });
        self.try_add("fill factor", "70 % of the area, one ray", fill);
        if let Some(four) = four {
            self.try_add("fill factor, 2×2 rays", "70 % of the area", Ok(four));
        }
    }

    fn noise(&mut self) {
        let noisy = |noise: Noise| self.with(|effects| effects.noise = Some(noise));
        let counting = noisy(Self::quantum(0.0));
        let electronic = noisy(Noise { quantum: false, ..Self::quantum(ELECTRONIC) });
        let integrating =
            self.layers(&["top_energy"]).map(|detector_layers| Scene { detector_layers, ..counting.clone() });
        self.try_add("noise, counting", "20000 photons per pixel", Ok(counting));
        self.try_add("noise, integrating", "20000 photons per pixel, top_energy", integrating);
        self.try_add("noise, electronic", "σ 20 photons", Ok(electronic));
    }

    fn everything(&mut self) {
        let all = || {
            let effects = Effects {
                fall_off: true,
                heel: Some(Heel::TYPICAL),
                filters: vec![self.copper()?, self.bow_tie()?],
                implants: Vec::new(),
                focal_spot: Some(SPOT),
                scatter: Some(Scatter::default()),
                detector_blur: Some(Self::blur()?),
                fill_factor: Some(FillFactor::new(0.7)?),
                noise: Some(Self::quantum(ELECTRONIC)),
            };
            let detector_layers = self.layers(&["top_energy", "bottom_energy"])?;
            self.implanted(Scene { effects, detector_layers, tolerance: None, ..self.study.scene.clone() })
        };
        self.try_add("everything", "all of them at once, one ray per pixel, kernels known", all());
    }

    /// Another spectrum for rays that have been cast.
    fn again(&mut self) {
        let name = "another spectrum";
        let own = &self.study.scene.spectrum;
        let added = || {
            let other = Spectrum::names().iter().copied().find(|name| *name != own.name());
            let other = Spectrum::named(other.unwrap_or(Spectrum::DEFAULT), *own.grid())?;
            let exposure =
                self.study.projector(self.study.scene.clone())?.expose(&self.study.requests(), SILENT)?;
            let what = format!("{}, developed from the rays of the first", other.name());
            let scene = Box::new(Scene { spectrum: other, ..self.study.scene.clone() });
            let run = Run::Develop(Box::new(exposure), scene);
            Ok(Case { name, what, beside: Beside::Instead, run })
        };
        match added() {
            Ok(case) => self.all.push(case),
            Err(error) => self.note(name, Err(error)),
        }
    }
}
