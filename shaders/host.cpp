// The entry point for the host: the kernel as a function, called for some pixels of a row.
#include "DRR_Shared.h"
#include "pixel.h"

extern "C" void projectPolyenergeticDRR(const DrrLaunch *launch, const DrrBeam *beams, const DrrVoxels *voxels,
                                        const DrrSpectra *spectra, const DrrImages *images, uint view, uint row,
                                        uint first, uint end
#if defined(DRR_SIGNALS)
                                        , const DrrChannels *channels, const DrrSignals *signals
#endif
) {
    for (uint column = first; column < end; column++) {
#if defined(DRR_SIGNALS)
        drr_pixel(*launch, beams[view], *voxels, *spectra, *channels, *signals, *images, column, row, view);
#else
        drr_pixel(*launch, beams[view], *voxels, *spectra, *images, column, row, view);
#endif
    }
}
