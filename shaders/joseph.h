// Joseph's rule: one bilinear sample in every slice of the driving axis, weighted by the part of the slice that the ray
// is in (Joseph, IEEE Trans. Med. Imaging 1(3), 192, 1982).
#ifndef DRR_JOSEPH_H
#define DRR_JOSEPH_H

#include "walk.h"

// Samples that are read together: their reads wait for memory side by side.
#if !defined(DRR_TOGETHER)
#define DRR_TOGETHER 4
#endif

// The four voxels around a point of a slice, and where between them it is.
struct DrrSquare {
    DrrVoxel corner[4];
    float u;
    float v;
};

DRR_FUNCTION DrrSquare drr_square(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD const DrrSteps &steps, DrrPosition u, DrrPosition v, int slice) {
    DrrSquare square;
    drr_read_square(launch, voxels, steps, drr_place(launch, steps, drr_voxel(u), drr_voxel(v), slice), square.corner);
    square.u = drr_fraction(u);
    square.v = drr_fraction(v);
    return square;
}

DRR_FUNCTION float drr_bilinear(DRR_THREAD const float *corner, float u, float v) {
    return drr_between(drr_between(corner[0], corner[1], u), drr_between(corner[2], corner[3], u), v);
}

// How unlike a vacuum with the run's label the corners are; see drr_unlike.
DRR_FUNCTION uint drr_unlike(DRR_THREAD const DrrSums &sums, DRR_THREAD const DrrSquare &square) {
    uint unlike = 0;
    DRR_UNROLL
    for (uint c = 0; c < 4; c++) unlike |= drr_unlike(square.corner[c], sums.label);
    return unlike;
}

DRR_FUNCTION float drr_in_run(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                              DRR_THREAD const DrrSums &sums, DRR_THREAD const DrrSquare &square) {
    float corner[4];
    DRR_UNROLL
    for (uint c = 0; c < 4; c++) corner[c] = drr_standing_in(launch, voxels, sums.how, square.corner[c]);
    return drr_bilinear(corner, square.u, square.v);
}

// A sample whose corners have several labels: each label's density is interpolated apart.
DRR_FUNCTION void drr_add_mixed(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                DRR_THREAD DrrSums &sums, DRR_THREAD const DrrSquare &square, float length) {
    float density[4];
    DRR_UNROLL
    for (uint c = 0; c < 4; c++) density[c] = drr_density(launch, voxels, square.corner[c]);
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (!DRR_HAS(m)) continue;
        float corner[4];
        DRR_UNROLL
        for (uint c = 0; c < 4; c++) corner[c] = drr_label(square.corner[c]) == m ? density[c] : 0.0f;
        sums.block[m] = drr_fma(length, drr_bilinear(corner, square.u, square.v), sums.block[m]);
    }
}

DRR_FUNCTION void drr_add_square(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                 DRR_THREAD DrrSums &sums, DRR_THREAD const DrrSquare &square, float length) {
#if !defined(DRR_ONE_LABEL)
    if (drr_unlike(sums, square) & DRR_UNLIKE) {
        const uint label = drr_label(square.corner[0]);
        uint mixed = 0;
        DRR_UNROLL
        for (uint c = 1; c < 4; c++) mixed |= drr_unlike(square.corner[c], label);
        if (mixed & DRR_UNLIKE) {
            drr_add_mixed(launch, voxels, sums, square, length);
            return;
        }
        drr_end_run(sums);
        drr_start_run(launch, sums, label);
    }
#endif
    sums.run = drr_fma(length, drr_in_run(launch, voxels, sums, square), sums.run);
    sums.length += length;
}

// Whole slices, read together.
DRR_FUNCTION void drr_add_squares(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD DrrSums &sums, DRR_THREAD const DrrSquare *squares) {
    uint unlike = 0;
    DRR_UNROLL
    for (uint n = 0; n < DRR_TOGETHER; n++) unlike |= drr_unlike(sums, squares[n]);
    if (!drr_any(unlike != 0)) return;
#if !defined(DRR_ONE_LABEL)
    if (drr_any((unlike & DRR_UNLIKE) != 0)) {
        DRR_UNROLL
        for (uint n = 0; n < DRR_TOGETHER; n++) drr_add_square(launch, voxels, sums, squares[n], 1.0f);
        return;
    }
#endif
    DRR_UNROLL
    for (uint n = 0; n < DRR_TOGETHER; n++) {
        sums.run += drr_in_run(launch, voxels, sums, squares[n]);
    }
    sums.length += (float)DRR_TOGETHER;
}

struct DrrJoseph {
    DrrSums sums;

    // Cells are slices, and are sampled at their centres, also those that the ray is in only partly.
    DRR_METHOD DrrTwofold cell(DRR_CONSTANT DrrLaunch &) { return drr_twofold(1.0f); }
    DRR_METHOD float sample() { return 0.5f; }
    DRR_METHOD bool end_block(DRR_CONSTANT DrrBeam &beam) { return drr_end_block(beam, sums); }

    DRR_METHOD void part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrRay &ray,
              DRR_THREAD const DrrSteps &steps, int cell, DrrTwofold from, DrrTwofold to) {
        const DrrTwofold s = drr_twofold((float)cell + 0.5f - drr_half_extent(launch, ray.axis));
        const DrrPosition u = drr_inside(drr_position(drr_across(launch, ray, 0, s)), launch.dimensions[ray.across[0]]);
        const DrrPosition v = drr_inside(drr_position(drr_across(launch, ray, 1, s)), launch.dimensions[ray.across[1]]);
        const float length = drr_rounded(drr_subtract(to, from));
        drr_add_square(launch, voxels, sums, drr_square(launch, voxels, steps, u, v, cell), length);
    }

    DRR_METHOD void whole(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrSteps &steps,
               DrrCourse u, DrrCourse v, DrrCourse, int cell, int end) {
        for (; cell + DRR_TOGETHER <= end; cell += DRR_TOGETHER) {
            DrrSquare squares[DRR_TOGETHER];
            DRR_UNROLL
            for (int n = 0; n < DRR_TOGETHER; n++) {
                squares[n] = drr_square(launch, voxels, steps, u.at, v.at, cell + n);
                u.at += u.step;
                v.at += v.step;
            }
            drr_add_squares(launch, voxels, sums, squares);
        }
        for (; cell < end; cell++) {
            drr_add_square(launch, voxels, sums, drr_square(launch, voxels, steps, u.at, v.at, cell), 1.0f);
            u.at += u.step;
            v.at += v.step;
        }
    }
};

#endif
