//! The kernel text, flattened for compilers that have no folder to include from. `build.rs` makes it of `shaders/`.

/// One text and its parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Kernel {
    /// Cone beams.
    Projection,
    /// The rays of parallel beams.
    Parallel,
    /// The sums over them.
    #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
    ParallelSums,
}

impl Kernel {
    /// The entry point's name.
    #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
    pub(crate) fn entry_point(self) -> &'static str {
        match self {
            Self::Projection => "projectPolyenergeticDRR",
            Self::Parallel => "projectParallel",
            Self::ParallelSums => "sumParallel",
        }
    }

    /// For Metal.
    #[cfg(target_vendor = "apple")]
    pub(crate) fn metal(self) -> &'static str {
        match self {
            Self::Projection => include_str!(concat!(env!("OUT_DIR"), "/drr.metal")),
            Self::Parallel => include_str!(concat!(env!("OUT_DIR"), "/parallel.metal")),
        }
    }

    /// For NVIDIA's run-time compiler.
    #[cfg(all(feature = "cuda", not(target_vendor = "apple")))]
    pub(crate) fn cuda(self) -> &'static str {
        match self {
            Self::Projection => include_str!(concat!(env!("OUT_DIR"), "/drr.cu")),
            Self::Parallel | Self::ParallelSums => include_str!(concat!(env!("OUT_DIR"), "/parallel.cu")),
        }
    }

    /// For a C++17 compiler of the host.
    #[cfg(feature = "host")]
    pub(crate) fn host(self) -> &'static str {
        if self == Self::Projection {
            include_str!(concat!(env!("OUT_DIR"), "/host.cpp"))
        } else {
            include_str!(concat!(env!("OUT_DIR"), "/parallel.cpp"))
        }
    }
}
