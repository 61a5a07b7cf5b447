//! Metal's buffers and textures, which the bindings do not know to be safe to share between threads.

use std::ffi::c_void;
use std::ops::Deref;
use std::ptr::NonNull;

use objc2::rc::Retained;
use objc2::runtime::ProtocolObject;
use objc2_metal::{MTLBuffer, MTLDevice, MTLResourceOptions, MTLTexture};

use crate::error::{Error, Result};

/// A buffer.
#[derive(Clone)]
pub(super) struct Buffer(Retained<ProtocolObject<dyn MTLBuffer>>);

// SAFETY: reference counts are atomic, and Apple lets any thread ask a resource for its properties and encode it. What
// is not ordered by Metal are reads and writes of the contents: buffers of a volume are written before they are shared, and
// all others are used by one call.
unsafe impl Send for Buffer {}
// SAFETY: as for Send; no method that is called on a shared buffer changes the object.
unsafe impl Sync for Buffer {}

impl Deref for Buffer {
    type Target = ProtocolObject<dyn MTLBuffer>;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl Buffer {
    /// Memory that host and GPU share; `what` is for the message.
    ///
    /// # Errors
    /// `Unsupported` when the GPU has no buffers of that size; `OutOfMemory`.
    pub(super) fn new(device: &ProtocolObject<dyn MTLDevice>, bytes: usize, what: &str) -> Result<Self> {
        let most = device.maxBufferLength();
        if bytes > most {
            let text = format!("{what} take {bytes} bytes; a buffer of this GPU holds at most {most}");
            return Err(Error::Unsupported(text));
        }
        // Metal has no buffers of no bytes.
        let buffer = device.newBufferWithLength_options(bytes.max(4), MTLResourceOptions::StorageModeShared);
        buffer.map(Self).ok_or_else(|| Error::OutOfMemory { what: what.to_owned(), bytes })
    }

    /// A buffer with a copy of `values`.
    ///
    /// # Errors
    /// As for [`Buffer::new`].
    pub(super) fn of<T: Copy>(
        device: &ProtocolObject<dyn MTLDevice>,
        values: &[T],
        what: &str,
    ) -> Result<Self> {
        let buffer = Self::new(device, size_of_val(values), what)?;
        buffer.write(0, values);
        Ok(buffer)
    }

    /// Copies `values` to where the value number `first` is.
    ///
    /// # Panics
    /// When they do not fit.
    pub(super) fn write<T: Copy>(&self, first: usize, values: &[T]) {
        assert!((first + values.len()) * size_of::<T>() <= self.length(), "the buffer is long enough");
        // SAFETY: inside the buffer, which the host can write to and nobody else uses yet; `T` is as aligned as any
        // buffer is.
        unsafe {
            let place = self.contents().cast::<T>().add(first);
            place.copy_from_nonoverlapping(NonNull::from(values).cast(), values.len());
        }
    }

    /// Copies what the GPU has left here.
    ///
    /// # Panics
    /// When there is less.
    pub(super) fn read(&self, values: &mut [f32]) {
        assert!(size_of_val(values) <= self.length(), "the buffer is long enough");
        let count = values.len();
        // SAFETY: inside the buffer, whose last command has completed.
        unsafe {
            let place = self.contents().cast::<f32>();
            place.copy_to_nonoverlapping(NonNull::from(values).cast(), count);
        }
    }

    /// A buffer of the caller's.
    ///
    /// # Safety
    /// `buffer` is an `id<MTLBuffer>`.
    pub(super) unsafe fn retained(buffer: NonNull<c_void>) -> Self {
        // SAFETY: the caller's promise.
        let buffer = unsafe { Retained::retain(buffer.cast().as_ptr()) };
        Self(buffer.expect("it is not null"))
    }
}

/// A texture.
#[derive(Clone)]
pub(super) struct TextureObject(Retained<ProtocolObject<dyn MTLTexture>>);

// SAFETY: as for Buffer; the contents are the caller's, who promises not to write them while they are read.
unsafe impl Send for TextureObject {}
// SAFETY: as for Send.
unsafe impl Sync for TextureObject {}

impl Deref for TextureObject {
    type Target = ProtocolObject<dyn MTLTexture>;
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl TextureObject {
    /// A texture of the caller's.
    ///
    /// # Safety
    /// `texture` is an `id<MTLTexture>`.
    pub(super) unsafe fn retained(texture: NonNull<c_void>) -> Self {
        // SAFETY: the caller's promise.
        let texture = unsafe { Retained::retain(texture.cast().as_ptr()) };
        Self(texture.expect("it is not null"))
    }
}
