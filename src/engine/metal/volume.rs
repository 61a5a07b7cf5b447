//! A volume on the GPU.

use std::ffi::c_void;
use std::ptr::NonNull;
use std::time::Instant;

use objc2::rc::autoreleasepool;
use objc2::runtime::ProtocolObject;
use objc2_metal::{
    MTLBuffer, MTLComputeCommandEncoder, MTLDevice, MTLPixelFormat, MTLResource, MTLTexture, MTLTextureType,
    MTLTextureUsage,
};

use crate::engine::gpu::{DeviceVoxels, Slab};
use crate::engine::metal::Device;
use crate::engine::metal::objects::{Buffer, TextureObject};
use crate::error::{Error, Result};
use crate::volume::{Volume, Voxels};

/// A 3D texture of int16 HU that the caller's pipeline has on the GPU, for
/// [`Volume::from_texture`](crate::volume::Volume::from_texture). It is kept alive; its texels are read when views are
/// projected, and must not be written meanwhile.
pub(crate) struct Texture {
    object: TextureObject,
}

impl Texture {
    /// Checks the texture for a volume of these dimensions.
    ///
    /// # Errors
    /// `InvalidArgument` when it is not such a texture, or on another GPU.
    ///
    /// # Safety
    /// `texture` is an `id<MTLTexture>`.
    pub(crate) unsafe fn retained(
        device: &Device,
        texture: NonNull<c_void>,
        dimensions: [usize; 3],
    ) -> Result<Self> {
        autoreleasepool(|_| {
            // SAFETY: the caller's promise.
            let object = unsafe { TextureObject::retained(texture) };
            check(device, &object, dimensions)?;
            Ok(Self { object })
        })
    }
}

fn check(device: &Device, texture: &ProtocolObject<dyn MTLTexture>, dimensions: [usize; 3]) -> Result<()> {
    if !device.is(&texture.device()) {
        return Err(Error::invalid(
            "texture's GPU",
            texture.device().name(),
            device.name().to_string_lossy(),
        ));
    }
    if texture.textureType() != MTLTextureType::Type3D {
        return Err(Error::invalid("texture's type", texture.textureType().0, "MTLTextureType3D"));
    }
    if texture.pixelFormat() != MTLPixelFormat::R16Sint {
        return Err(Error::invalid("texture's format", texture.pixelFormat().0, "MTLPixelFormatR16Sint"));
    }
    if !texture.usage().contains(MTLTextureUsage::ShaderRead) {
        return Err(Error::invalid("texture's usage", texture.usage().0, "with MTLTextureUsageShaderRead"));
    }
    let size = [texture.width(), texture.height(), texture.depth()];
    if size != dimensions {
        let valid = format!("{dimensions:?}, the descriptor's dimensions");
        return Err(Error::invalid("texture's size", format!("{size:?}"), valid));
    }
    Ok(())
}

/// What the kernel reads of a volume.
pub(super) struct DeviceVolume {
    /// How it is stored.
    pub voxels: DeviceVoxels,
    /// Seconds that it took to make it.
    pub upload_seconds: f64,
    stored: Stored,
    density_of_value: Buffer,
    occupied: Buffer,
}

enum Stored {
    Coded(Buffer),
    Dense(Buffer, Buffer),
    Texture(TextureObject, Buffer),
}

impl DeviceVolume {
    /// Brings a volume to the GPU, unless it is there.
    ///
    /// # Errors
    /// `Unsupported` for a volume that is too large, or in a texture that is not Metal's; `OutOfMemory`.
    pub(super) fn new(device: &Device, volume: &Volume) -> Result<Self> {
        let start = Instant::now();
        let voxels = DeviceVoxels::new(volume)?;
        let count: usize = voxels.framed().iter().product();
        let buffer = |bytes: usize| Buffer::new(device.gpu(), bytes, "the volume's voxels");
        let stored = match volume.voxels() {
            Voxels::Coded { .. } => Stored::Coded(buffer(count * size_of::<u16>())?),
            Voxels::Dense { .. } => Stored::Dense(buffer(count * size_of::<f32>())?, buffer(count)?),
            Voxels::Texture { texture, .. } => {
                let Some(texture) = texture.downcast_ref::<Texture>() else {
                    return Err(Error::Unsupported("the volume's texture is not one of Metal's".into()));
                };
                check(device, &texture.object, volume.grid().dimensions())?;
                let codes = Buffer::of(device.gpu(), &voxels.codes_of_hu(), "the table of codes")?;
                Stored::Texture(texture.object.clone(), codes)
            }
        };
        voxels.slabs(volume, |first, slab| {
            match (&stored, slab) {
                (Stored::Coded(all), Slab::Coded(codes)) => all.write(first, codes),
                (Stored::Dense(densities, labels), Slab::Dense(density, label)) => {
                    densities.write(first, density);
                    labels.write(first, label);
                }
                _ => unreachable!("slabs are laid out as the voxels say"),
            }
            Ok(())
        })?;
        let density_of_value = Buffer::of(device.gpu(), voxels.density_of_value(), "the table of densities")?;
        let occupied = Buffer::of(device.gpu(), &voxels.occupancy(volume)?, "the volume's occupancy")?;
        let upload_seconds = start.elapsed().as_secs_f64();
        Ok(Self { voxels, upload_seconds, stored, density_of_value, occupied })
    }

    /// The largest buffer of voxels; none for a texture, which is the caller's.
    pub(super) fn largest(&self) -> Option<&Buffer> {
        match &self.stored {
            Stored::Coded(voxels) | Stored::Dense(voxels, _) => Some(voxels),
            Stored::Texture(..) => None,
        }
    }

    /// Bytes of the GPU's memory.
    pub(super) fn bytes(&self) -> usize {
        let voxels = match &self.stored {
            Stored::Coded(codes) | Stored::Texture(_, codes) => codes.length(),
            Stored::Dense(densities, labels) => densities.length() + labels.length(),
        };
        voxels + self.density_of_value.length() + self.occupied.length()
    }

    /// Gives the kernel its arguments.
    pub(super) fn bind(&self, encoder: &ProtocolObject<dyn MTLComputeCommandEncoder>) {
        // SAFETY: the indices of `shaders/drr.metal`, and what the kernel was compiled for: texture and buffers as long
        // as its launch says.
        unsafe {
            match &self.stored {
                Stored::Coded(codes) => encoder.setBuffer_offset_atIndex(Some(codes), 0, 5),
                Stored::Dense(densities, labels) => {
                    encoder.setBuffer_offset_atIndex(Some(densities), 0, 5);
                    encoder.setBuffer_offset_atIndex(Some(labels), 0, 6);
                }
                Stored::Texture(texture, codes) => {
                    encoder.setTexture_atIndex(Some(texture), 0);
                    encoder.setBuffer_offset_atIndex(Some(codes), 0, 5);
                }
            }
            encoder.setBuffer_offset_atIndex(Some(&self.density_of_value), 0, 7);
            encoder.setBuffer_offset_atIndex(Some(&self.occupied), 0, 12);
        }
    }
}
