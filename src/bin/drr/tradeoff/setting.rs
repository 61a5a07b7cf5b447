//! What is measured: methods, and what else changes time or error.

use drr::engine::Backend;
use drr::planner::candidates;
use drr::{Accumulation, Algorithm, Energies, Method, Storage};

use crate::charts::Group;

/// Bounds of the error of few energies, HU.
const FEW: [f64; 3] = [1.0, 0.1, 0.01];

/// Rays per side of a pixel.
const SUPERSAMPLING: [usize; 2] = [2, 3];

/// One way to compute the scene.
#[derive(Debug, Clone)]
pub(super) struct Setting {
    pub(super) name: String,
    pub(super) method: Method,
    pub(super) supersampling: usize,
    pub(super) early_exit: bool,
}

impl Setting {
    /// Everything that an engine has.
    pub(super) fn all(engine: Backend) -> Vec<Self> {
        let joseph = Method::from(Algorithm::Joseph);
        let mut all: Vec<_> = candidates(Energies::All).into_iter().map(Self::of).collect();
        all.push(Self::of(Algorithm::Siddon.into()));
        all.extend(FEW.map(|hu| Self::of(Method { energies: Energies::Few { hu }, ..joseph })));
        if engine == Backend::Cpu {
            all.push(Self::of(Algorithm::DistanceDriven.into()));
            for accumulation in [Accumulation::Naive, Accumulation::Compensated] {
                all.push(Self::of(Method { accumulation, ..joseph }));
            }
            all.push(Self::of(Method { storage: Storage::Byte, ..joseph }));
        }
        for supersampling in SUPERSAMPLING {
            let name = format!("joseph, {supersampling}×{supersampling} rays");
            all.push(Self { name, supersampling, ..Self::of(joseph) });
        }
        all.push(Self { name: "joseph, early exit".into(), early_exit: true, ..Self::of(joseph) });
        all
    }

    pub(super) fn of(method: Method) -> Self {
        Self { name: method.to_string(), method, supersampling: 1, early_exit: false }
    }

    /// Whether it computes something else than the others: voxels of constant value, or a mean over a pixel.
    pub(super) fn is_of_another_model(&self) -> bool {
        matches!(self.method.algorithm, Algorithm::Siddon | Algorithm::DistanceDriven)
            || self.supersampling > 1
    }

    /// Whether a planner may choose it.
    pub(super) fn is_candidate(&self) -> bool {
        !self.is_of_another_model()
            && !self.early_exit
            && self.method.accumulation == Accumulation::Blocked
            && self.method.storage == Storage::Exact
    }

    pub(super) fn group(&self) -> Group {
        match self.method.algorithm {
            Algorithm::Joseph if self.is_candidate() && self.method.storage == Storage::Exact => {
                Group::Joseph
            }
            Algorithm::March { .. } => Group::March,
            Algorithm::Siddon => Group::Siddon,
            _ => Group::Other,
        }
    }
}
