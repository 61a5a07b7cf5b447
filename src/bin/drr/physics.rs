//! The physics: spectrum, detector, materials, and what HU mean.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use drr::MAX_DETECTOR_LAYERS;
use drr::formats::{Column, Table, read_detector, read_materials, read_spectrum};
use drr::physics::{Calibration, DetectorResponse, EnergyGrid, MassAttenuation, Spectrum, Thresholds};
use drr::volume::Classification;

use crate::value;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Physics")]
pub(crate) struct PhysicsArguments {
    #[arg(long, value_name = "NAME|FILE.csv", default_value = Spectrum::DEFAULT, help = spectrum_help())]
    spectrum: String,
    /// All photons at one energy, keV
    #[arg(long, value_name = "KEV", value_parser = value::positive, allow_negative_numbers = true, conflicts_with = "spectrum")]
    mono: Option<f64>,
    /// Signal per photon: ideal (every photon counts 1), a layer of the built-in panel (transmission, top_counting,
    /// bottom_counting, top_energy, bottom_energy), or a CSV file "energy_keV,factor"
    ///
    /// Ideal is the default: which detector would be used is not known, and the factors of the built-in panel are those
    /// of one kind of panel.
    ///
    /// Two, with a comma between them, are a dual-layer detector: both images of one march.
    #[arg(long, value_name = "NAME|FILE.csv", default_value = "ideal", value_delimiter = ',')]
    detector: Vec<String>,
    /// Mass attenuation coefficients in cm²/g, a CSV file "energy_keV,name0,name1,...": column n is for label n
    ///
    /// [default: built-in coefficients of the materials that --thresholds names]. The energies must be those of the
    /// spectrum. Built-in coefficients exist at whole keV from 15 to 150.
    #[arg(long, value_name = "FILE.csv")]
    materials: Option<PathBuf>,
    /// HU to density, g/cm³; HU above 3071 count as 3071, below -1024 is vacuum
    #[arg(long, value_name = "NAME", default_value = Calibration::DEFAULT)]
    #[arg(value_parser = PossibleValuesParser::new(Calibration::names()))]
    calibration: String,
    /// HU to material, where no label is given; the default has air, lung, soft tissue, and bone from 200 HU
    #[arg(long, value_name = "NAME", default_value = Thresholds::DEFAULT)]
    #[arg(value_parser = PossibleValuesParser::new(Thresholds::names()))]
    thresholds: String,
}

impl Default for PhysicsArguments {
    fn default() -> Self {
        Self {
            spectrum: Spectrum::DEFAULT.into(),
            mono: None,
            detector: vec!["ideal".into()],
            materials: None,
            calibration: Calibration::DEFAULT.into(),
            thresholds: Thresholds::DEFAULT.into(),
        }
    }
}

/// Everything that is not geometry.
#[derive(Debug, Clone)]
pub(crate) struct Physics {
    /// As it leaves the tube.
    pub(crate) spectrum: Spectrum,
    /// None: an ideal one.
    pub(crate) detector_layers: Vec<DetectorResponse>,
    pub(crate) materials: MassAttenuation,
    pub(crate) classification: Classification,
    /// The first material whose name has "bone" in it; otherwise label 3, which is bone in the specification's order.
    pub(crate) bone: Option<u8>,
}

impl PhysicsArguments {
    /// Number of detector layers.
    pub(crate) fn layers(&self) -> usize {
        self.detector.len()
    }

    pub(crate) fn physics(&self) -> Result<Physics> {
        let classification = Classification {
            calibration: Calibration::named(&self.calibration).context("--calibration")?,
            thresholds: Thresholds::named(&self.thresholds).context("--thresholds")?,
        };
        let own = self.materials.as_deref().map(own_materials).transpose()?;
        let spectrum = self.source(own.as_ref())?;
        let detector_layers = self.detector_layers(*spectrum.grid())?;
        for response in &detector_layers {
            spectrum.folded(response).context("--detector")?;
        }
        let materials = match own {
            Some(materials) => materials,
            None => built_in(&classification.thresholds, *spectrum.grid())?,
        };
        let named = materials.names().iter().position(|name| name.to_lowercase().contains("bone"));
        let bone = named.or((materials.names().len() > 3).then_some(3)).map(|label| label as u8);
        Ok(Physics { spectrum, detector_layers, materials, classification, bone })
    }

