//! An Apple GPU, and what projectors on it share.

use std::ffi::{CStr, CString, c_void};
use std::ptr::NonNull;
use std::sync::Arc;

use objc2::available;
use objc2::rc::{Retained, autoreleasepool};
use objc2::runtime::ProtocolObject;
use objc2_foundation::NSProcessInfo;
use objc2_metal::{
    MTLCommandBuffer, MTLCommandBufferStatus, MTLCommandQueue, MTLCreateSystemDefaultDevice, MTLDevice,
    MTLGPUFamily,
};

use crate::engine::gpu::{Definitions, Programs, Volumes};
use crate::engine::metal::failure::none;
use crate::engine::metal::parallel;
use crate::engine::metal::program::{Program, Variant};
use crate::engine::metal::volume::DeviceVolume;
use crate::error::{Error, Result};
use crate::volume::Volume;

// MTLCreateSystemDefaultDevice finds no device in a program that does not link to it.
#[link(name = "CoreGraphics", kind = "framework")]
unsafe extern "C" {}

/// A GPU, its kernels and the volumes on it. May be used from many threads at once.
pub(crate) struct Device {
    name: CString,
    gpu: Retained<ProtocolObject<dyn MTLDevice>>,
    queue: Retained<ProtocolObject<dyn MTLCommandQueue>>,
    programs: Programs<Variant, Program>,
    parallel_programs: Programs<Definitions, parallel::Program>,
    volumes: Volumes<DeviceVolume>,
}

impl Device {
    /// A GPU of the caller's choice, an `id<MTLDevice>` that is kept alive; or the one that this machine prefers.
    ///
    /// # Errors
    /// `Unsupported` before macOS 13, and where there is no GPU with Metal 3.
    pub(crate) fn open(choice: Option<NonNull<c_void>>) -> Result<Self> {
        check_system()?;
        autoreleasepool(|_| {
            let gpu = match choice {
                // SAFETY: such an object, by the promise of whoever made the choice.
                Some(device) => unsafe { Retained::retain(device.cast().as_ptr()) },
                None => MTLCreateSystemDefaultDevice(),
            };
            Self::of(gpu.ok_or_else(none("GPU"))?)
        })
    }

    fn of(gpu: Retained<ProtocolObject<dyn MTLDevice>>) -> Result<Self> {
        // Threadgroups at the detector's edge may be smaller, and buffers may hold GPU addresses.
        if !gpu.supportsFamily(MTLGPUFamily::Metal3) {
            return Err(Error::Unsupported(format!("{} does not have Metal 3", gpu.name())));
        }
        let queue = gpu.newCommandQueue().ok_or_else(none("command queue"))?;
        let name = CString::new(gpu.name().to_string()).unwrap_or_default();
        Ok(Self {
            name,
            gpu,
            queue,
            programs: Programs::default(),
            parallel_programs: Programs::default(),
            volumes: Volumes::default(),
        })
    }

    /// The GPU's name.
    pub(crate) fn name(&self) -> &CStr {
        &self.name
    }

    /// Metal comes with the system.
    pub(crate) fn driver() -> String {
        autoreleasepool(|_| format!("macOS {}", NSProcessInfo::processInfo().operatingSystemVersionString()))
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

    /// A command buffer of the caller's.
    ///
    /// # Errors
    /// `InvalidArgument` when nothing can be encoded into it, or it would not keep what it uses.
    ///
    /// # Safety
    /// `queue` is null or an `id<MTLCommandBuffer>`.
    pub(super) unsafe fn callers_command_buffer(
        &self,
        queue: *mut c_void,
    ) -> Result<Retained<ProtocolObject<dyn MTLCommandBuffer>>> {
        let invalid = |value: &str| {
            let valid = "an id<MTLCommandBuffer> of the context's GPU that retains its references and is not committed";
            Error::invalid("queue", value, valid)
        };
        // SAFETY: the caller's promise.
        let commands: Option<Retained<ProtocolObject<dyn MTLCommandBuffer>>> =
            unsafe { Retained::retain(queue.cast()) };
        let commands = commands.ok_or_else(|| invalid("NULL"))?;
        if !self.is(&commands.device()) {
            return Err(invalid(&format!("of {}", commands.device().name())));
        }
        if !commands.retainedReferences() {
            return Err(invalid("without retained references"));
        }
        let status = commands.status();
        if status != MTLCommandBufferStatus::NotEnqueued && status != MTLCommandBufferStatus::Enqueued {
            return Err(invalid("committed"));
        }
        Ok(commands)
    }

    /// Kernels, compiled if they are new.
    pub(super) fn program(&self, variant: &Variant) -> Result<Arc<Program>> {
        self.programs.get(variant, || Program::compiled(&self.gpu, variant))
    }

    /// Kernels of parallel beams, compiled if they are new.
    pub(super) fn parallel_program(&self, definitions: &Definitions) -> Result<Arc<parallel::Program>> {
        self.parallel_programs.get(definitions, || parallel::Program::compiled(&self.gpu, definitions))
    }

    /// A volume on this device, brought there if no projector has it there.
    pub(super) fn volume(&self, volume: &Arc<Volume>) -> Result<Arc<DeviceVolume>> {
        self.volumes.get(volume, || DeviceVolume::new(self, volume))
    }
}

/// GPU addresses, and the version of Metal's language that has them, came with macOS 13.
fn check_system() -> Result<()> {
    if available!(macos = 13.0, ios = 16.0, tvos = 16.0, visionos = 1.0, ..) {
        return Ok(());
    }
    Err(Error::Unsupported("the engine metal needs macOS 13 or later".into()))
}
