//! One launch of the kernel: some views of a job.

use std::ffi::c_void;
use std::mem::ManuallyDrop;

use cudarc::driver::{result, sys};

use crate::engine::Layers;
use crate::engine::cuda::Cuda;
use crate::engine::cuda::driver::{Current, Event, Stream, checked};
use crate::engine::cuda::outputs::{Places, SignalPlaces};
use crate::engine::cuda::program::Program;
use crate::engine::gpu::Views;
use crate::engine::gpu::wire::Beam;
use crate::error::Result;

/// `DrrSpectra` of `shaders/spectrum.h`.
#[repr(C)]
struct KernelSpectra {
    weight: sys::CUdeviceptr,
    attenuation: sys::CUdeviceptr,
}

/// Tables and beams in one block of bytes, and where attenuation and beams begin: weights come first, so that both tables
/// are aligned as the kernel reads them, by fours.
fn packed(views: &Views) -> (Vec<u8>, [usize; 2]) {
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_ne_bytes()).collect::<Vec<_>>();
    // SAFETY: plain numbers without padding (`wire.rs` asserts the size), read as bytes.
    let beams = unsafe {
        std::slice::from_raw_parts(views.beams.as_ptr().cast::<u8>(), size_of::<Beam>() * views.beams.len())
    };
    let mut bytes = floats(&views.spectra.weights);
    let attenuation = bytes.len();
    bytes.extend(floats(&views.spectra.attenuation));
    let first_beam = bytes.len();
    bytes.extend(beams);
    (bytes, [attenuation, first_beam])
}

/// Bytes of the host's that a stream is still to read: the driver need not take a copy of them. Those of a call that fails
/// half-way are never given back, because whether the stream reads them is not known.
struct Kept(ManuallyDrop<Vec<u8>>);

impl Kept {
    fn new(bytes: Vec<u8>) -> Self {
        Self(ManuallyDrop::new(bytes))
    }

    fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Gives them back once the stream has run what it holds now.
    fn until(self, stream: sys::CUstream) -> Result<()> {
        unsafe extern "C" fn give_back(bytes: *mut c_void) {
            // SAFETY: made of a box below, for this one call.
            drop(unsafe { Box::from_raw(bytes.cast::<Vec<u8>>()) });
        }
        let bytes = Box::into_raw(Box::new(ManuallyDrop::into_inner(self.0)));
        // SAFETY: the function has the driver's signature and calls nothing of CUDA's; it gets the box once.
        checked("the stream", unsafe {
            result::stream::launch_host_function(stream, give_back, bytes.cast())
        })
    }
}

/// A stream that is waited for, and the moments before and after the kernel; or one of the caller's.
pub(super) struct Queue<'a> {
    pub(super) stream: sys::CUstream,
    pub(super) current: &'a Current,
    pub(super) clock: Option<(&'a Stream<'a>, [&'a Event<'a>; 2])>,
}

impl Cuda {
    /// Puts a launch into a stream, with all that it needs.
    ///
    /// # Safety
    /// `places` has room for the wanted layers of the views, until the stream has run it, and so have those of the signals,
    /// which are there if the views have channels; the stream is alive.
    pub(super) unsafe fn enqueue(
        &self,
        views: &Views,
        layers: Layers,
        program: &Program,
        (places, signals): (Places, Option<SignalPlaces>),
        queue: &Queue<'_>,
    ) -> Result<()> {
        let pixels = self.prepared.size[0] * self.prepared.size[1] * views.beams.len();
        let (bytes, [attenuation, first_beam]) = packed(views);
        let lent = self.device.lend("a launch's views", bytes.len(), queue.stream, queue.current)?;
        let kept = Kept::new(bytes);
        // SAFETY: lent for as many bytes; these are kept until the stream has read them.
        checked("a launch's views", unsafe {
            result::memcpy_htod_async(lent.address, kept.bytes(), queue.stream)
        })?;
        if layers.bone_path {
            // A kernel for a volume without bone does not write it.
            // SAFETY: the place has room by the caller's promise.
            checked("the bone path's zeros", unsafe {
                result::memset_d8_async(places.bone_path, 0, pixels * size_of::<f32>(), queue.stream)
            })?;
        }
        let mut launch = views.launch;
        let mut beams = lent.address + first_beam as u64;
        let mut voxels = self.volume.parameter();
        let mut spectra =
            KernelSpectra { weight: lent.address, attenuation: lent.address + attenuation as u64 };
        let mut places = places;
        let mut parameters: Vec<*mut c_void> = vec![
            (&raw mut launch).cast(),
            (&raw mut beams).cast(),
            (&raw mut voxels).cast(),
            (&raw mut spectra).cast(),
            (&raw mut places).cast(),
        ];
        let mut of_signals = views.channels.zip(signals);
        if let Some((channels, signals)) = &mut of_signals {
            parameters.extend([(&raw mut *channels).cast(), (&raw mut *signals).cast()]);
        }
        let [columns, rows] = self.block;
        let [width, height] = self.prepared.size.map(|n| n as u32);
        let grid = (width.div_ceil(columns) * views.beams.len() as u32, height.div_ceil(rows), 1);
        if let Some((stream, [start, _])) = queue.clock {
            start.record(stream)?;
        }
        // SAFETY: the parameters are those of `shaders/drr.cu` by type and order, and are copied during the call; the
        // arrays are as long as the launch says. A layout that the kernel does not have makes its struct shorter.
        checked("the kernel", unsafe {
            let block = (columns, rows, 1);
            result::launch_kernel(program.function, grid, block, 0, queue.stream, &mut parameters)
        })?;
        if let Some((stream, [_, end])) = queue.clock {
            end.record(stream)?;
        }
        kept.until(queue.stream)
    }
}
