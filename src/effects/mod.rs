//! What happens to X-rays beside attenuation by the CT: one file per effect, each with its physics and its source. A scene
//! asks for none unless it says so, and what is not asked for is not computed.

mod plane;

pub(crate) use plane::Plane;