    /// The photons that leave the tube.
    fn source(&self, own: Option<&MassAttenuation>) -> Result<Spectrum> {
        let grid = own.map(MassAttenuation::grid);
        if let Some(kev) = self.mono {
            return match grid {
                None => Spectrum::monoenergetic(kev).context("--mono"),
                Some(grid) => one_energy(kev, *grid),
            };
        }
        if is_file(&self.spectrum) {
            let table = read_spectrum(Path::new(&self.spectrum)).context("--spectrum")?;
            let (grid, column) = only_column(table)?;
            return Spectrum::new(file_stem(&self.spectrum), grid, column.values).context("--spectrum");
        }
        let spectrum = Spectrum::named(&self.spectrum, grid.copied().unwrap_or(EnergyGrid::SPECIFICATION));
        if own.is_some() {
            return spectrum.context("the built-in --spectrum does not have the energies of --materials");
        }
        spectrum.context("--spectrum")
    }

    fn detector_layers(&self, grid: EnergyGrid) -> Result<Vec<DetectorResponse>> {
        match self.detector.as_slice() {
            [only] if only == "ideal" => Ok(Vec::new()),
            layers if layers.len() > MAX_DETECTOR_LAYERS => {
                bail!("--detector has {} names; valid: 1 or {MAX_DETECTOR_LAYERS}", layers.len())
            }
            layers => layers.iter().map(|name| response(name, grid)).collect(),
        }
    }
}

/// A detector layer by its built-in name or its file.
fn response(name: &str, grid: EnergyGrid) -> Result<DetectorResponse> {
    if !is_file(name) {
        return DetectorResponse::named(name, grid).context("--detector");
    }
    let table = read_detector(Path::new(name)).context("--detector")?;
    let (grid, column) = only_column(table)?;
    DetectorResponse::new(file_stem(name), grid, column.values).context("--detector")
}

/// All photons at one of the energies of `grid`.
fn one_energy(kev: f64, grid: EnergyGrid) -> Result<Spectrum> {
    let Some(index) = grid.index_of(kev) else {
        bail!("--mono is {kev}; valid: an energy of --materials, which has {grid}");
    };
    let mut weights = vec![0.0; grid.count()];
    weights[index] = 1.0;
    Spectrum::new(format!("{kev} keV"), grid, weights).context("--mono")
}

fn built_in(thresholds: &Thresholds, grid: EnergyGrid) -> Result<MassAttenuation> {
    let names: Vec<_> = thresholds.materials().iter().map(String::as_str).collect();
    MassAttenuation::named(&names, grid)
        .context("built-in materials do not have these energies; --materials gives others")
}

fn own_materials(path: &Path) -> Result<MassAttenuation> {
    let table = read_materials(path).context("--materials")?;
    let names: Vec<String> = table.columns.iter().map(|column| column.name.clone()).collect();
    for (m, name) in names.iter().enumerate() {
        if names[..m].iter().any(|other| file_name(other) == file_name(name)) {
            bail!(
                "--materials: column \"{name}\" would share its file name {} with another",
                file_name(name)
            );
        }
    }
    let values = table.columns.into_iter().flat_map(|column| column.values).collect();
    MassAttenuation::new(table.energies, names, values).context("--materials")
}

fn only_column(table: Table) -> Result<(EnergyGrid, Column)> {
    let grid = table.energies;
    table.columns.into_iter().next().map(|column| (grid, column)).context("the table has no column")
}

/// A material's name as part of a file's: its own may hold anything.
pub(crate) fn file_name(material: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
    material.chars().map(plain).collect()
}

fn spectrum_help() -> String {
    format!(
        "Photons per energy: a built-in tube ({}) or a CSV file \"energy_keV,weight\" with energies at equal steps",
        Spectrum::names().join(", ")
    )
}

fn is_file(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"))
}

fn file_stem(name: &str) -> String {
    Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}
