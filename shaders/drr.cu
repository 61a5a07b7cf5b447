// The entry point for CUDA.
#include "DRR_Shared.h"
#include "pixel.h"

// Groups of DRR_GROUP threads that are to fit on a multiprocessor, which bounds the registers: measured, see
// benches/README.md.
#if defined(DRR_SPECIFICATION_LOOP)
#define DRR_GROUPS 1
#elif defined(DRR_ONE_LABEL)
#define DRR_GROUPS 6
#else
#define DRR_GROUPS 7
#endif

extern "C" __global__ void __launch_bounds__(DRR_GROUP, DRR_GROUPS)
projectPolyenergeticDRR(const __grid_constant__ DrrLaunch launch, const DrrBeam *__restrict__ beams, DrrVoxels voxels,
                        DrrSpectra spectra, DrrImages images
#if defined(DRR_SIGNALS)
                        , const __grid_constant__ DrrChannels channels, DrrSignals signals
#endif
) {
    // Neighbouring blocks are the views of one tile: what one reads is in cache for the other.
    const uint view = blockIdx.x % launch.views;
    const uint column = blockIdx.x / launch.views * blockDim.x + threadIdx.x;
    const uint row = blockIdx.y * blockDim.y + threadIdx.y;
    if (column >= launch.width || row >= launch.height) return;
#if defined(DRR_SIGNALS)
    drr_pixel(launch, beams[view], voxels, spectra, channels, signals, images, column, row, view);
#else
    drr_pixel(launch, beams[view], voxels, spectra, images, column, row, view);
#endif
}
