//! Where the object is in one view.

use glam::DVec3;

use crate::error::Result;
use crate::geometry::RigidMotion;

/// The five rigid parameters of a view. A motion along the beam, Δy, changes nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ViewParameters {
    /// Rotation about x, radians.
    pub alpha: f64,
    /// Rotation about y, the beam, radians.
    pub beta: f64,
    /// Rotation about z, radians: the angle of a tomographic view.
    pub phi: f64,
    /// Translation along x, mm.
    pub dx: f64,
    /// Translation along z, mm.
    pub dz: f64,
}

impl ViewParameters {
    /// Number of parameters.
    pub const COUNT: usize = 5;

    /// α, β, φ, Δx, Δz.
    pub fn to_array(self) -> [f64; Self::COUNT] {
        [self.alpha, self.beta, self.phi, self.dx, self.dz]
    }

    /// Of α, β, φ, Δx, Δz.
    pub fn from_array([alpha, beta, phi, dx, dz]: [f64; Self::COUNT]) -> Self {
        Self { alpha, beta, phi, dx, dz }
    }

    /// As a motion of the object in the world.
    pub fn motion(&self) -> RigidMotion {
        RigidMotion {
            angles: [self.alpha, self.beta, self.phi],
            translation: DVec3::new(self.dx, 0.0, self.dz),
        }
    }

    /// # Errors
    /// As [`RigidMotion::validate`].
    pub fn validate(&self) -> Result<()> {
        self.motion().validate()
    }
}

/// Refuses parameters of which some are not valid, by `views[k]`.
pub(crate) fn check_views(views: &[ViewParameters]) -> Result<()> {
    for (k, view) in views.iter().enumerate() {
        view.validate().map_err(|error| error.of(&format!("views[{k}]")))?;
    }
    Ok(())
}
