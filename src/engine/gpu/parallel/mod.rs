//! Parallel beams as the kernel text of `shaders/parallel.h` takes them.

mod wire;

pub(crate) use wire::{Interval, Launch, Motion, View};

use crate::engine::Timings;
use crate::engine::gpu::Definitions;
use crate::error::Result;

/// Planes of a view with its derivatives: image or residual, then those with respect to α, β, φ, Δx, Δz.
pub(crate) const PLANES: usize = 6;

/// Products of two planes: (0, 0), (0, 1), … (5, 5), the first not after the second.
pub(crate) const PRODUCTS: usize = PLANES * (PLANES + 1) / 2;

/// What of `shaders/parallel.h` is compiled.
const FLAGS: [&str; 4] = ["DRR_DERIVATIVES", "DRR_RESIDUAL", "DRR_MASK", "DRR_LENGTHS"];

/// Some views of one field.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    pub launch: Launch,
    pub views: Vec<View>,
    /// One per pixel, 0 where rays do not count.
    pub mask: Option<Vec<u8>>,
    /// One per pixel.
    pub intervals: Option<Vec<Interval>>,
    /// One per pixel, to be subtracted.
    pub measured: Option<&'a [f32]>,
    /// What is made of the rays.
    pub wanted: Wanted,
}

/// What a job makes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wanted {
    /// One image per view.
    Images,
    /// All planes of one view.
    Planes,
    /// Sums of all products of two planes of one view, over part after part of its rays.
    Sums,
}

impl Job<'_> {
    /// What of the kernel text is compiled for it.
    pub(crate) fn definitions(&self) -> Definitions {
        let on = [
            self.wanted != Wanted::Images,
            self.measured.is_some(),
            self.mask.is_some(),
            self.intervals.is_some(),
        ];
        Definitions::flags(FLAGS.into_iter().zip(on))
    }

    pub(crate) fn pixels(&self) -> usize {
        self.launch.width as usize * self.launch.height as usize
    }

    /// Numbers that its rays leave.
    pub(crate) fn rays(&self) -> usize {
        match self.wanted {
            Wanted::Images => self.pixels() * self.views.len(),
            Wanted::Planes | Wanted::Sums => self.pixels() * PLANES,
        }
    }

    /// Sums of one view.
    pub(crate) fn sums(&self) -> usize {
        self.pixels().div_ceil(self.launch.part as usize) * PRODUCTS
    }

    /// Numbers that are its result.
    pub(crate) fn results(&self) -> usize {
        if self.wanted == Wanted::Sums { self.sums() } else { self.rays() }
    }
}

/// A field that a device holds, and what runs on it. All sizes have been checked.
pub(crate) trait HeldField: Send + Sync {
    /// Seconds of the kernels, by the device's clock; `results` are as many as the job has.
    ///
    /// # Errors
    /// `Unsupported`, with the compiler's words, when the kernel does not compile; `OutOfMemory`; `Device`.
    fn run(&self, job: &Job<'_>, results: &mut [f32]) -> Result<f64>;

    /// What the device measured beside them; `None` on the CPU.
    fn timings(&self) -> Option<Timings>;
}

#[cfg(test)]
impl Job<'_> {
    /// Every specialisation.
    pub(crate) fn covering() -> Vec<Definitions> {
        let bits = |n: u32| [0, 1, 2, 3].map(|bit| n >> bit & 1 == 1);
        (0..16).map(|n| Definitions::flags(FLAGS.into_iter().zip(bits(n)))).collect()
    }
}
