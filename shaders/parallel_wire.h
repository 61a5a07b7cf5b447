// What the host tells the kernels of parallel beams: src/engine/gpu/parallel/wire.rs is the same, byte for byte.
#ifndef DRR_PARALLEL_WIRE_H
#define DRR_PARALLEL_WIRE_H

#include "wire.h"

// Parameters of a view: alpha, beta, phi, dx, dz.
#define DRR_PARAMETERS 5

// Planes of a view: image or residual, then its derivatives.
#define DRR_PLANES 6

// Sums over the rays of products of two planes.
#define DRR_PRODUCTS 21

// How samples move with one parameter, as frame has it.
struct DrrMotion {
    float at[3][3]; // by axis: offset, column, row
    float step[3];
};

// Where the samples of one view are: that of pixel (column, row), k steps from the middle one, is at `at` + k * `step`,
// in voxels from the first one of the field's border.
struct DrrParallelView {
    DrrAffine at[3];
    DrrTwofold step[3];
    DrrMotion motion[DRR_PARAMETERS];
};

// The steps of a ray that count, and which part of the first and the last one does.
struct DrrInterval {
    uint first;
    uint end;
    float first_part;
    float last_part;
};

// The field, the detector and the steps.
struct DrrParallelLaunch {
    uint cells[3];  // of the field with its border
    uint stride[2]; // from a voxel to the next along x, along y; along z they are neighbours
    uint width;     // pixels
    uint height;
    uint views;
    uint steps;
    float length;   // of a step, mm
    uint part;      // rays that one thread sums over
};

static_assert(sizeof(DrrParallelView) == 336, "src/engine/gpu/parallel/wire.rs says the same");
static_assert(sizeof(DrrInterval) == 16, "src/engine/gpu/parallel/wire.rs says the same");
static_assert(sizeof(DrrParallelLaunch) == 44, "src/engine/gpu/parallel/wire.rs says the same");

#endif
