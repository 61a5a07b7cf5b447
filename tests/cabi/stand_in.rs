//! The CUDA engine where there is no NVIDIA GPU: stand-ins for NVIDIA's driver and run-time compiler, which run the
//! kernel's text for CUDA on the host and hold the engine to the driver's rules.

use std::path::PathBuf;

use libtest_mimic::Failed;

use crate::toolchain::{Compiler, Library, launch, run, scratch};
use crate::{program, root};

/// A folder with the stand-ins, by the names that the loader looks for.
fn libraries(compiler: &Compiler) -> Result<PathBuf, Failed> {
    let folder = scratch().join("cuda");
    std::fs::create_dir_all(&folder)?;
    for (source, library) in [("driver.c", "libcuda.so.1"), ("compiler.c", "libnvrtc.so.13")] {
        let source = root().join("tests/support/cuda").join(source);
        compiler.shared_library(&source, &folder.join(library))?;
    }
    Ok(folder)
}

/// Runs a program on the stand-in, with settings of the stand-in's; all that it says.
fn on_stand_in(
    compiler: &Compiler,
    library: &Library,
    name: &str,
    settings: &[(&str, &str)],
) -> Result<String, Failed> {
    let executable = compiler.executable(&program(name), library)?;
    let path = std::env::join_paths([libraries(compiler)?, scratch()])?;
    run(launch(&executable).env("LD_LIBRARY_PATH", path).envs(settings.iter().copied()))
}

/// A program passes and says that it ran on the GPU, if it says where.
pub(super) fn passes(compiler: &Compiler, library: &Library, name: &str) -> Result<(), Failed> {
    let output = on_stand_in(compiler, library, name, &[])?;
    let elsewhere = ["best: cpu", "without a GPU"].iter().any(|text| output.contains(text));
    if output.contains("PASS") && !elsewhere { Ok(()) } else { Err(output.into()) }
}

/// A device without memory, and one whose kernels fail, are told in their own words.
pub(super) fn failures_are_told(compiler: &Compiler, library: &Library) -> Result<(), Failed> {
    for (setting, words) in [
        (("DRR_STAND_IN_BYTES", "1000"), "out of memory: 78608 bytes for the voxels on the GPU"),
        (("DRR_STAND_IN_BYTES", "100000"), "bytes for the images on the GPU"),
        (("DRR_STAND_IN_LAUNCHES", "0"), "the kernel: CUDA_ERROR_LAUNCH_FAILED, unspecified launch failure"),
    ] {
        match on_stand_in(compiler, library, "gpu", &[setting]) {
            Err(failed) if failed.message().is_some_and(|message| message.contains(words)) => {}
            Err(failed) => return Err(failed),
            Ok(output) => return Err(format!("{setting:?} was not seen:\n{output}").into()),
        }
    }
    Ok(())
}
