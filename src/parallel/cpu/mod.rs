//! The CPU's engine, float32 or float64.

mod exact;
mod field;
mod ray_sum;
mod steps;

use rayon::prelude::*;

use crate::allocation::reserved;
use crate::error::Result;
use crate::normal_equations::NormalEquations;
use crate::parallel::engine::{Engine, ViewRays};
use crate::parallel::{Jacobian, ParallelGeometry, Quadrature};
use crate::real::Real;
use field::Field;
use ray_sum::RaySum;

/// A volume, and how rays are integrated.
pub(super) struct Cpu<T> {
    geometry: ParallelGeometry,
    quadrature: Quadrature,
    field: Field<T>,
}

impl<T: Real> Cpu<T> {
    /// # Errors
    /// As [`Field::new`].
    pub(super) fn new(geometry: ParallelGeometry, quadrature: Quadrature, volume: &[T]) -> Result<Self> {
        Ok(Self { geometry, quadrature, field: Field::new(&geometry, volume)? })
    }

    fn ray(&self, view: &ViewRays<'_>, u: usize, v: usize) -> RaySum {
        let length = view.rays.length(v * self.geometry.detector[0] + u);
        let (field, geometry, frame) = (&self.field, &self.geometry, view.frame);
        match self.quadrature {
            Quadrature::Steps => steps::integrate(field, geometry, frame, [u, v], length),
            Quadrature::Exact => exact::integrate(field, geometry, frame, [u, v], length),
        }
    }

    /// What `make` makes of each column's rays that count.
    fn columns<R: Send>(
        &self,
        view: &ViewRays<'_>,
        make: impl Fn(usize, &mut dyn Iterator<Item = (usize, RaySum)>) -> R + Sync,
    ) -> Result<Vec<R>> {
        let [nu, nv] = self.geometry.detector;
        let mut columns = reserved(nu, "the columns")?;
        let column = |u: usize| {
            let counts = |v: &usize| view.rays.counts(v * nu + u);
            make(u, &mut (0..nv).filter(counts).map(|v| (v, self.ray(view, u, v))))
        };
        (0..nu).into_par_iter().map(column).collect_into_vec(&mut columns);
        Ok(columns)
    }
}

impl<T: Real> Engine<T> for Cpu<T> {
    fn project(&self, views: &[ViewRays<'_>], images: &mut [T]) -> Result<()> {
        let [nu, nv] = self.geometry.detector;
        images.par_chunks_mut(nu).enumerate().for_each(|(n, row)| {
            let (view, v) = (&views[n / nv], n % nv);
            for (u, value) in row.iter_mut().enumerate() {
                if view.rays.counts(v * nu + u) {
                    *value = T::of(self.ray(view, u, v).value);
                }
            }
        });
        Ok(())
    }

    fn normal_equations(&self, view: ViewRays<'_>, measured: &[T]) -> Result<NormalEquations<5>> {
        let [nu, _] = self.geometry.detector;
        let columns = self.columns(&view, |u, sums| {
            let mut equations = NormalEquations::default();
            for (v, sum) in sums {
                let residual = sum.value - measured[v * nu + u].into();
                equations.add(residual, &sum.derivatives(view.derivatives, u, v));
            }
            equations
        })?;
        // In the order of columns, whatever thread made them.
        let mut sum = NormalEquations::default();
        for column in &columns {
            sum.merge(column);
        }
        Ok(sum)
    }

    fn jacobian(&self, view: ViewRays<'_>, jacobian: &mut Jacobian<T>) -> Result<()> {
        let columns = self.columns(&view, |u, sums| {
            let row = |(v, sum): (usize, RaySum)| (v, sum.value, sum.derivatives(view.derivatives, u, v));
            sums.map(row).collect::<Vec<_>>()
        })?;
        for (u, column) in columns.into_iter().enumerate() {
            for (v, value, row) in column {
                let pixel = v * self.geometry.detector[0] + u;
                jacobian.image[pixel] = T::of(value);
                for (plane, value) in jacobian.derivatives.iter_mut().zip(row) {
                    plane[pixel] = T::of(value);
                }
            }
        }
        Ok(())
    }
}
