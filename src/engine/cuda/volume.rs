//! A volume in the device's memory.

use std::sync::Arc;
use std::time::Instant;

use cudarc::driver::{result, sys};

use crate::engine::cuda::device::Device;
use crate::engine::cuda::driver::{Event, Stream, allocated, checked};
use crate::engine::gpu::{DeviceVoxels, Layout, Slab};
use crate::error::Result;
use crate::volume::Volume;

/// Memory of a device.
struct Buffer {
    device: Arc<Device>,
    address: sys::CUdeviceptr,
    bytes: usize,
}

impl Buffer {
    fn new(device: &Arc<Device>, bytes: usize, what: &str) -> Result<Self> {
        let _current = device.current()?;
        // SAFETY: a context is current. A size of 0 is refused by the driver.
        let address = allocated(what, bytes, unsafe { result::malloc_sync(bytes.max(1)) })?;
        Ok(Self { device: device.clone(), address, bytes })
    }

    /// Puts the copy of some values, from byte `first` on, into a stream.
    ///
    /// # Safety
    /// The values stay until the stream has run it.
    unsafe fn fill<T: Copy>(&self, first: usize, values: &[T], stream: &Stream<'_>) -> Result<()> {
        assert!(first + size_of_val(values) <= self.bytes, "slabs lie inside the volume");
        let place = self.address + first as u64;
        // SAFETY: the place is inside the buffer; the values stay by the caller's promise.
        checked("the copy to the GPU", unsafe { result::memcpy_htod_async(place, values, stream.raw) })
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        if let Ok(_current) = self.device.current() {
            // SAFETY: allocated in this context; freeing waits for what uses it.
            let _ = unsafe { result::free_sync(self.address) };
        }
    }
}

/// The volume as the kernel reads it.
pub(super) struct DeviceVolume {
    pub(super) voxels: DeviceVoxels,
    /// Codes; or densities.
    first: Buffer,
    /// The table of densities, if there is one; or labels.
    second: Option<Buffer>,
    /// Where it holds anything.
    occupied: Buffer,
    pub(super) upload_seconds: f64,
}

/// `DrrVoxels` of `shaders/voxels.h`: codes, occupancy and table; or densities, labels and occupancy.
#[repr(C)]
pub(super) struct KernelVoxels([sys::CUdeviceptr; 3]);

impl DeviceVolume {
    /// Copies `volume` to the device, slab by slab.
    pub(super) fn new(device: &Arc<Device>, volume: &Volume) -> Result<Self> {
        let start = Instant::now();
        let voxels = DeviceVoxels::new(volume)?;
        let count: usize = voxels.framed().iter().product();
        let table = voxels.density_of_value();
        let (first, second, what) = match voxels.layout() {
            Layout::Dense => (4 * count, count, "the labels"),
            Layout::Coded | Layout::Texture => (2 * count, size_of_val(table), "the table of densities"),
        };
        let first = Buffer::new(device, first, "the voxels")?;
        let second = (second > 0).then(|| Buffer::new(device, second, what)).transpose()?;
        let occupancy = voxels.occupancy(volume)?;
        let occupied = Buffer::new(device, occupancy.len(), "the volume's occupancy")?;
        let made = Self { voxels, first, second, occupied, upload_seconds: 0.0 };
        made.copy(device, volume, &occupancy)?;
        Ok(Self { upload_seconds: start.elapsed().as_secs_f64(), ..made })
    }

    fn copy(&self, device: &Device, volume: &Volume, occupancy: &[u8]) -> Result<()> {
        let current = device.current()?;
        let stream = Stream::new(&current)?;
        // SAFETY: the stream is waited for before this function ends.
        unsafe { self.occupied.fill(0, occupancy, &stream) }.and(stream.finish("the copy to the GPU"))?;
        let second = |place: usize, bytes: &[u8]| match &self.second {
            // SAFETY: the stream is waited for before the slab's memory is used again.
            Some(second) => unsafe { second.fill(place, bytes, &stream) },
            None => Ok(()),
        };
        self.voxels.slabs(volume, |place, slab| {
            match slab {
                // SAFETY: the stream is waited for below, also when a copy is refused.
                Slab::Coded(codes) => unsafe { self.first.fill(2 * place, codes, &stream) },
                // SAFETY: as above.
                Slab::Dense(density, label) => unsafe { self.first.fill(4 * place, density, &stream) }
                    .and_then(|()| second(place, label)),
            }
            .and(stream.finish("the copy to the GPU"))
        })?;
        if let (Some(second), Layout::Coded) = (&self.second, self.voxels.layout()) {
            // SAFETY: the table is the volume's own, and the stream is waited for.
            unsafe { second.fill(0, self.voxels.density_of_value(), &stream)? };
        }
        stream.finish("the copy to the GPU")
    }

    /// As the kernel's parameter.
    pub(super) fn parameter(&self) -> KernelVoxels {
        let second = self.second.as_ref().map_or(0, |second| second.address);
        match self.voxels.layout() {
            Layout::Dense => KernelVoxels([self.first.address, second, self.occupied.address]),
            Layout::Coded | Layout::Texture => {
                KernelVoxels([self.first.address, self.occupied.address, second])
            }
        }
    }

    /// Memory of the device that it takes.
    pub(super) fn bytes(&self) -> usize {
        self.first.bytes + self.second.as_ref().map_or(0, |second| second.bytes) + self.occupied.bytes
    }

    /// Bytes per second, read and written, of a copy of the voxels.
    pub(super) fn copy_bandwidth(&self) -> Result<f64> {
        let device = &self.first.device;
        let copy = Buffer::new(device, self.first.bytes, "a copy of the voxels")?;
        let current = device.current()?;
        let (stream, start, end) = (Stream::new(&current)?, Event::new(&current)?, Event::new(&current)?);
        // The first copy also makes the memory's pages.
        for _ in 0..2 {
            start.record(&stream)?;
            // SAFETY: both buffers are that long, and outlive the stream's end, which is waited for.
            let copied = unsafe {
                result::memcpy_dtod_async(copy.address, self.first.address, copy.bytes, stream.raw)
            };
            checked("a copy on the GPU", copied)?;
            end.record(&stream)?;
        }
        stream.finish("a copy on the GPU")?;
        Ok(2.0 * copy.bytes as f64 / end.seconds_since(&start)?)
    }
}
