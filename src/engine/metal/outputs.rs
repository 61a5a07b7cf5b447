//! Where the kernel leaves the layers.

use std::ffi::c_void;
use std::ptr::NonNull;

use objc2::runtime::ProtocolObject;
use objc2_foundation::NSRange;
use objc2_metal::{
    MTLBlitCommandEncoder, MTLBuffer, MTLCommandBuffer, MTLCommandEncoder, MTLComputeCommandEncoder,
    MTLDevice, MTLPixelFormat, MTLResource, MTLTexture, MTLTextureType, MTLTextureUsage,
};

use crate::engine::gpu::Prepared;
use crate::engine::metal::Device;
use crate::engine::metal::failure::none;
use crate::engine::metal::objects::{Buffer, TextureObject};
use crate::engine::{DeviceOutputs, Images, Layers, Passed, SignalsJob};
use crate::error::{Error, Result};

/// What the kernel calls the type of the image texture: `DRR_IMAGE_TEXTURE`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum ImageKind {
    /// 2D, for one view.
    OneView = 1,
    /// An array of 2D images, one per view.
    AllViews = 2,
}

/// Buffers of the layers, each with room for all views of a launch, and a texture.
pub(super) struct Outputs {
    intensity: Option<Buffer>,
    line_integral: Option<Buffer>,
    areal_density: Option<Buffer>,
    bone_path: Option<Buffer>,
    image: Option<(TextureObject, ImageKind)>,
    signals: Option<Signals>,
}

/// Buffers of what is summed by several rows of weights.
struct Signals {
    before: Buffer,
    passing: Buffer,
    open: Buffer,
}

impl Outputs {
    /// Buffers of our own.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(super) fn new(device: &Device, prepared: &Prepared, views: usize, layers: Layers) -> Result<Self> {
        let plane = prepared.size[0] * prepared.size[1] * size_of::<f32>();
        let buffer = |wanted: bool, planes: usize| {
            wanted.then(|| Buffer::new(device.gpu(), views * planes * plane, "the images")).transpose()
        };
        Ok(Self {
            intensity: buffer(layers.intensity, 1)?,
            line_integral: buffer(layers.line_integral, 1)?,
            areal_density: buffer(layers.areal_density, prepared.materials)?,
            bone_path: buffer(layers.bone_path, 1)?,
            image: None,
            signals: None,
        })
    }

    /// Buffers of our own, with those of a job's signals.
    ///
    /// # Errors
    /// `OutOfMemory`.
    pub(super) fn of_signals(
        device: &Device,
        prepared: &Prepared,
        views: usize,
        job: &SignalsJob<'_>,
    ) -> Result<Self> {
        let rows = job.rows.len() * prepared.size[0] * prepared.size[1] * size_of::<f32>();
        let signals = Signals {
            before: Buffer::of(device.gpu(), job.before, "what lies before the volume")?,
            passing: Buffer::new(device.gpu(), views * rows, "the signals")?,
            open: Buffer::new(device.gpu(), if job.open { rows } else { 0 }, "the signals")?,
        };
        Ok(Self { signals: Some(signals), ..Self::new(device, prepared, views, job.layers)? })
    }

    /// The caller's.
    ///
    /// # Errors
    /// `InvalidArgument` when one has no room for the views, or is on another GPU; `OutOfMemory`.
    ///
    /// # Safety
    /// The pointers are null or what [`DeviceOutputs`] says.
    pub(super) unsafe fn retained(
        device: &Device,
        prepared: &Prepared,
        views: usize,
        given: &DeviceOutputs,
    ) -> Result<Self> {
        let plane = prepared.size[0] * prepared.size[1] * size_of::<f32>();
        let buffer = |name: &str, pointer: *mut c_void, planes: usize| {
            let Some(pointer) = NonNull::new(pointer) else { return Ok(None) };
            // SAFETY: the caller's promise.
            let buffer = unsafe { Buffer::retained(pointer) };
            check_buffer(device, name, &buffer, views * planes * plane).map(|()| Some(buffer))
        };
        let image = NonNull::new(given.intensity_texture).map(|pointer| {
            // SAFETY: the caller's promise.
            let texture = unsafe { TextureObject::retained(pointer) };
            let kind = check_image(device, &texture, prepared.size, views)?;
            Ok((texture, kind))
        });
        let image = image.transpose()?;
        let mut outputs = Self {
            intensity: buffer("intensity", given.intensity, 1)?,
            line_integral: buffer("line_integral", given.line_integral, 1)?,
            areal_density: buffer("areal_density", given.areal_density, prepared.materials)?,
            bone_path: buffer("bone_path_mm", given.bone_path, 1)?,
            image,
            signals: None,
        };
        // The kernel copies to the texture what it has written to the buffer.
        if outputs.image.is_some() && outputs.intensity.is_none() {
            outputs.intensity = Some(Buffer::new(device.gpu(), views * plane, "the intensity")?);
        }
        Ok(outputs)
    }

    /// Which layers there are.
    pub(super) fn layers(&self) -> Layers {
        Layers {
            intensity: self.intensity.is_some(),
            line_integral: self.line_integral.is_some(),
            areal_density: self.areal_density.is_some(),
            bone_path: self.bone_path.is_some(),
        }
    }

    /// Bytes of all layers.
    pub(super) fn bytes(&self) -> usize {
        let buffers = [&self.intensity, &self.line_integral, &self.areal_density, &self.bone_path];
        let of_signals = self.signals.iter().flat_map(|signals| [&signals.passing, &signals.open]);
        buffers.into_iter().flatten().chain(of_signals).map(|buffer| buffer.length()).sum()
    }

    /// The type of the texture, if there is one.
    pub(super) fn image_kind(&self) -> Option<ImageKind> {
        self.image.as_ref().map(|(_, kind)| *kind)
    }

    /// Gives the kernel its arguments.
    pub(super) fn bind(&self, encoder: &ProtocolObject<dyn MTLComputeCommandEncoder>) {
        let buffers = [&self.intensity, &self.line_integral, &self.areal_density, &self.bone_path];
        for (buffer, index) in buffers.into_iter().zip(8..) {
            // SAFETY: the indices of `shaders/drr.metal`; long enough for the launch's views.
            unsafe { encoder.setBuffer_offset_atIndex(buffer.as_deref(), 0, index) };
        }
        if let Some(Signals { before, passing, open }) = &self.signals {
            for (buffer, index) in [before, passing, open].into_iter().zip(14..) {
                // SAFETY: as above.
                unsafe { encoder.setBuffer_offset_atIndex(Some(buffer), 0, index) };
            }
        }
        if let Some((texture, _)) = &self.image {
            // SAFETY: as large as the detector, and of the type that the kernel was compiled for.
            unsafe { encoder.setTexture_atIndex(Some(texture), 1) };
        }
    }

    /// Makes the bone path 0, where no voxel is bone and the kernel leaves it alone.
    ///
    /// # Errors
    /// `Unsupported` when Metal has no encoder for it.
    pub(super) fn clear_bone_path(
        &self,
        commands: &ProtocolObject<dyn MTLCommandBuffer>,
        bytes: usize,
    ) -> Result<()> {
        let Some(buffer) = &self.bone_path else { return Ok(()) };
        let encoder = commands.blitCommandEncoder().ok_or_else(none("blit encoder"))?;
        encoder.fillBuffer_range_value(buffer, NSRange::new(0, bytes), 0);
        encoder.endEncoding();
        Ok(())
    }

    /// Copies the first `views` views to `images`, from view `first` on.
    pub(super) fn read(&self, images: &mut Images<f32>, first: usize, views: usize) {
        let plane = images.size[0] * images.size[1];
        let materials = images.materials;
        let copy = |from: &Option<Buffer>, to: &mut Vec<f32>, planes: usize| {
            if let Some(buffer) = from {
                buffer.read(&mut to[first * planes * plane..][..views * planes * plane]);
            }
        };
        copy(&self.intensity, &mut images.intensity, 1);
        copy(&self.line_integral, &mut images.line_integral, 1);
        copy(&self.areal_density, &mut images.areal_density, materials);
        copy(&self.bone_path, &mut images.bone_path, 1);
    }
}

