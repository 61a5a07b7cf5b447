//! Kernels: the text with its definitions, compiled by Metal.

use std::time::Instant;

use objc2::rc::Retained;
use objc2::runtime::{NSObject, ProtocolObject};
use objc2::{ClassType, available};
use objc2_foundation::{NSDictionary, NSString, ns_string};
use objc2_metal::{
    MTLCompileOptions, MTLComputePipelineState, MTLDevice, MTLLanguageVersion, MTLLibrary, MTLMathMode,
};

use crate::engine::gpu::{Definitions, Kernel};
use crate::engine::metal::failure::{none, refused};
use crate::engine::metal::outputs::ImageKind;
use crate::error::Result;

/// What is compiled.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) struct Variant {
    pub definitions: Definitions,
    pub image: Option<ImageKind>,
}

/// A kernel that can be run.
pub(super) type Pipeline = Retained<ProtocolObject<dyn MTLComputePipelineState>>;

/// The kernels of one variant.
pub(super) struct Program {
    /// For a thread per pixel and view.
    pub project: Pipeline,
    /// For a thread per view: makes its own tables ready.
    pub prepare_tables: Pipeline,
    /// Seconds that it took to compile them.
    pub compile_seconds: f64,
}

impl Program {
    /// Compiles them, which takes a second or so; Metal remembers what it has compiled.
    ///
    /// # Errors
    /// `Unsupported`, with the compiler's words.
    pub(super) fn compiled(device: &ProtocolObject<dyn MTLDevice>, variant: &Variant) -> Result<Self> {
        let start = Instant::now();
        let names = [ns_string!("projectPolyenergeticDRR"), ns_string!("prepareViewTables")];
        let [project, prepare_tables] = pipelines(device, Kernel::Projection, &options(variant), names)?;
        Ok(Self { project, prepare_tables, compile_seconds: start.elapsed().as_secs_f64() })
    }
}

/// The kernels of one text.
pub(super) fn pipelines<const N: usize>(
    device: &ProtocolObject<dyn MTLDevice>,
    kernel: Kernel,
    options: &MTLCompileOptions,
    names: [&NSString; N],
) -> Result<[Pipeline; N]> {
    let source = NSString::from_str(kernel.metal());
    let library = device
        .newLibraryWithSource_options_error(&source, Some(options))
        .map_err(|error| refused("the kernels do not compile", &error))?;
    let pipeline = |name: &NSString| {
        let function = library.newFunctionWithName(name).ok_or_else(none("kernel of that name"))?;
        device
            .newComputePipelineStateWithFunction_error(&function)
            .map_err(|error| refused("the kernels cannot be loaded", &error))
    };
    let pipelines = names.into_iter().map(pipeline).collect::<Result<Vec<_>>>()?;
    pipelines.try_into().map_err(|_| none("kernel of that name")())
}

pub(super) fn options(variant: &Variant) -> Retained<MTLCompileOptions> {
    let options = MTLCompileOptions::new();
    options.setLanguageVersion(MTLLanguageVersion::Version3_0);
    // Sums of twofold numbers are what fast math would simplify away.
    if available!(macos = 15.0, ios = 18.0, tvos = 18.0, visionos = 2.0, ..) {
        options.setMathMode(MTLMathMode::Safe);
    } else {
        #[expect(deprecated, reason = "mathMode is newer than the oldest macOS that is supported")]
        options.setFastMathEnabled(false);
    }
    let image = variant.image.map(|image| ("DRR_IMAGE_TEXTURE", image as u32));
    let (names, values): (Vec<_>, Vec<_>) = variant
        .definitions
        .iter()
        .chain(image)
        .map(|(name, value)| (NSString::from_str(name), NSString::from_str(&value.to_string())))
        .unzip();
    let names: Vec<&NSString> = names.iter().map(|name| &**name).collect();
    let values: Vec<&NSObject> = values.iter().map(|value| value.as_super()).collect();
    let macros = NSDictionary::from_slices(&names, &values);
    // SAFETY: names and values are strings, which preprocessor macros may be.
    unsafe { options.setPreprocessorMacros(Some(&macros)) };
    options
}
