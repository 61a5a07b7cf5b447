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
pub(super) struct Buffer {
    device: Arc<Device>,
    pub(super) address: sys::CUdeviceptr,
    pub(super) bytes: usize,
}

impl Buffer {
    pub(super) fn new(device: &Arc<Device>, bytes: usize, what: &str) -> Result<Self> {
        let _current = device.current()?;
        // SAFETY: a context is current. A size of 0 is refused by the driver.
        let address = allocated(what, bytes, unsafe { result::malloc_sync(bytes.max(1)) })?;
        Ok(Self { device: device.clone(), address, bytes })
    }

    /// Puts the copy of some values, from byte `first` on, into a stream.
    ///
    /// # Safety
    /// The values stay until the stream has run it.
    pub(super) unsafe fn fill<T: Copy>(&self, first: usize, values: &[T], stream: &Stream<'_>) -> Result<()> {
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
    stored: Stored,
    /// Where it holds anything.
    occupied: Buffer,
    pub(super) upload_seconds: f64,
}

enum Stored {
    /// Codes, and the table of densities if the kernel needs one.
    Coded(Buffer, Option<Buffer>),
    /// Densities and labels.
    Dense(Buffer, Buffer),
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
        let buffer = |bytes: usize, what: &str| Buffer::new(device, bytes, what);
        let table = || match size_of_val(voxels.density_of_value()) {
            0 => Ok(None),
            bytes => buffer(bytes, "the table of densities").map(Some),
        };
        let stored = match voxels.layout() {
            Layout::Coded | Layout::Texture => Stored::Coded(buffer(2 * count, "the voxels")?, table()?),
            Layout::Dense => Stored::Dense(buffer(4 * count, "the voxels")?, buffer(count, "the labels")?),
        };
        let occupancy = voxels.occupancy(volume)?;
        let occupied = Buffer::new(device, occupancy.len(), "the volume's occupancy")?;
        let made = Self { voxels, stored, occupied, upload_seconds: 0.0 };
        made.copy(device, volume, &occupancy)?;
        Ok(Self { upload_seconds: start.elapsed().as_secs_f64(), ..made })
    }

    fn copy(&self, device: &Device, volume: &Volume, occupancy: &[u8]) -> Result<()> {
        let current = device.current()?;
        let stream = Stream::new(&current)?;
        // SAFETY: the stream is waited for before this function ends.
        unsafe { self.occupied.fill(0, occupancy, &stream) }.and(stream.finish("the copy to the GPU"))?;
        self.voxels.slabs(volume, |place, slab| {
            match (&self.stored, slab) {
                // SAFETY: the stream is waited for below, also when a copy is refused.
                (Stored::Coded(all, _), Slab::Coded(codes)) => unsafe { all.fill(2 * place, codes, &stream) },
                // SAFETY: as above.
                (Stored::Dense(densities, labels), Slab::Dense(density, label)) => unsafe {
                    let copied = densities.fill(4 * place, density, &stream);
                    copied.and_then(|()| labels.fill(place, label, &stream))
                },
                _ => unreachable!("slabs are laid out as the voxels say"),
            }
            .and(stream.finish("the copy to the GPU"))
        })?;
        if let Stored::Coded(_, Some(table)) = &self.stored {
            // SAFETY: the table is the volume's own, and the stream is waited for.
            unsafe { table.fill(0, self.voxels.density_of_value(), &stream)? };
        }
        stream.finish("the copy to the GPU")
    }

    /// As the kernel's parameter.
    pub(super) fn parameter(&self) -> KernelVoxels {
        let occupied = self.occupied.address;
        match &self.stored {
            Stored::Coded(codes, table) => {
                let table = table.as_ref().map_or(0, |table| table.address);
                KernelVoxels([codes.address, occupied, table])
            }
            Stored::Dense(density, label) => KernelVoxels([density.address, label.address, occupied]),
        }
    }

    /// Memory of the device that it takes.
    pub(super) fn bytes(&self) -> usize {
        let voxels = match &self.stored {
            Stored::Coded(codes, table) => codes.bytes + table.as_ref().map_or(0, |table| table.bytes),
            Stored::Dense(density, label) => density.bytes + label.bytes,
        };
        voxels + self.occupied.bytes
    }

    /// Bytes per second, read and written, of a copy of the voxels.
    pub(super) fn copy_bandwidth(&self) -> Result<f64> {
        let (Stored::Coded(voxels, _) | Stored::Dense(voxels, _)) = &self.stored;
        let device = &voxels.device;
        let copy = Buffer::new(device, voxels.bytes, "a copy of the voxels")?;
        let current = device.current()?;
        let (stream, start, end) = (Stream::new(&current)?, Event::new(&current)?, Event::new(&current)?);
        // The first copy also makes the memory's pages.
        for _ in 0..2 {
            start.record(&stream)?;
            // SAFETY: both buffers are that long, and outlive the stream's end, which is waited for.
            let copied =
                unsafe { result::memcpy_dtod_async(copy.address, voxels.address, copy.bytes, stream.raw) };
            checked("a copy on the GPU", copied)?;
            end.record(&stream)?;
        }
        stream.finish("a copy on the GPU")?;
        Ok(2.0 * copy.bytes as f64 / end.seconds_since(&start)?)
    }
}
