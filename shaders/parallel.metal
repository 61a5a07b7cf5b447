// The entry points of parallel beams for Metal.
#include "parallel.h"

// One thread for every pixel (row x, column y) of every view (z); rows are neighbours, as their voxels are.
kernel void projectParallel(
    constant DrrParallelLaunch &launch [[buffer(0)]], constant DrrParallelView *views [[buffer(1)]],
    const device float *field [[buffer(2)]], device float *planes [[buffer(3)]],
#if defined(DRR_MASK)
    const device uchar *mask [[buffer(4)]],
#endif
#if defined(DRR_LENGTHS)
    const device DrrInterval *interval [[buffer(5)]],
#endif
#if defined(DRR_RESIDUAL)
    const device float *measured [[buffer(6)]],
#endif
    uint3 at [[thread_position_in_grid]]) {
    DrrParallelRays rays = {};
    rays.field = field;
#if defined(DRR_MASK)
    rays.mask = mask;
#endif
#if defined(DRR_LENGTHS)
    rays.interval = interval;
#endif
#if defined(DRR_RESIDUAL)
    rays.measured = measured;
#endif
    drr_parallel_pixel(launch, views[at.z], rays, planes, at.y, at.x, at.z);
}

// One thread for every sum.
kernel void sumParallel(constant DrrParallelLaunch &launch [[buffer(0)]], const device float *planes [[buffer(3)]],
                        device float *sums [[buffer(7)]], uint number [[thread_position_in_grid]]) {
    if (number < drr_parallel_sums(launch)) drr_parallel_sum(launch, planes, sums, number);
}
