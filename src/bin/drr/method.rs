//! How line integrals are taken, and on what.

use std::path::PathBuf;

use anyhow::{Context as _, Result, bail};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use drr::engine::{Backend, DeviceChoice};
use drr::planner::Costs;
use drr::{Accumulation, Algorithm, Context, Energies, Error, Method, Storage, Tolerance};

use crate::algorithm::AlgorithmName;
use crate::value;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArguments {
    /// How line integrals are taken; distance_driven with --engine cpu or reference, exact with --engine reference
    #[arg(long, value_enum, default_value = "joseph")]
    algorithm: AlgorithmName,
    /// Step of the march in voxels along the driving axis, 1/64 to 8 [default: 0.5]
    #[arg(long, value_name = "VOXELS", value_parser = value::step, allow_negative_numbers = true)]
    step: Option<f64>,
    /// Sum only as many energies as keep the line integral within HU, a bound that is computed
    #[arg(long, value_name = "HU", value_parser = value::few_energies, allow_negative_numbers = true)]
    few_energies: Option<f64>,
    /// How the samples along a ray are added
    #[arg(long, value_enum, default_value = "blocked")]
    sums: Sums,
    /// How the engine holds voxels
    #[arg(long, value_enum, default_value = "exact")]
    storage: StorageName,
    /// The error that is allowed, in words: the cheapest method that keeps it is chosen
    #[arg(long, value_name = "NAME", conflicts_with_all = METHOD, value_parser = preset_names())]
    preset: Option<String>,
    /// The error that is allowed, HU-equivalents RMSE of the line integral: the cheapest method that keeps it is chosen
    #[arg(long, value_name = "HU", value_parser = value::tolerance, allow_negative_numbers = true)]
    #[arg(conflicts_with_all = METHOD, conflicts_with = "preset")]
    tolerance_hu: Option<f64>,
    /// And the displacement of edges that is allowed, mm RMSE near the volume's centre
    #[arg(long, value_name = "MM", value_parser = value::positive, allow_negative_numbers = true)]
    #[arg(requires = "tolerance_hu")]
    tolerance_mm: Option<f64>,
    /// What methods cost on this machine, as drr tradeoff --write-timings writes it [default: built-in rates]
    #[arg(long, value_name = "FILE")]
    timings: Option<PathBuf>,
    /// NxN rays per pixel, whose intensities are averaged, 1 to 16
    #[arg(long, value_name = "N", value_parser = value::supersampling, default_value = "1")]
    pub(crate) supersample: usize,
    /// Where it runs
    #[arg(long, value_enum, default_value = "cpu")]
    engine: EngineName,
    /// Which of the GPUs that --engine has, counted from 0
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value = "0")]
    device: usize,
    /// Threads; 0 is one per core
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value = "0")]
    threads: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum EngineName {
    /// float32 on all cores
    Cpu,
    /// float64, the truth, slow
    Reference,
    /// The GPU kernels' text, compiled by this machine's C++ compiler
    Host,
    /// float32 on an NVIDIA GPU
    Cuda,
    /// float32 on an Apple GPU
    Metal,
}

/// Arguments that say what a tolerance chooses.
const METHOD: [&str; 5] = ["algorithm", "step", "few_energies", "sums", "storage"];

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Sums {
    /// One float32 sum from end to end
    Naive,
    /// float32 sums of 64 slices, added in float64
    Blocked,
    /// One float32 sum that carries its rounding along
    Compensated,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum StorageName {
    /// Without loss
    Exact,
    /// One byte per voxel: 256 densities, chosen for the volume
    Byte,
}

impl Default for MethodArguments {
    fn default() -> Self {
        Self {
            algorithm: AlgorithmName::Joseph,
            step: None,
            few_energies: None,
            sums: Sums::Blocked,
            storage: StorageName::Exact,
            preset: None,
            tolerance_hu: None,
            tolerance_mm: None,
            timings: None,
            supersample: 1,
            engine: EngineName::Cpu,
            device: 0,
            threads: 0,
        }
    }
}

fn preset_names() -> PossibleValuesParser {
    PossibleValuesParser::new(Tolerance::PRESETS.map(|(name, _)| name))
}

impl MethodArguments {
    /// How a scene is computed where no tolerance is stated.
    pub(crate) fn method(&self) -> Result<Method> {
        let energies = self.few_energies.map_or(Energies::All, |hu| Energies::Few { hu });
        let accumulation = match self.sums {
            Sums::Naive => Accumulation::Naive,
            Sums::Blocked => Accumulation::Blocked,
            Sums::Compensated => Accumulation::Compensated,
        };
        let storage = match self.storage {
            StorageName::Exact => Storage::Exact,
            StorageName::Byte => Storage::Byte,
        };
        Ok(Method { algorithm: self.algorithm()?, energies, accumulation, storage })
    }

    /// The error that is allowed, if one is stated.
    pub(crate) fn tolerance(&self) -> Option<Tolerance> {
        let preset = self.preset.as_ref().and_then(|name| Tolerance::preset(name).ok());
        let stated = |hu| Tolerance { hu, mm: self.tolerance_mm.unwrap_or(f64::INFINITY) };
        preset.or(self.tolerance_hu.map(stated))
    }

    fn algorithm(&self) -> Result<Algorithm> {
        let algorithm = self.algorithm.algorithm(self.step)?;
        if algorithm == Algorithm::Exact && self.engine != EngineName::Reference {
            let own = if self.engine == EngineName::Cpu { ", distance_driven" } else { "" };
            bail!(
                "--algorithm is exact; valid with --engine {}: joseph, march, siddon{own}",
                self.engine.backend().name()
            );
        }
        Ok(algorithm)
    }

    pub(crate) fn context(&self) -> Result<Context> {
        let (backend, choice) = (self.engine.backend(), DeviceChoice::index(self.device));
        let context = Context::on_device(backend, self.threads, choice).map_err(|error| {
            let argument = match &error {
                Error::InvalidArgument { argument, .. } if argument == "device_index" => "--device",
                Error::InvalidArgument { .. } => "--threads",
                _ => "--engine",
            };
            anyhow::Error::new(error).context(argument)
        })?;
        let Some(path) = &self.timings else { return Ok(context) };
        let text = std::fs::read_to_string(path);
        let text = text.with_context(|| format!("--timings {}", path.display()))?;
        Ok(context
            .with_costs(Costs::from_json(&text).with_context(|| format!("--timings {}", path.display()))?))
    }
}

impl EngineName {
    pub(crate) fn backend(self) -> Backend {
        match self {
            Self::Cpu => Backend::Cpu,
            Self::Reference => Backend::Reference,
            Self::Host => Backend::Host,
            Self::Cuda => Backend::Cuda,
            Self::Metal => Backend::Metal,
        }
    }
}
