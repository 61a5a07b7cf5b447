//! What computes a parallel projector's images.

use std::any::{Any, TypeId};

use crate::context::Context;
use crate::engine::{Backend, Timings};
use crate::error::{Error, Result};
use crate::normal_equations::NormalEquations;
use crate::parallel::cpu::Cpu;
use crate::parallel::cpu::field::Field;
use crate::parallel::device::OnDevice;
use crate::parallel::frame::Frame;
use crate::parallel::{Jacobian, ParallelGeometry, Quadrature, RaySelection};
use crate::real::Real;

/// One view's samples, how they move with the five parameters, and its rays that count.
#[derive(Clone, Copy)]
pub(super) struct ViewRays<'a> {
    pub frame: &'a Frame,
    pub derivatives: &'a [Frame; 5],
    pub rays: RaySelection<'a>,
}

/// An engine that holds one volume in one geometry. Whoever calls has checked all sizes; images are `v*nu + u`.
pub(super) trait Engine<T>: Send + Sync {
    /// The image of each view, into `images`, which are 0.
    fn project(&self, views: &[ViewRays<'_>], images: &mut [T]) -> Result<()>;

    /// Residuals image − measured of the rays that count, with their derivatives.
    fn normal_equations(&self, view: ViewRays<'_>, measured: &[T]) -> Result<NormalEquations<5>>;

    /// Image and derivatives, into planes that are 0.
    fn jacobian(&self, view: ViewRays<'_>, jacobian: &mut Jacobian<T>) -> Result<()>;

    /// What the device measured of the last call; `None` on the CPU.
    fn timings(&self) -> Option<Timings> {
        None
    }
}

/// The engine of a context, holding a volume. The reference computes in float64, devices in float32, the CPU in both.
///
/// # Errors
/// `InvalidArgument` for a volume that is not valid; `Unsupported` for a width or a quadrature that the engine does not have;
/// `OutOfMemory`; `Device`.
pub(super) fn engine<T: Real>(
    context: &Context,
    geometry: ParallelGeometry,
    quadrature: Quadrature,
    volume: &[T],
) -> Result<Box<dyn Engine<T>>> {
    let backend = context.backend();
    let single = TypeId::of::<T>() == TypeId::of::<f32>();
    match backend {
        Backend::Reference if single => Err(width(backend, "float64")),
        Backend::Reference | Backend::Cpu => Ok(Box::new(Cpu::new(geometry, quadrature, volume)?)),
        Backend::Host | Backend::Cuda | Backend::Metal => {
            if !single {
                return Err(width(backend, "float32"));
            }
            OnDevice::check(&geometry, quadrature)?;
            let field: Box<dyn Any> = Box::new(Field::new(&geometry, volume)?);
            let field = field.downcast::<Field<f32>>().map_err(|_| width(backend, "float32"))?;
            let engine = OnDevice::new(context.device(), geometry, *field)?;
            let engine: Box<dyn Any> = Box::new(Box::new(engine) as Box<dyn Engine<f32>>);
            // The same type, because the field was.
            engine
                .downcast::<Box<dyn Engine<T>>>()
                .map(|engine| *engine)
                .map_err(|_| width(backend, "float32"))
        }
    }
}

fn width(backend: Backend, its: &str) -> Error {
    Error::Unsupported(format!(
        "the engine {} computes parallel beams in {its} only; a context of the engine cpu has float32 and float64",
        backend.name()
    ))
}
