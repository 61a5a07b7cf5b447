//! How line integrals are taken, and on what.

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use drr::engine::{Backend, DeviceChoice};
use drr::{Algorithm, Context, Error};

use crate::value;

#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Method")]
pub(crate) struct MethodArguments {
    /// How line integrals are taken
    #[arg(long, value_enum, default_value = "joseph")]
    algorithm: AlgorithmName,
    /// Step of the march in voxels along the driving axis, 1/64 to 8 [default: 0.5]
    #[arg(long, value_name = "VOXELS", value_parser = value::step, allow_negative_numbers = true)]
    step: Option<f64>,
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
enum AlgorithmName {
    /// One bilinear sample per slice of the driving axis
    Joseph,
    /// Trilinear samples at equal steps
    March,
    /// Exact lengths through voxels of constant value
    Siddon,
    /// The interpolated field integrated exactly; with --engine reference
    Exact,
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

impl Default for MethodArguments {
    fn default() -> Self {
        let (algorithm, engine) = (AlgorithmName::Joseph, EngineName::Cpu);
        Self { algorithm, step: None, supersample: 1, engine, device: 0, threads: 0 }
    }
}

impl MethodArguments {
    pub(crate) fn algorithm(&self) -> Result<Algorithm> {
        if self.step.is_some() && self.algorithm != AlgorithmName::March {
            bail!("--step is given; valid: only with --algorithm march");
        }
        Ok(match self.algorithm {
            AlgorithmName::Joseph => Algorithm::Joseph,
            AlgorithmName::March => Algorithm::March { step: self.step.unwrap_or(0.5) },
            AlgorithmName::Siddon => Algorithm::Siddon,
            AlgorithmName::Exact if self.engine != EngineName::Reference => {
                bail!(
                    "--algorithm is exact; valid with --engine {}: joseph, march, siddon",
                    self.engine.backend().name()
                )
            }
            AlgorithmName::Exact => Algorithm::Exact,
        })
    }

    pub(crate) fn context(&self) -> Result<Context> {
        let (backend, choice) = (self.engine.backend(), DeviceChoice::index(self.device));
        Context::on_device(backend, self.threads, choice).map_err(|error| {
            let argument = match &error {
                Error::InvalidArgument { argument, .. } if argument == "device_index" => "--device",
                Error::InvalidArgument { .. } => "--threads",
                _ => "--engine",
            };
            anyhow::Error::new(error).context(argument)
        })
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
