//! What happens to the X-rays beside attenuation by the CT. Nothing, unless it is asked for.

mod filter;
mod implant;
mod values;

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use clap::Args;
use drr::effects::{
    DetectorBlur, Effects, FillFactor, FocalSpot, Heel, Implant, MAX_EFFECT_PARTS, Noise, Scatter,
};
use drr::formats::read_curve;
use drr::physics::Material;

use crate::console::Console;
use crate::physics::Physics;
use filter::FilterArgument;
use implant::ImplantArgument;

/// A difference from a measured MTF that is worth a warning.
const NOTABLE_MTF_DIFFERENCE: f64 = 0.02;

#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Effects (each off unless given)")]
pub(crate) struct EffectArguments {
    /// Inverse-square and obliquity fall-off of the intensity towards the detector's edges, cos³θ
    #[arg(long)]
    fall_off: bool,
    /// Self-filtration of a tungsten anode: its angle in degrees, how deep photons are born in µm, and where the
    /// cathode is, degrees from the columns' direction towards the rows' [without values: 12,5,0]
    #[arg(long, value_name = "ANGLE[,DEPTH[,CATHODE]]", num_args = 0..=1, default_missing_value = "12")]
    #[arg(value_parser = values::heel, allow_negative_numbers = true)]
    heel: Option<Heel>,
    /// A slab of a built-in material between source and patient, mm; may be repeated
    #[arg(long, value_name = "MATERIAL:MM", value_parser = filter::flat)]
    filter: Vec<FilterArgument>,
    /// A bow-tie filter, extruded across the columns: a CSV file "degrees,mm" of fan angle and thickness; may be
    /// repeated
    #[arg(long, value_name = "MATERIAL:FILE.csv", value_parser = filter::bow_tie)]
    bow_tie: Vec<FilterArgument>,
    /// A solid instead of the CT where it is, world mm; may be repeated, the last one counts where several are
    ///
    /// rod:MATERIAL:x,y,z:x,y,z:RADIUS (the middles of both ends), sphere:MATERIAL:x,y,z:RADIUS,
    /// box:MATERIAL:x,y,z:HX,HY,HZ (half sides), screw:MATERIAL:x,y,z:DX,DY,DZ:LENGTH/RADIUS,LENGTH/RADIUS,... (where
    /// the axis leaves the head, its direction, cylinders from the head on). MATERIAL is a built-in one, with its usual
    /// density, or MATERIAL@DENSITY in g/cm³.
    #[arg(long, value_name = "SHAPE:MATERIAL:...", value_parser = implant::implant, allow_hyphen_values = true)]
    implant: Vec<ImplantArgument>,
    /// The source's extent along the detector's columns and rows, mm
    #[arg(long, value_name = "MM|WxH", value_parser = values::focal_spot, allow_negative_numbers = true)]
    focal_spot: Option<FocalSpot>,
    /// Scattered radiation, by kernels of water made of so many photons [without a value: 40000]
    #[arg(long, value_name = "PHOTONS", num_args = 0..=1, default_missing_value = "40000")]
    #[arg(value_parser = values::scatter, allow_negative_numbers = true)]
    scatter: Option<Scatter>,
    /// The spread of the signal in the detector: the standard deviation of a Gaussian, mm, or WEIGHT:SIGMA of several
    #[arg(long, value_name = "MM|W:MM,W:MM,...", value_parser = values::blur, allow_negative_numbers = true)]
    #[arg(conflicts_with = "mtf")]
    blur: Option<DetectorBlur>,
    /// The same by a measured MTF, a CSV file "per_mm,mtf": line pairs per mm, ascending, and the MTF from 0 to 1
    #[arg(long, value_name = "FILE.csv")]
    mtf: Option<PathBuf>,
    /// The active part of a pixel's area, 0.01 to 1; sampled by the rays of --supersample
    #[arg(long, value_name = "PART", value_parser = values::fill_factor, allow_negative_numbers = true)]
    fill_factor: Option<FillFactor>,
    /// Quantum noise: photons of the source that reach the central pixel where nothing is in the way
    #[arg(long, value_name = "N", value_parser = crate::value::positive, allow_negative_numbers = true)]
    photons: Option<f64>,
    /// Electronic noise beside it: its standard deviation in photons of mean signal
    #[arg(long, value_name = "PHOTONS", value_parser = values::not_negative, allow_negative_numbers = true)]
    electronic_noise: Option<f64>,
    /// Other seeds give other noise [default: 0]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    noise_seed: Option<u64>,
}

