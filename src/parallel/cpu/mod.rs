//! The CPU's engine, float32 or float64.

pub(super) mod adjoint;
mod exact;
mod fast;
pub(super) mod field;
mod ray_sum;
mod slab;
pub(super) mod steps;

use std::any::Any;

use rayon::prelude::*;

use crate::allocation::{filled, reserved};
use crate::error::Result;
use crate::normal_equations::NormalEquations;
use crate::parallel::engine::{Engine, ViewRays};
use crate::parallel::{Jacobian, ParallelGeometry, Quadrature};
use crate::real::Real;
use field::Field;
use ray_sum::RaySum;

/// Values of columns that wait together to be put into images.
const SCRATCH: usize = 1 << 20;

/// A pixel and its derivatives.
type Row = (f64, [f64; 5]);

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

    /// The rays of a column that count, into `sums`, one per row; others may be anything. Without DERIVATIVES, values are all
    /// that need be right.
    fn integrate<const DERIVATIVES: bool>(&self, view: &ViewRays<'_>, u: usize, sums: &mut [RaySum]) {
        let (field, geometry, frame) = (&self.field, &self.geometry, view.frame);
        let float32 = (field as &dyn Any).downcast_ref::<Field<f32>>();
        if let (Quadrature::Steps, Some(field)) = (self.quadrature, float32) {
            let column = fast::Column { field, geometry, view, u };
            return fast::integrate::<DERIVATIVES>(column, sums);
        }
        for (v, sum) in sums.iter_mut().enumerate() {
            let pixel = v * geometry.detector[0] + u;
            if !view.rays.counts(pixel) {
                continue;
            }
            let length = view.rays.length(pixel);
            *sum = match self.quadrature {
                Quadrature::Steps => steps::integrate(field, geometry, frame, [u, v], length),
                Quadrature::Exact => exact::integrate(field, geometry, frame, [u, v], length),
            };
        }
    }
}

impl<T: Real> Engine<T> for Cpu<T> {
    fn project(&self, views: &[ViewRays<'_>], images: &mut [T]) -> Result<()> {
        let [nu, nv] = self.geometry.detector;
        let together = (SCRATCH / nv).max(1);
        let mut scratch = filled(nv * together.min(nu * views.len()), T::default(), "columns of images")?;
        for first in (0..nu * views.len()).step_by(together) {
            let count = together.min(nu * views.len() - first);
            let columns = &mut scratch[..nv * count];
            columns.par_chunks_mut(nv).enumerate().for_each(|(n, column)| {
                let (view, u) = (&views[(first + n) / nu], (first + n) % nu);
                let mut sums = vec![RaySum::default(); nv];
                self.integrate::<false>(view, u, &mut sums);
                for ((v, value), sum) in column.iter_mut().enumerate().zip(&sums) {
                    *value = if view.rays.counts(v * nu + u) { T::of(sum.value) } else { T::default() };
                }
            });
            for (n, column) in columns.chunks(nv).enumerate() {
                let (view, u) = ((first + n) / nu, (first + n) % nu);
                for (v, &value) in column.iter().enumerate() {
                    images[(view * nv + v) * nu + u] = value;
                }
            }
        }
        Ok(())
    }

    fn normal_equations(&self, view: ViewRays<'_>, measured: &[T]) -> Result<NormalEquations<5>> {
        let [nu, nv] = self.geometry.detector;
        let mut columns = reserved(nu, "the columns")?;
        let column = |u: usize| {
            let mut sums = vec![RaySum::default(); nv];
            self.integrate::<true>(&view, u, &mut sums);
            let mut equations = NormalEquations::default();
            for (v, sum) in sums.iter().enumerate().filter(|(v, _)| view.rays.counts(v * nu + u)) {
                let residual = sum.value - measured[v * nu + u].into();
                equations.add(residual, &sum.derivatives(view.derivatives, u, v));
            }
            equations
        };
        (0..nu).into_par_iter().map(column).collect_into_vec(&mut columns);
        // In the order of columns, whatever thread made them.
        let mut sum = NormalEquations::default();
        for column in &columns {
            sum.merge(column);
        }
        Ok(sum)
    }

    fn jacobian(&self, view: ViewRays<'_>, jacobian: &mut Jacobian<T>) -> Result<()> {
        let [nu, nv] = self.geometry.detector;
        let together = (SCRATCH / nv).max(1).min(nu);
        let mut scratch = filled(nv * together, Row::default(), "columns of the Jacobian")?;
        for first in (0..nu).step_by(together) {
            let columns = &mut scratch[..nv * together.min(nu - first)];
            columns.par_chunks_mut(nv).enumerate().for_each(|(n, column)| {
                let u = first + n;
                let mut sums = vec![RaySum::default(); nv];
                self.integrate::<true>(&view, u, &mut sums);
                for ((v, row), sum) in column.iter_mut().enumerate().zip(&sums) {
                    let counts = view.rays.counts(v * nu + u);
                    *row = if counts {
                        (sum.value, sum.derivatives(view.derivatives, u, v))
                    } else {
                        Row::default()
                    };
                }
            });
            for (n, column) in columns.chunks(nv).enumerate() {
                for (v, (value, derivatives)) in column.iter().enumerate() {
                    let pixel = v * nu + first + n;
                    jacobian.image[pixel] = T::of(*value);
                    for (plane, derivative) in jacobian.derivatives.iter_mut().zip(derivatives) {
                        plane[pixel] = T::of(*derivative);
                    }
                }
            }
        }
        Ok(())
    }
}
