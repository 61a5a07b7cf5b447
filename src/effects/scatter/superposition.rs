//! The scatter of all pencils of rays together.

use rayon::prelude::*;

use super::ScatterKernels;
use super::cells::Cells;
use super::convolution::{add, blurred};
use super::curvature::Curvature;
use super::excursion::{CLASSES, Surroundings};
use super::pencils::Pencils;
use crate::allocation::filled;
use crate::effects::Plane;
use crate::error::{Error, Result};

/// Cells along the longer side of the detector: scatter changes over centimetres.
const CELLS: f64 = 48.0;

/// One view's detector in cells.
struct Superposition<'a> {
    kernels: &'a ScatterKernels,
    row: usize,
    axes: [Cells; 2],
    /// Width and height of a cell, mm.
    cell_mm: [f64; 2],
    /// The foot of the perpendicular from the corner of the first cell, mm.
    foot_mm: [f64; 2],
}

impl ScatterKernels {
    /// Scattered signal of each sample, in the unit of `primary`: `S(x) = Σ P(x')·k(A(x'), |x − x'|)` over the samples x'.
    ///
    /// `primary` is the signal of `row` without scatter, `areal_density` the total areal density of the same rays in
    /// g/cm², `pitch_mm` the distance of samples along i and j in the detector's plane. Kernels between two areal
    /// densities are the mean of both, weighted by the distance; `foot` is the sample, which may be a fraction and outside, where the
    /// perpendicular from the source meets the detector. Beyond 50 g/cm² the last grows in proportion. Where
    /// nothing attenuates nothing scatters.
    ///
    /// The beam is taken as collimated to the detector: photons that would pass beside it are not there and scatter
    /// nothing into it, while the object goes on there as at the detector's border. The sum is over at most 48 × 48
    /// cells, between which scatter is smooth.
    ///
    /// # Errors
    /// `InvalidArgument` when the planes differ in size or the pitch is not above 0; `OutOfMemory`.
    pub(crate) fn scattered(
        &self,
        row: usize,
        primary: &Plane,
        areal_density: &Plane,
        pitch_mm: [f64; 2],
        foot: [f64; 2],
    ) -> Result<Plane> {
        let size = primary.size();
        if areal_density.size() != size {
            let valid = format!("the primary's size, {size:?}");
            return Err(Error::invalid("areal_density", format!("{:?}", areal_density.size()), valid));
        }
        if !pitch_mm.iter().all(|pitch| *pitch > 0.0 && pitch.is_finite()) {
            return Err(Error::invalid("pitch_mm", format!("{pitch_mm:?}"), "above 0, finite, mm"));
        }
        let extent = [0, 1].map(|axis| size[axis] as f64 * pitch_mm[axis]);
        let side = extent[0].max(extent[1]) / CELLS;
        let count = [0, 1].map(|axis| ((extent[axis] / side).round() as usize).clamp(1, size[axis]));
        let cell_mm = [0, 1].map(|axis| extent[axis] / count[axis] as f64);
        let axes = [0, 1].map(|axis| Cells::new(size[axis], count[axis]));
        let pencils = Pencils::new(&axes, primary, areal_density, pitch_mm[0] * pitch_mm[1])?;
        let foot_mm = [0, 1].map(|axis| (foot[axis] + 0.5) * pitch_mm[axis]);
        let own = Superposition { kernels: self, row, axes, cell_mm, foot_mm };
        let mut cells = own.convolved(&own.amplitudes(&pencils)?)?;
        for (cell, (sum, areal)) in cells.iter_mut().zip(&pencils.areal_density).enumerate() {
            *sum *= self.obliquity(row).target(own.distance(cell), *areal);
        }
        own.upsampled(&cells, size)
    }
}

impl Superposition<'_> {
    fn count(&self) -> [usize; 2] {
        self.axes.each_ref().map(Cells::count)
    }

    /// From the foot of the perpendicular to the centre of a cell, mm.
    fn distance(&self, cell: usize) -> f64 {
        let count = self.count();
        let place = [cell % count[0], cell / count[0]];
        let [x, y] = [0, 1].map(|k| (place[k] as f64 + 0.5) * self.cell_mm[k] - self.foot_mm[k]);
        x.hypot(y)
    }

    /// Amplitudes of the Gaussians of each cell: that of g of cell c at `c*widths + g`.
    fn amplitudes(&self, pencils: &Pencils) -> Result<Vec<f64>> {
        let (areal_density, widths) = (&pencils.areal_density, self.kernels.widths());
        let obliquity = self.kernels.obliquity(self.row);
        let cell_cm = self.cell_mm.map(|mm| 0.1 * mm / obliquity.magnification);
        let surroundings = Surroundings { areal_density, count: self.count(), cell_cm };
        let parts = surroundings.parts()?;
        let side = [0, 1].map(|k| self.cell_mm[k] * self.count()[k] as f64);
        let curvature = Curvature::new(obliquity, &surroundings, widths, 0.5 * side[0].max(side[1]));
        let knots = ScatterKernels::areal_densities().len();
        let mut amplitudes = filled(areal_density.len() * widths.len(), 0.0, "the scatter estimate's cells")?;
        let cells = amplitudes.par_chunks_mut(widths.len()).zip(pencils.primary.par_chunks(knots));
        cells.zip(parts.par_chunks(CLASSES)).enumerate().for_each(|(cell, ((sums, primary), parts))| {
            let source = obliquity.source(self.distance(cell), areal_density[cell]);
            for (j, primary) in primary.iter().enumerate().filter(|(_, primary)| **primary != 0.0) {
                let classes = self.kernels.amplitudes(self.row, j).chunks(widths.len());
                classes.zip(parts).for_each(|(class, part)| add(sums, primary * part * source, class));
            }
            curvature.reduce(cell, sums);
        });
        Ok(amplitudes)
    }

    /// Mean over each cell of the scattered signal per mm² that the amplitudes make.
    fn convolved(&self, amplitudes: &[f64]) -> Result<Vec<f64>> {
        let widths = self.kernels.widths();
        let of_width = |g: usize| {
            let own: Vec<f64> = amplitudes.iter().skip(g).step_by(widths.len()).copied().collect();
            blurred(&own, self.count(), self.cell_mm, widths[g])
        };
        let parts: Vec<Vec<f64>> = (0..widths.len()).into_par_iter().map(of_width).collect();
        let mut sum = filled(amplitudes.len() / widths.len(), 0.0, "the scatter estimate's cells")?;
        for part in parts {
            add(&mut sum, 1.0, &part);
        }
        Ok(sum)
    }

    /// The cells' means as a smooth image. Scatter that falls to nothing within a cell would swing below it: that is cut.
    fn upsampled(&self, cells: &[f64], size: [usize; 2]) -> Result<Plane> {
        let (nx, mut image) = (self.axes[0].count(), Plane::filled(size, 0.0)?);
        let lines = image.values_mut().par_chunks_mut(size[0]).zip(self.axes[1].interpolation());
        lines.for_each(|(line, (first, weights))| {
            let mut coarse = vec![0.0; nx];
            for (weight, cells) in weights.iter().zip(cells[first * nx..].chunks(nx)) {
                add(&mut coarse, *weight, cells);
            }
            for (value, (first, weights)) in line.iter_mut().zip(self.axes[0].interpolation()) {
                let sum: f64 =
                    weights.iter().zip(&coarse[*first..]).map(|(weight, cell)| weight * cell).sum();
                *value = sum.max(0.0);
            }
        });
        Ok(image)
    }
}