impl EffectArguments {
    /// Whether an effect is asked for.
    pub(crate) fn any(&self) -> bool {
        let parts = [self.filter.len(), self.bow_tie.len(), self.implant.len()];
        let given = [self.fall_off, self.heel.is_some(), self.focal_spot.is_some(), self.scatter.is_some()];
        let detector = [self.blur.is_some(), self.mtf.is_some(), self.fill_factor.is_some()];
        let noise = [self.photons.is_some(), self.electronic_noise.is_some()];
        parts.iter().any(|&n| n > 0) || given.into_iter().chain(detector).chain(noise).any(|on| on)
    }

    /// The effects; materials of implants that the physics lacks are added to it.
    pub(crate) fn effects(&self, physics: &mut Physics) -> Result<Effects> {
        let grid = *physics.spectrum.grid();
        for (name, count) in [
            ("--filter and --bow-tie", self.filter.len() + self.bow_tie.len()),
            ("--implant", self.implant.len()),
        ] {
            if count > MAX_EFFECT_PARTS {
                bail!("{name}: {count} are given; valid: at most {MAX_EFFECT_PARTS}");
            }
        }
        let flat = self.filter.iter().map(|filter| filter.filter(grid).context("--filter"));
        let bow_ties = self.bow_tie.iter().map(|filter| filter.filter(grid).context("--bow-tie"));
        Ok(Effects {
            fall_off: self.fall_off,
            heel: self.heel,
            filters: flat.chain(bow_ties).collect::<Result<_>>()?,
            implants: self.implant.iter().map(|i| placed(i, physics)).collect::<Result<_>>()?,
            focal_spot: self.focal_spot,
            scatter: self.scatter,
            detector_blur: self.detector_blur()?,
            fill_factor: self.fill_factor,
            noise: self.noise()?,
        })
    }

    fn detector_blur(&self) -> Result<Option<DetectorBlur>> {
        let Some(path) = &self.mtf else { return Ok(self.blur.clone()) };
        let points = read_curve(path, ["per_mm", "mtf"]).context("--mtf")?;
        let [frequencies, mtf] = [0, 1].map(|axis| points.iter().map(|p| p[axis]).collect::<Vec<_>>());
        let (blur, difference) = DetectorBlur::curve(&frequencies, &mtf).context("--mtf")?;
        if difference > NOTABLE_MTF_DIFFERENCE {
            Console::warn(format_args!(
                "--mtf {}: the nearest mixture of Gaussians is off by up to {difference:.3}",
                path.display()
            ));
        }
        Ok(Some(blur))
    }

    fn noise(&self) -> Result<Option<Noise>> {
        let Some(photons_per_pixel) = self.photons else {
            for (name, given) in [
                ("--electronic-noise", self.electronic_noise.is_some()),
                ("--noise-seed", self.noise_seed.is_some()),
            ] {
                if given {
                    bail!("{name} is given without --photons; valid: with it, because noise needs a dose");
                }
            }
            return Ok(None);
        };
        let electronic_photons = self.electronic_noise.unwrap_or(0.0);
        let seed = self.noise_seed.unwrap_or(0);
        let noise = Noise { photons_per_pixel, quantum: true, electronic_photons, seed };
        noise.validate().context("--photons, --electronic-noise")?;
        Ok(Some(noise))
    }
}

/// An implant of one of the scene's materials, to which its own is added where it is missing.
fn placed(argument: &ImplantArgument, physics: &mut Physics) -> Result<Implant> {
    let name = argument.material.as_str();
    let density = match argument.density {
        Some(density) => density,
        None => Material::named(name).context("--implant")?.reference_density(),
    };
    let names = physics.materials.names();
    let known = names.iter().position(|own| own == name);
    let material = known.unwrap_or(names.len()) as u8;
    if known.is_none() {
        physics.materials = physics.materials.with(name).context("--implant")?;
    }
    let implant = Implant { shape: argument.shape.clone(), material, density };
    implant.validate(physics.materials.names().len(), 0).context("--implant")?;
    Ok(implant)
}

/// The argument that a field of the scene's effects comes from.
pub(crate) fn argument_of(field: &str) -> Option<&'static str> {
    let arguments = [
        ("scene.effects.heel", "--heel"),
        ("scene.effects.filters", "--filter, --bow-tie"),
        ("scene.effects.implants", "--implant"),
        ("scene.effects.focal_spot", "--focal-spot"),
        ("scene.effects.scatter", "--scatter"),
        ("scene.effects.detector_blur", "--blur, --mtf"),
        ("scene.effects.fill_factor", "--fill-factor"),
        ("scene.effects.noise", "--photons, --electronic-noise"),
        ("scene.detector_layers", "--detector"),
    ];
    arguments.into_iter().find(|(prefix, _)| field.contains(prefix)).map(|(_, argument)| argument)
}
