//! Of what the stages of a scene with effects have a cost.

/// Something that is done for every ray or pixel after the rays have been cast.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageRate {
    /// One energy of one ray.
    Energy,
    /// One material in the way of one ray, per energy.
    Material,
    /// One energy of one ray in each of its sums: detector layers, and moments where noise needs them.
    Sum,
    /// What lies before the volume, per ray and part of it.
    Source,
    /// One implant in the way of one ray.
    Implant,
    /// One weight of a convolution, per ray and sum.
    Weight,
    /// Scatter, per ray and sum.
    Scatter,
    /// Scatter's cells, per sum, whatever the rays.
    ScatterCells,
    /// Adding one ray to its pixel, per sum.
    Pixel,
    /// The noise of one pixel and detector layer.
    Noise,
}

impl StageRate {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Energy,
        Self::Material,
        Self::Sum,
        Self::Source,
        Self::Implant,
        Self::Weight,
        Self::Scatter,
        Self::ScatterCells,
        Self::Pixel,
        Self::Noise,
    ];

    /// What timings files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Energy => "energy of a ray",
            Self::Material => "material of a ray's energy",
            Self::Sum => "energy of a ray's sum",
            Self::Source => "part before the volume",
            Self::Implant => "implant of a ray",
            Self::Weight => "weight of a convolution",
            Self::Scatter => "scatter of a ray",
            Self::ScatterCells => "scatter between cells",
            Self::Pixel => "ray of a pixel",
            Self::Noise => "noise of a pixel",
        }
    }
}
