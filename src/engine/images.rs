//! What a projection returns.

use std::ops::Range;

use crate::allocation::{collected, filled};
use crate::error::Result;
use crate::physics::MAX_MATERIALS;

/// Which layers are wanted.
#[expect(clippy::struct_excessive_bools, reason = "they are independent")]
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Layers {
    /// Detector signal, in the units of the spectrum's weights; a ray that meets nothing gives I0 exactly.
    pub intensity: bool,
    /// p = −ln(I/I0), dimensionless, with I0 the open field of the same pixel. Finite as long as the areal densities are; with
    /// effects infinite where noise leaves no signal or the intensity underflows in float64.
    pub line_integral: bool,
    /// ∫ρ dl of every material of the scene, g/cm².
    pub areal_density: bool,
    /// Length in mm through voxels labelled bone.
    pub bone_path: bool,
}

impl Layers {
    /// Every layer.
    pub const ALL: Self = Self { intensity: true, line_integral: true, areal_density: true, bone_path: true };
}

/// The layers of all views. A layer that was not asked for is empty. Pixel (i, j) of view v is at
/// `(v*height + j)*width + i`; areal densities at `((v*materials + m)*height + j)*width + i`; intensity and line integral of a
/// detector with two layers at `((v*2 + l)*height + j)*width + i`.
#[derive(Debug, Clone, PartialEq)]
pub struct Images<T> {
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Number of views.
    pub views: usize,
    /// Number of materials of the scene.
    pub materials: usize,
    /// Number of layers of the detector.
    pub detector_layers: usize,
    /// See [`Layers::intensity`].
    pub intensity: Vec<T>,
    /// See [`Layers::line_integral`].
    pub line_integral: Vec<T>,
    /// See [`Layers::areal_density`].
    pub areal_density: Vec<T>,
    /// See [`Layers::bone_path`].
    pub bone_path: Vec<T>,
}

/// What one ray, or the mean of a pixel's rays, came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PixelValue {
    /// Detector signal.
    pub intensity: f64,
    /// −ln(I/I0).
    pub line_integral: f64,
    /// g/cm² by material of the scene.
    pub areal_density: [f64; MAX_MATERIALS],
    /// mm.
    pub bone_path: f64,
}

impl PixelValue {
    /// A ray that meets nothing.
    pub(super) fn vacuum(i0: f64) -> Self {
        Self { intensity: i0, line_integral: 0.0, areal_density: [0.0; MAX_MATERIALS], bone_path: 0.0 }
    }

    /// A pixel's value from those of its rays: the detector sums photons, so intensities are averaged, and the line
    /// integral is that of the mean, by log-sum-exp so that it stays finite when the intensity underflows.
    pub(super) fn mean(rays: &[Self]) -> Self {
        if let [only] = rays {
            return *only;
        }
        // Differences from the first ray: the mean of equal values is that value, bit for bit.
        let mean = |value: &dyn Fn(&Self) -> f64| {
            let first = value(&rays[0]);
            first + rays.iter().map(|ray| value(ray) - first).sum::<f64>() / rays.len() as f64
        };
        let least = rays.iter().map(|r| r.line_integral).fold(f64::INFINITY, f64::min);
        let beyond = mean(&|r| (least - r.line_integral).exp());
        Self {
            intensity: mean(&|r| r.intensity),
            line_integral: if least.is_finite() { least - beyond.ln() } else { least },
            areal_density: std::array::from_fn(|m| mean(&|r| r.areal_density[m])),
            bone_path: mean(&|r| r.bone_path),
        }
    }
}

impl<T: Copy + Default> Images<T> {
    /// Zeros for the wanted layers of a detector of one layer.
    pub(super) fn zeroed(size: [usize; 2], views: usize, materials: usize, layers: Layers) -> Result<Self> {
        Self::of_layers(size, views, materials, 1, layers)
    }

