//! A GPU by its index, and what its projectors share.

use std::collections::HashMap;
use std::ffi::{CStr, CString};
use std::marker::PhantomData;
use std::sync::{Arc, LazyLock, Mutex, PoisonError, Weak};

use cudarc::driver::{result, sys};

use crate::allocation::filled;
use crate::engine::cuda::driver::{self, Current, allocated, checked};
use crate::engine::cuda::program::{Program, Target};
use crate::engine::cuda::volume::DeviceVolume;
use crate::engine::gpu::{Definitions, Kernel, Programs, Volumes};
use crate::error::{Error, Result};
use crate::volume::Volume;

/// Memory for launches that the device keeps between them.
const KEPT: u64 = 256 << 20;

/// An NVIDIA GPU.
pub(crate) struct Device {
    ordinal: sys::CUdevice,
    context: sys::CUcontext,
    pool: sys::CUmemoryPool,
    name: CString,
    driver: [i32; 2],
    target: Target,
    programs: Programs<(Kernel, Definitions, u32), Program>,
    volumes: Volumes<DeviceVolume>,
}

// SAFETY: context and pool may be used from any thread; the driver locks what needs it.
unsafe impl Send for Device {}
// SAFETY: as above.
unsafe impl Sync for Device {}

/// The devices that are open: contexts on one share its programs and volumes.
static DEVICES: LazyLock<Mutex<HashMap<usize, Weak<Device>>>> = LazyLock::new(Mutex::default);

/// A device that fails when it is opened is none.
fn not_there(error: Error) -> Error {
    match error {
        Error::Device(text) => Error::Unsupported(text),
        other => other,
    }
}

impl Device {
    /// The device at `index`, opened if it is not.
    ///
    /// # Errors
    /// `Unsupported`, with what is missing; `InvalidArgument` for an index beyond the last.
    pub(crate) fn open(index: usize) -> Result<Arc<Self>> {
        driver::start()?;
        let count = checked("the number of GPUs", result::device::get_count()).map_err(not_there)?;
        if count < 1 {
            return Err(Error::Unsupported("no NVIDIA GPU".into()));
        }
        let ordinal = i32::try_from(index).ok().filter(|&ordinal| ordinal < count);
        let Some(ordinal) = ordinal else {
            return Err(Error::invalid("device_index", index, format!("0 … {}", count - 1)));
        };
        let mut devices = DEVICES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(device) = devices.get(&index).and_then(Weak::upgrade) {
            return Ok(device);
        }
        let device = Arc::new(Self::opened(ordinal).map_err(not_there)?);
        devices.insert(index, Arc::downgrade(&device));
        Ok(device)
    }

    fn opened(ordinal: i32) -> Result<Self> {
        use sys::CUdevice_attribute as Attribute;
        let ordinal = checked("the GPU", result::device::get(ordinal))?;
        let name = checked("the GPU's name", result::device::get_name(ordinal))?;
        // SAFETY: the driver gave the device.
        let attribute = |which: Attribute| unsafe { result::device::get_attribute(ordinal, which) };
        let capability = checked("the GPU's capability", {
            attribute(Attribute::CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR).and_then(|major| {
                let minor = attribute(Attribute::CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR)?;
                Ok(10 * major as u32 + minor as u32)
            })
        })?;
        let pools = attribute(Attribute::CU_DEVICE_ATTRIBUTE_MEMORY_POOLS_SUPPORTED);
        if checked("the GPU's memory pools", pools)? == 0 {
            return Err(Error::Unsupported(format!("{name} has no memory pools")));
        }
        let (target, driver) = (Target::of(capability)?, driver::driver_version()?);
        let pool = pool(ordinal)?;
        // SAFETY: the driver gave the device.
        let context = match unsafe { result::primary_ctx::retain(ordinal) } {
            Ok(context) => context,
            Err(error) => {
                // SAFETY: made above, and not used.
                let _ = unsafe { sys::cuMemPoolDestroy(pool) };
                return checked("the GPU's context", Err(error));
            }
        };
        Ok(Self {
            ordinal,
            context,
            pool,
            name: CString::new(name).unwrap_or_default(),
            driver,
            target,
            programs: Programs::default(),
            volumes: Volumes::default(),
        })
    }

    /// Its name.
    pub(crate) fn name(&self) -> &CStr {
        &self.name
    }

    /// The driver, in words.
    pub(crate) fn driver(&self) -> String {
        format!("CUDA {}.{}", self.driver[0], self.driver[1])
    }

