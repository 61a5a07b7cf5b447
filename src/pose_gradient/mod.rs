//! Images in a cone beam and their derivatives with respect to where the object is, through spectrum and detector.
//!
//! The object moves by `x ↦ R (x − pivot) + pivot + t` ([`RigidMotion`](crate::geometry::RigidMotion)): six parameters. In
//! index space a ray crosses the plane at s of its driving axis at `base + slope·(s − centre)`, so the areal density of
//! material m is `A_m = mm·Σ_k w_k f_m(s_k, base + slope·(s_k − centre))` and
//!
//! `dA_m = A_m d ln mm + mm·(Σ w ∇f_m·d base + Σ w (s − centre) ∇f_m·d slope + ∂A/∂enter d enter + ∂A/∂leave d leave)`
//!
//! with ∇ across the driving axis: seven sums per material are all that a ray needs, whatever its length. There is no tape.
//! The last two terms are those of the span's ends, which move where the ray passes the volume's sides and where it ends
//! inside. Of the areal densities the line integral is `p = −ln Σ_k w_k exp(−Σ_m (μ/ρ)_m(E_k) A_m)`, whose derivatives
//! [`SpectralModel::gradient`](crate::physics::SpectralModel::gradient) has.
//!
//! Derivatives are those of the sum that is taken, not of its limit. Where it has a kink (a sample on a plane through voxel
//! centres, a ray along a face) they are those of the upper cell, which lie between the one-sided ones.

mod exact;
mod field;
mod joseph;
mod march;
mod moving_beam;
mod moving_ray;
mod path_sums;
mod pixel;
mod projector;
mod siddon;

pub use projector::{PoseJacobian, PoseProjector};

/// Which signal an image holds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Signal {
    /// p = −ln(I/I0), of what the detector sees.
    #[default]
    LineIntegral,
    /// I, in the units of the spectrum's weights.
    Intensity,
}
