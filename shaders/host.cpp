// The entry point for the host: the kernel as a function, called once for every pixel.
#include "DRR_Shared.h"
#include "pixel.h"

extern "C" void projectPolyenergeticDRR(const DrrLaunch *launch, const DrrBeam *beams, const DrrVoxels *voxels,
                                        const DrrSpectra *spectra, const DrrImages *images, uint view, uint row) {
    for (uint column = 0; column < launch->width; column++) {
        drr_pixel(*launch, beams[view], *voxels, *spectra, *images, column, row, view);
    }
}