    /// Makes the device current on this thread.
    pub(super) fn current(&self) -> Result<Current> {
        // SAFETY: the context lives as long as the device, which whoever calls the driver holds.
        unsafe { Current::new(self.context) }
    }

    /// A kernel with these definitions for blocks of `threads`, compiled if it is new.
    pub(super) fn program(
        &self,
        kernel: Kernel,
        definitions: &Definitions,
        threads: u32,
        _: &Current,
    ) -> Result<Arc<Program>> {
        self.programs.get(&(kernel, definitions.clone(), threads), || {
            Program::new(kernel, definitions, threads, self.target)
        })
    }

    /// The volume as this device holds it, copied there if it is new.
    pub(super) fn volume(self: &Arc<Self>, volume: &Arc<Volume>) -> Result<Arc<DeviceVolume>> {
        self.volumes.get(volume, || DeviceVolume::new(self, volume))
    }

    /// Memory that is lent to what `stream` is given until the value is dropped.
    pub(super) fn lend<'a>(
        &self,
        what: &str,
        bytes: usize,
        stream: sys::CUstream,
        _: &'a Current,
    ) -> Result<Lent<'a>> {
        let mut address = 0;
        // SAFETY: a place for the address; the pool is alive. A size of 0 is refused by the driver.
        let called =
            unsafe { sys::cuMemAllocFromPoolAsync(&raw mut address, bytes.max(1), self.pool, stream) };
        allocated(what, bytes, called.result())?;
        Ok(Lent { address, stream, current: PhantomData })
    }

    /// The floats at an address of the device's.
    ///
    /// # Safety
    /// What is there, if anything, is not written meanwhile.
    pub(crate) unsafe fn floats(&self, argument: &str, address: u64, count: usize) -> Result<Vec<f32>> {
        let refused = |valid: String| Err(Error::invalid(argument, format!("{address:#x}"), valid));
        if !address.is_multiple_of(align_of::<f32>() as u64) {
            return refused(format!("aligned to {} bytes", align_of::<f32>()));
        }
        let mut values = filled(count, 0.0_f32, "a view's table")?;
        let _current = self.current()?;
        // SAFETY: `values` has room; the driver knows its own addresses and refuses others.
        match unsafe { result::memcpy_dtoh_sync(&mut values, address) } {
            Err(error) if error.0 == sys::CUresult::CUDA_ERROR_INVALID_VALUE => {
                refused(format!("an address of {count} floats on the GPU"))
            }
            copied => checked(argument, copied).map(|()| values),
        }
    }
}

/// Memory of a device for what runs in its streams, which costs no call of the system's.
fn pool(ordinal: sys::CUdevice) -> Result<sys::CUmemoryPool> {
    // SAFETY: numbers, a union of numbers and a pointer, for all of which zeros are a value.
    let mut properties: sys::CUmemPoolProps = unsafe { std::mem::zeroed() };
    properties.allocType = sys::CUmemAllocationType::CU_MEM_ALLOCATION_TYPE_PINNED;
    properties.location.type_ = sys::CUmemLocationType::CU_MEM_LOCATION_TYPE_DEVICE;
    properties.location.__bindgen_anon_1.id = ordinal;
    let (mut pool, mut kept) = (std::ptr::null_mut(), KEPT);
    let threshold = sys::CUmemPool_attribute::CU_MEMPOOL_ATTR_RELEASE_THRESHOLD;
    // SAFETY: the properties outlive the call, which writes the pool; the attribute is 64 bits.
    checked("the GPU's memory pool", unsafe {
        sys::cuMemPoolCreate(&raw mut pool, &raw const properties)
            .result()
            .and_then(|()| sys::cuMemPoolSetAttribute(pool, threshold, (&raw mut kept).cast()).result())
    })?;
    Ok(pool)
}

impl Drop for Device {
    fn drop(&mut self) {
        if let Ok(_current) = self.current() {
            // Their modules are the context's.
            self.programs = Programs::default();
            // SAFETY: nobody else has the device. The pool ends once the last that it lent is given back.
            let _ = unsafe { sys::cuMemPoolDestroy(self.pool) };
        }
        // SAFETY: retained when the device was opened.
        let _ = unsafe { result::primary_ctx::release(self.ordinal) };
    }
}

/// Memory that what was put into a stream may use; given back when the stream comes to that.
pub(super) struct Lent<'a> {
    pub(super) address: sys::CUdeviceptr,
    stream: sys::CUstream,
    current: PhantomData<&'a Current>,
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        // SAFETY: lent in that stream, and whatever uses it was put in before.
        let _ = unsafe { result::free_async(self.address, self.stream) };
    }
}