impl Outputs {
    /// Copies the signals of the first `views` views, of `planes` numbers each, to their places, from view `first` on.
    pub(super) fn read_signals(&self, passed: &mut Passed, planes: usize, first: usize, views: usize) {
        let Some(signals) = &self.signals else { return };
        signals.passing.read(&mut passed.passing[first * planes..][..views * planes]);
        signals.open.read(&mut passed.open);
    }
}

fn check_buffer(
    device: &Device,
    name: &str,
    buffer: &ProtocolObject<dyn MTLBuffer>,
    bytes: usize,
) -> Result<()> {
    if !device.is(&buffer.device()) {
        return Err(Error::invalid(
            format!("outputs.{name}'s GPU"),
            buffer.device().name(),
            device.name().to_string_lossy(),
        ));
    }
    if buffer.length() < bytes {
        let valid = format!("at least {bytes} bytes");
        return Err(Error::invalid(format!("outputs.{name}'s length"), buffer.length(), valid));
    }
    Ok(())
}

fn check_image(
    device: &Device,
    texture: &TextureObject,
    size: [usize; 2],
    views: usize,
) -> Result<ImageKind> {
    let invalid = |what: &str, value: &dyn std::fmt::Display, valid: String| {
        Error::invalid(format!("outputs.intensity_texture's {what}"), value, valid)
    };
    if !device.is(&texture.device()) {
        return Err(invalid("GPU", &texture.device().name(), device.name().to_string_lossy().into_owned()));
    }
    if texture.pixelFormat() != MTLPixelFormat::R32Float {
        return Err(invalid("format", &texture.pixelFormat().0, "MTLPixelFormatR32Float".into()));
    }
    if !texture.allows(MTLTextureUsage::ShaderWrite) {
        return Err(invalid("usage", &texture.usage().0, "with MTLTextureUsageShaderWrite".into()));
    }
    let given = [texture.width(), texture.height()];
    if given[0] < size[0] || given[1] < size[1] {
        return Err(invalid("size", &format!("{given:?}"), format!("at least {size:?}, the detector's")));
    }
    match texture.textureType() {
        MTLTextureType::Type2D if views == 1 => Ok(ImageKind::OneView),
        MTLTextureType::Type2DArray if texture.arrayLength() >= views => Ok(ImageKind::AllViews),
        other => {
            let valid =
                format!("MTLTextureType2D for one view, MTLTextureType2DArray of at least {views} slices");
            Err(invalid("type", &other.0, valid))
        }
    }
}
