//! An Apple GPU, and what projectors on it share.

use std::collections::HashMap;
use std::ffi::c_void;
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use objc2::available;
use objc2::rc::{Retained, autoreleasepool};
use objc2::runtime::ProtocolObject;
use objc2_metal::{MTLCommandBuffer, MTLCommandQueue, MTLCreateSystemDefaultDevice, MTLDevice};

use crate::engine::metal::failure::none;
use crate::engine::metal::library::{Kernels, Variant};
use crate::engine::metal::volume::DeviceVolume;
use crate::error::{Error, Result};
use crate::volume::Volume;

// MTLCreateSystemDefaultDevice finds no device in a program that does not link to it.
#[link(name = "CoreGraphics", kind = "framework")]
unsafe extern "C" {}

/// Width and height of a threadgroup in pixels, unless a device is told otherwise: the specification's.
const THREADGROUP: [usize; 2] = [16, 16];

/// A GPU, its kernels and the volumes on it. May be used from many threads at once.
pub struct Device {
    gpu: Retained<ProtocolObject<dyn MTLDevice>>,
    queue: Retained<ProtocolObject<dyn MTLCommandQueue>>,
    kernels: Mutex<HashMap<Variant, Arc<Kernels>>>,
    volumes: Mutex<Vec<(Weak<Volume>, Weak<DeviceVolume>)>>,
    threadgroup: [usize; 2],
    last_seconds: AtomicU64,
}

impl Device {
    /// The GPU that this machine prefers.
    ///
    /// # Errors
    /// `Unsupported` before macOS 13, and where there is no GPU.
    pub fn system_default() -> Result<Self> {
        check_system()?;
        autoreleasepool(|_| Self::of(MTLCreateSystemDefaultDevice().ok_or_else(none("GPU"))?))
    }

    /// A GPU of the caller's choice, which is kept alive.
    ///
    /// # Errors
    /// As [`Device::system_default`].
    ///
    /// # Safety
    /// `device` is an `id<MTLDevice>`.
    pub unsafe fn retained(device: NonNull<c_void>) -> Result<Self> {
        check_system()?;
        // SAFETY: the caller's promise.
        let gpu = unsafe { Retained::retain(device.cast().as_ptr()) };
        autoreleasepool(|_| Self::of(gpu.ok_or_else(none("GPU"))?))
    }

    fn of(gpu: Retained<ProtocolObject<dyn MTLDevice>>) -> Result<Self> {
        let queue = gpu.newCommandQueue().ok_or_else(none("command queue"))?;
        Ok(Self {
            gpu,
            queue,
            kernels: Mutex::default(),
            volumes: Mutex::default(),
            threadgroup: THREADGROUP,
            last_seconds: AtomicU64::new(0),
        })
    }

    /// The same device with threadgroups of width × height pixels, which change the speed and no image. What a kernel
    /// cannot have is made lower.
    #[must_use]
    pub fn with_threadgroup(self, [width, height]: [usize; 2]) -> Self {
        Self { threadgroup: [width.max(1), height.max(1)], ..self }
    }

    /// The GPU's name.
    pub fn name(&self) -> String {
        autoreleasepool(|_| self.gpu.name().to_string())
    }

    /// Seconds that the GPU worked for the last call that projected on this device; 0 before the first.
    pub fn last_gpu_seconds(&self) -> f64 {
        f64::from_bits(self.last_seconds.load(Ordering::Relaxed))
    }

    pub(super) fn set_last_gpu_seconds(&self, seconds: f64) {
        self.last_seconds.store(seconds.to_bits(), Ordering::Relaxed);
    }

    pub(super) fn gpu(&self) -> &ProtocolObject<dyn MTLDevice> {
        &self.gpu
    }

    /// Whether an object of that GPU is one of this.
    pub(super) fn is(&self, gpu: &ProtocolObject<dyn MTLDevice>) -> bool {
        self.gpu.registryID() == gpu.registryID()
    }

    pub(super) fn command_buffer(&self) -> Result<Retained<ProtocolObject<dyn MTLCommandBuffer>>> {
        self.queue.commandBuffer().ok_or_else(none("command buffer"))
    }

    /// Width and height of the threadgroups of a kernel that can have `most` threads in one.
    pub(super) fn threadgroup(&self, most: usize) -> [usize; 2] {
        let [width, height] = self.threadgroup;
        let width = width.min(most);
        [width, height.min(most / width)]
    }

    /// Kernels, compiled if they are new.
    pub(super) fn kernels(&self, variant: Variant) -> Result<Arc<Kernels>> {
        let mut kernels = self.kernels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kernels.get(&variant) {
            return Ok(known.clone());
        }
        let compiled = Arc::new(Kernels::compiled(&self.gpu, &variant)?);
        kernels.insert(variant, compiled.clone());
        Ok(compiled)
    }

    /// A volume on this device, brought there if no projector has it there.
    pub(super) fn volume(&self, volume: &Arc<Volume>) -> Result<Arc<DeviceVolume>> {
        if let Some(known) = self.known_volume(volume) {
            return Ok(known);
        }
        // Not under the lock: what brings it there runs on threads that may be given another call of this function.
        let made = Arc::new(DeviceVolume::new(self, volume)?);
        // Another thread may have been faster.
        Ok(self.known_volume(volume).unwrap_or_else(|| {
            self.volumes().push((Arc::downgrade(volume), Arc::downgrade(&made)));
            made
        }))
    }

    fn known_volume(&self, volume: &Arc<Volume>) -> Option<Arc<DeviceVolume>> {
        let mut volumes = self.volumes();
        volumes.retain(|(_, on_device)| on_device.strong_count() > 0);
        let known = volumes.iter().find(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(volume)));
        known.and_then(|(_, on_device)| on_device.upgrade())
    }

    fn volumes(&self) -> MutexGuard<'_, Vec<(Weak<Volume>, Weak<DeviceVolume>)>> {
        self.volumes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// GPU addresses, and the version of Metal's language that has them, came with macOS 13.
fn check_system() -> Result<()> {
    if available!(macos = 13.0, ios = 16.0, tvos = 16.0, visionos = 1.0, ..) {
        return Ok(());
    }
    Err(Error::Unsupported("the engine metal needs macOS 13 or later".into()))
}
