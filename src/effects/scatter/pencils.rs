//! The pencils of rays of a view, gathered in cells.

use rayon::prelude::*;

use super::ScatterKernels;
use super::cells::Cells;
use crate::allocation::filled;
use crate::effects::Plane;
use crate::error::Result;

/// What the rays of each cell bring along.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pencils {
    /// Primary signal × mm² of cell c, split between the areal densities that have kernels: that of j at `c*knots + j`.
    pub(super) primary: Vec<f64>,
    /// Mean areal density of cell c, g/cm².
    pub(super) areal_density: Vec<f64>,
}

impl Pencils {
    /// Of the samples of `primary` and `areal_density`, each of `area` mm².
    pub(super) fn new(axes: &[Cells; 2], primary: &Plane, areal_density: &Plane, area: f64) -> Result<Self> {
        let ([nx, ny], knots) = (axes.each_ref().map(Cells::count), ScatterKernels::areal_densities());
        let width = primary.size()[0];
        let mut split = filled(nx * ny * knots.len(), 0.0, "the scatter estimate's cells")?;
        let mut areal = filled(nx * ny, 0.0, "the scatter estimate's cells")?;
        let lines = split.par_chunks_mut(nx * knots.len()).zip(areal.par_chunks_mut(nx));
        lines.zip(pixel_rows(&axes[1])).for_each(|((split, mean), rows)| {
            for (j, part) in rows {
                let line = j * width..(j + 1) * width;
                let values = primary.values()[line.clone()].iter().zip(&areal_density.values()[line]);
                for ((signal, areal), (first, parts)) in values.zip(axes[0].parts()) {
                    let (below, [low, high]) = place(knots, *areal);
                    for (cell, x_part) in (*first..).zip(parts) {
                        let inside = part * x_part;
                        let own = &mut split[cell * knots.len() + below..][..2];
                        own[0] += low * signal * area * inside;
                        own[1] += high * signal * area * inside;
                        mean[cell] += areal * inside;
                    }
                }
            }
        });
        let pixels = primary.values().len() as f64 / (nx * ny) as f64;
        for sum in &mut areal {
            *sum /= pixels;
        }
        Ok(Self { primary: split, areal_density: areal })
    }
}

/// For each row of cells the rows of pixels in it and the part of each that is.
fn pixel_rows(axis: &Cells) -> Vec<Vec<(usize, f64)>> {
    let mut rows = vec![Vec::new(); axis.count()];
    for (j, (first, parts)) in axis.parts().iter().enumerate() {
        for (cell, part) in (*first..).zip(parts) {
            rows[cell].push((j, *part));
        }
    }
    rows
}

/// Index of the areal density below, and the weights of that one and the next. Below the first there is no scatter.
fn place(knots: &[f64], areal: f64) -> (usize, [f64; 2]) {
    let last = knots.len() - 1;
    let below = knots.partition_point(|knot| *knot <= areal).clamp(1, last) - 1;
    if areal >= knots[last] {
        return (below, [0.0, areal / knots[last]]);
    }
    let part = ((areal - knots[below]) / (knots[below + 1] - knots[below])).max(0.0);
    (below, [1.0 - part, part])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_areal_density_is_the_mean_of_those_around_it() {
        let knots = ScatterKernels::areal_densities();
        for areal in [0.0, 0.1, 0.5, 3.0, 27.5, 49.9, 50.0] {
            let (below, [low, high]) = place(knots, areal);
            assert!((low * knots[below] + high * knots[below + 1] - areal).abs() < 1e-12);
            assert!((low + high - 1.0).abs() < 1e-12);
        }
        assert_eq!(place(knots, 75.0), (knots.len() - 2, [0.0, 1.5]));
    }

    #[test]
    fn all_primary_is_in_the_cells() {
        let (mut primary, mut areal) =
            (Plane::filled([37, 23], 0.0).unwrap(), Plane::filled([37, 23], 0.0).unwrap());
        for (k, (p, a)) in primary.values_mut().iter_mut().zip(areal.values_mut()).enumerate() {
            (*p, *a) = ((k as f64).sin() + 1.0, 40.0 * (k as f64 * 0.3).cos().abs());
        }
        let axes = [Cells::new(37, 10), Cells::new(23, 7)];
        let own = Pencils::new(&axes, &primary, &areal, 2.0).unwrap();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let all = own.primary.iter().sum::<f64>() / 2.0 / (37.0 * 23.0);
        assert!((all / mean(primary.values()) - 1.0).abs() < 1e-12);
        assert!((mean(&own.areal_density) / mean(areal.values()) - 1.0).abs() < 1e-12);
    }
}
