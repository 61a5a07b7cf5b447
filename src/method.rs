//! How a scene is computed: what can be traded between time and error.

use serde::Serialize;

use crate::error::{Error, Result};

/// Smallest and largest march step, voxels along the driving axis.
pub const STEP_RANGE: [f64; 2] = [1.0 / 64.0, 8.0];

/// Smallest and largest bound of the error of few energies, HU: below, float64's own rounding would be part of it.
pub const FEW_ENERGIES_RANGE: [f64; 2] = [1e-6, 100.0];

/// How the line integral through the voxels is taken.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Algorithm {
    /// One bilinear sample per slice of the driving axis (Joseph, IEEE TMI 1(3), 192, 1982).
    Joseph,
    /// Trilinear samples at equal steps, given in voxels along the driving axis.
    March {
        /// Step, voxels; see [`STEP_RANGE`].
        step: f64,
    },
    /// Exact lengths through voxels of constant value (Siddon, Med Phys 12(2), 252, 1985).
    Siddon,
    /// Mean of the voxels of each slice of the driving axis that the pixel covers, mapped along its rays: exact for voxels of
    /// constant value and a pixel whose sides lie along theirs (De Man and Basu, Phys Med Biol 49, 2463, 2004). What of
    /// it is beyond the volume counts for the outermost voxels. Engines `reference` and `cpu` only.
    DistanceDriven,
    /// The interpolated field integrated exactly, cell by cell. Reference engine only.
    Exact,
}

impl Algorithm {
    /// Checks the parameters' ranges.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::March { step } if !(STEP_RANGE[0]..=STEP_RANGE[1]).contains(&step) => {
                let valid = format!("{} … {} voxels", STEP_RANGE[0], STEP_RANGE[1]);
                Err(Error::invalid("scene.step_voxels", step, valid))
            }
            _ => Ok(()),
        }
    }

    /// The name on command lines and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Joseph => "joseph",
            Self::March { .. } => "march",
            Self::Siddon => "siddon",
            Self::DistanceDriven => "distance_driven",
            Self::Exact => "exact",
        }
    }
}

/// The algorithm with its parameters, in words.
impl std::fmt::Display for Algorithm {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::March { step } => write!(f, "march, step {step} voxels"),
            other => f.write_str(other.name()),
        }
    }
}

/// The energies that are summed once per ray.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Energies {
    /// Every bin of the spectrum that has weight.
    All,
    /// As few of them, with other weights, as keep the line integral within a bound that is computed, not sampled.
    Few {
        /// Largest error of p in HU-equivalents, 1000 Δp/max(p, floor); see [`FEW_ENERGIES_RANGE`].
        hu: f64,
    },
}

/// How the samples along a ray are added.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Accumulation {
    /// One float32 sum from end to end: its error grows with the number of samples. Engine `cpu` only.
    Naive,
    /// float32 sums of 64 slices, added in float64.
    Blocked,
    /// One float32 sum with every addition's rounding carried along (Kahan, CACM 8(1), 40, 1965). Engine `cpu` only.
    Compensated,
}

/// How an engine holds voxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Storage {
    /// As the volume does, without loss: two bytes where HU are integers.
    Exact,
    /// One byte: 256 densities, chosen for the volume. Engine `cpu` only, and only volumes of integer HU.
    Byte,
}

/// How a scene is computed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Method {
    /// How line integrals are taken.
    pub algorithm: Algorithm,
    /// The energies of the sum.
    pub energies: Energies,
    /// How samples are added.
    pub accumulation: Accumulation,
    /// How voxels are held.
    pub storage: Storage,
}

impl From<Algorithm> for Method {
    /// The algorithm, and nothing else given up.
    fn from(algorithm: Algorithm) -> Self {
        let (accumulation, storage) = (Accumulation::Blocked, Storage::Exact);
        Self { algorithm, energies: Energies::All, accumulation, storage }
    }
}

/// The method in words; what is usual is left out.
impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.algorithm)?;
        if let Energies::Few { hu } = self.energies {
            write!(f, ", few energies ({hu} HU)")?;
        }
        match self.accumulation {
            Accumulation::Naive => f.write_str(", naive sums")?,
            Accumulation::Compensated => f.write_str(", compensated sums")?,
            Accumulation::Blocked => {}
        }
        if self.storage == Storage::Byte { f.write_str(", 8-bit voxels") } else { Ok(()) }
    }
}

impl Method {
    /// Checks the parameters' ranges.
    pub fn validate(self) -> Result<()> {
        self.algorithm.validate()?;
        match self.energies {
            Energies::Few { hu } if !(FEW_ENERGIES_RANGE[0]..=FEW_ENERGIES_RANGE[1]).contains(&hu) => {
                let [least, most] = FEW_ENERGIES_RANGE;
                Err(Error::invalid("scene.few_energies_hu", hu, format!("{least:e} … {most} HU")))
            }
            _ => Ok(()),
        }
    }
}
