// What the host tells the kernel, beside ProjectionUniforms: src/engine/gpu/wire.rs is the same, byte for byte.
#ifndef DRR_WIRE_H
#define DRR_WIRE_H

#include "dialect.h"

// Labels of a volume are 0 … 7.
#define DRR_MAX_LABELS 8

// A number as an unevaluated sum of two float32: 48 bits.
struct DrrTwofold {
    float high;
    float low;
};

// A number that changes evenly from pixel to pixel: offset + column * i + row * j.
struct DrrAffine {
    DrrTwofold offset;
    DrrTwofold column;
    DrrTwofold row;
};

// Where a sum over energies finds its tables.
struct DrrTable {
    uint bins;
    uint first_weight;      // of `bins` in the array of weights; as many logarithms follow
    uint first_attenuation; // of materials * bins in the array of mass attenuation, material-major
    DrrTwofold weight_sum;
};

// All rays of one view, in voxel-index space, relative to the centre of the volume.
struct DrrBeam {
    DrrAffine direction[3];
    // DRR_ANCHOR_POINT: a point of the ray. DRR_ANCHOR_MOMENT: point x direction, the same for all points of the ray.
    DrrAffine anchor[3];
    DrrAffine pixel[3];     // where a segment ends
    DrrTwofold source[3];   // where a segment or a half-line starts
    uint anchor_kind;
    uint ends;              // DRR_ENDS_AT_SOURCE | DRR_ENDS_AT_PIXEL
    uint early_exit;        // 1: a ray may stop once it is opaque
    float i0;
    float least_attenuation[DRR_MAX_LABELS]; // cm^2/g, over the bins with weight
    DrrTable all;           // the view's bins with weight
    DrrTable few;           // with DRR_FEW_ENERGIES: what stands for all of them
    float few_up_to[DRR_MAX_LABELS]; // as long as no areal density, g/cm^2, is above this; negative: never
};

#define DRR_ANCHOR_POINT 0
#define DRR_ANCHOR_MOMENT 1
#define DRR_ENDS_AT_SOURCE 1
#define DRR_ENDS_AT_PIXEL 2

#if defined(DRR_SIGNALS)
// Most rows of weights that one ray is summed by, and most materials before the volume.
#define DRR_MAX_SIGNALS 8
#define DRR_MAX_BEFORE 8

// Where the sums of all views find their tables.
struct DrrChannels {
    uint bins;
    uint first_weight;      // of rows * bins in the array of weights, row by row; as many logarithms follow
    uint first_attenuation; // of (materials + before) * bins in the array of mass attenuation
    DrrTwofold weight_sum[DRR_MAX_SIGNALS];
    float least_attenuation[DRR_MAX_LABELS + DRR_MAX_BEFORE]; // cm^2/g, by label, then of what lies before the volume
};
static_assert(sizeof(DrrChannels) == 140, "src/engine/gpu/wire.rs says the same");
#endif

// How the codes of voxels with one label stand in for their densities, g/cm^3: with t = 2^-23 code + origin,
// density = scale * (t - kink * |t|) + offset.
struct DrrStandIn {
    float origin;
    float kink;
    float scale;
    float offset;
};

// The volume, the detector and the method.
struct DrrLaunch {
    uint dimensions[3];     // voxels along i, j, k
    uint bricks[3];         // bricks of voxels along i, j, k
    uint stride[3];         // from a voxel to the next, in the array of voxels
    uint first_voxel;       // place of voxel (0, 0, 0) in that array
    uint width;             // pixels
    uint height;
    uint views;
    DrrTwofold millimetres[3][3]; // columns of index -> world
    DrrTwofold step;        // slices per cell of the march
    // A voxel's code is 8 * value + label. Its density is what its label's stand-in says, and
    // scale * min(8 value, kink[0] + kink[1] * 8 value), g/cm^3.
    DrrStandIn stand_in[DRR_MAX_LABELS];
    float scale;
    float kink[2];
};

static_assert(sizeof(DrrBeam) == 360, "src/engine/gpu/wire.rs says the same");
static_assert(sizeof(DrrLaunch) == 272, "src/engine/gpu/wire.rs says the same");

#endif
