// The entry points of parallel beams for CUDA.
#include "parallel.h"

// One thread for every pixel of every view; rows are neighbours, as their voxels are.
extern "C" __global__ void __launch_bounds__(DRR_GROUP)
projectParallel(const __grid_constant__ DrrParallelLaunch launch, const DrrParallelView *__restrict__ views,
                DrrParallelRays rays, float *__restrict__ planes) {
    const uint view = blockIdx.x % launch.views;
    const uint row = blockIdx.x / launch.views * blockDim.x + threadIdx.x;
    const uint column = blockIdx.y * blockDim.y + threadIdx.y;
    if (column >= launch.width || row >= launch.height) return;
    drr_parallel_pixel(launch, views[view], rays, planes, column, row, view);
}

// One thread for every sum.
extern "C" __global__ void __launch_bounds__(DRR_GROUP)
sumParallel(const __grid_constant__ DrrParallelLaunch launch, const float *__restrict__ planes,
            float *__restrict__ sums) {
    const uint number = blockIdx.x * blockDim.x + threadIdx.x;
    if (number < drr_parallel_sums(launch)) drr_parallel_sum(launch, planes, sums, number);
}
