//! Where the kernel leaves the layers.

use cudarc::driver::{result, sys};

use crate::engine::cuda::driver::{Stream, checked};
use crate::engine::{Images, Layers};
use crate::error::Result;

/// `DrrImages` of `shaders/pixel.h`: where the layers go; 0 for what is not wanted.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(super) struct Places {
    pub(super) intensity: sys::CUdeviceptr,
    pub(super) line_integral: sys::CUdeviceptr,
    pub(super) areal_density: sys::CUdeviceptr,
    pub(super) bone_path: sys::CUdeviceptr,
}

/// `DrrSignals` of `shaders/signals.h`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(super) struct SignalPlaces {
    pub(super) before: sys::CUdeviceptr,
    pub(super) passing: sys::CUdeviceptr,
    pub(super) open: sys::CUdeviceptr,
}

/// Where a launch's signals go on the host.
pub(super) struct SignalPlanes<'a> {
    pub(super) passing: &'a mut [f32],
    pub(super) open: &'a mut [f32],
}

impl SignalPlanes<'_> {
    /// Bytes that they take on the GPU.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(self.passing) + size_of_val(self.open)
    }

    /// Their places in one buffer from `address` on, behind what is at `before`.
    pub(super) fn places(&self, address: u64, before: u64) -> SignalPlaces {
        SignalPlaces { before, passing: address, open: address + size_of_val(self.passing) as u64 }
    }

    /// Copies them to the host. The stream must be waited for.
    ///
    /// # Safety
    /// The places are of these planes; they stay until the stream has run it.
    pub(super) unsafe fn copy_back(&mut self, places: &SignalPlaces, stream: &Stream<'_>) -> Result<()> {
        for (part, place) in [(&mut *self.passing, places.passing), (&mut *self.open, places.open)] {
            if !part.is_empty() {
                // SAFETY: by the caller's promise.
                let copied = unsafe { result::memcpy_dtoh_async(part, place, stream.raw) };
                checked("the signals from the GPU", copied)?;
            }
        }
        Ok(())
    }
}

impl Places {
    /// The places of later views, `pixels` further on, of `materials` materials.
    pub(super) fn after(self, pixels: usize, materials: usize) -> Self {
        let step = |address: u64, values: usize| match address {
            0 => 0,
            address => address + (values * size_of::<f32>()) as u64,
        };
        Self {
            intensity: step(self.intensity, pixels),
            line_integral: step(self.line_integral, pixels),
            areal_density: step(self.areal_density, pixels * materials),
            bone_path: step(self.bone_path, pixels),
        }
    }

    /// Places in one buffer from `address` on, for as many pixels; and the bytes that they take.
    pub(super) fn packed(address: u64, pixels: usize, materials: usize, layers: Layers) -> (Self, usize) {
        let mut bytes = 0;
        let mut place = |wanted: bool, values: usize| {
            let place = if wanted { address + bytes as u64 } else { 0 };
            bytes += if wanted { values * size_of::<f32>() } else { 0 };
            place
        };
        let places = Self {
            intensity: place(layers.intensity, pixels),
            line_integral: place(layers.line_integral, pixels),
            areal_density: place(layers.areal_density, pixels * materials),
            bone_path: place(layers.bone_path, pixels),
        };
        (places, bytes)
    }

    /// Copies the pixels of views `first …` to the host. The stream must be waited for.
    ///
    /// # Safety
    /// The places are of the wanted layers, for `pixels` pixels of all those views; the images stay until the stream
    /// has run it.
    pub(super) unsafe fn copy_back(
        &self,
        images: &mut Images<f32>,
        first: usize,
        pixels: usize,
        stream: &Stream<'_>,
    ) -> Result<()> {
        let materials = images.materials;
        let start = first * images.size[0] * images.size[1];
        let layers = [
            (&mut images.intensity, self.intensity, 1),
            (&mut images.line_integral, self.line_integral, 1),
            (&mut images.areal_density, self.areal_density, materials),
            (&mut images.bone_path, self.bone_path, 1),
        ];
        for (image, place, planes) in layers.into_iter().filter(|(image, ..)| !image.is_empty()) {
            let part = &mut image[start * planes..(start + pixels) * planes];
            // SAFETY: by the caller's promise.
            let copied = unsafe { result::memcpy_dtoh_async(part, place, stream.raw) };
            checked("the images from the GPU", copied)?;
        }
        Ok(())
    }
}
