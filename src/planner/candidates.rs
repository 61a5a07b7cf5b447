//! The methods among which a planner chooses.

use crate::method::{Algorithm, Energies, Method};

/// Steps of the march that are tried, voxels.
const STEPS: [f64; 8] = [8.0, 4.0, 3.0, 2.0, 1.0, 0.5, 0.25, 0.125];

/// The methods that every engine has for one and the same thing, the integral of the interpolated voxels. Siddon's integral
/// is of another model, voxels of constant value, and is not among them; nor are distance-driven means, which are of the whole
/// pixel, and voxels of one byte, which gain next to nothing (`src/accuracy/README.md`).
pub fn candidates(energies: Energies) -> Vec<Method> {
    let algorithms = std::iter::once(Algorithm::Joseph).chain(STEPS.map(|step| Algorithm::March { step }));
    algorithms.map(|algorithm| Method { energies, ..algorithm.into() }).collect()
}