    /// Zeros for the wanted layers.
    pub(crate) fn of_layers(
        size: [usize; 2],
        views: usize,
        materials: usize,
        detector_layers: usize,
        layers: Layers,
    ) -> Result<Self> {
        let pixels = size[0] * size[1] * views;
        let layer = |wanted: bool, count: usize| {
            if wanted { filled(count, T::default(), "the images") } else { Ok(Vec::new()) }
        };
        Ok(Self {
            size,
            views,
            materials,
            detector_layers,
            intensity: layer(layers.intensity, pixels * detector_layers)?,
            line_integral: layer(layers.line_integral, pixels * detector_layers)?,
            areal_density: layer(layers.areal_density, pixels * materials)?,
            bone_path: layer(layers.bone_path, pixels)?,
        })
    }

    /// Stores the pixels of some columns of a view, from row `first_row` on; `values` is row-major.
    pub(super) fn store(
        &mut self,
        view: usize,
        first_row: usize,
        columns: Range<usize>,
        values: &[PixelValue],
        convert: impl Fn(f64) -> T,
    ) {
        let [width, height] = self.size;
        let put = |image: &mut Vec<T>, plane: usize, value: &dyn Fn(&PixelValue) -> f64| {
            if !image.is_empty() {
                for (row, values) in values.chunks(columns.len()).enumerate() {
                    let start = (plane * height + first_row + row) * width;
                    let target = &mut image[start..start + width][columns.clone()];
                    target.iter_mut().zip(values).for_each(|(out, v)| *out = convert(value(v)));
                }
            }
        };
        put(&mut self.intensity, view, &|v| v.intensity);
        put(&mut self.line_integral, view, &|v| v.line_integral);
        put(&mut self.bone_path, view, &|v| v.bone_path);
        for m in 0..self.materials {
            put(&mut self.areal_density, view * self.materials + m, &|v| v.areal_density[m]);
        }
    }

    /// Puts the images of one view, of which there are no others, in a view's place.
    pub(crate) fn put(&mut self, view: usize, one: &Self) {
        let put = |to: &mut Vec<T>, from: &Vec<T>| {
            to[view * from.len()..(view + 1) * from.len()].copy_from_slice(from);
        };
        put(&mut self.intensity, &one.intensity);
        put(&mut self.line_integral, &one.line_integral);
        put(&mut self.areal_density, &one.areal_density);
        put(&mut self.bone_path, &one.bone_path);
    }

    /// The images of one view alone.
    pub(crate) fn only(&self, view: usize) -> Result<Self> {
        let part = |layer: &[T]| {
            let values = layer.len() / self.views;
            collected(layer[view * values..(view + 1) * values].iter().copied(), "the images")
        };
        Ok(Self {
            views: 1,
            intensity: part(&self.intensity)?,
            line_integral: part(&self.line_integral)?,
            areal_density: part(&self.areal_density)?,
            bone_path: part(&self.bone_path)?,
            ..*self
        })
    }

    /// One view of a layer made of one plane per view.
    pub fn view<'a>(&self, layer: &'a [T], view: usize) -> &'a [T] {
        let pixels = self.size[0] * self.size[1];
        &layer[view * pixels..(view + 1) * pixels]
    }

    /// Intensity or line integral of one layer of the detector in one view.
    pub fn of_detector_layer<'a>(&self, layer: &'a [T], view: usize, detector_layer: usize) -> &'a [T] {
        self.view(layer, view * self.detector_layers + detector_layer)
    }

    /// The areal density of one material in one view.
    pub fn areal_density(&self, view: usize, material: usize) -> &[T] {
        self.view(&self.areal_density, view * self.materials + material)
    }
}

impl<T> Images<T> {
    /// The images with every value converted.
    pub fn map<U>(&self, convert: impl Fn(&T) -> U) -> Images<U> {
        let layer = |values: &[T]| values.iter().map(&convert).collect();
        Images {
            size: self.size,
            views: self.views,
            materials: self.materials,
            detector_layers: self.detector_layers,
            intensity: layer(&self.intensity),
            line_integral: layer(&self.line_integral),
            areal_density: layer(&self.areal_density),
            bone_path: layer(&self.bone_path),
        }
    }
}
