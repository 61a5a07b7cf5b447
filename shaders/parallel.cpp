// The entry points of parallel beams for the host: some rows of a column, and all sums.
#include "parallel.h"

extern "C" void projectParallel(const DrrParallelLaunch *launch, const DrrParallelView *views,
                                const DrrParallelRays *rays, float *planes, uint view, uint column, uint first,
                                uint end) {
    for (uint row = first; row < end; row++) {
        drr_parallel_pixel(*launch, views[view], *rays, planes, column, row, view);
    }
}

extern "C" void sumParallel(const DrrParallelLaunch *launch, const float *planes, float *sums) {
    for (uint number = 0; number < drr_parallel_sums(*launch); number++) {
        drr_parallel_sum(*launch, planes, sums, number);
    }
}
