// Joseph's rule: one bilinear sample in every slice of the driving axis, weighted by the part of the slice that the ray
// is in (Joseph, IEEE Trans. Med. Imaging 1(3), 192, 1982).
#ifndef DRR_JOSEPH_H
#define DRR_JOSEPH_H

#include "walk.h"

// Samples that are read together: their reads wait for memory side by side.
#define DRR_TOGETHER 4

// The four voxels around a point of a slice, and where between them it is.
struct DrrSquare {
    DrrVoxel corner[4];
    float u;
    float v;
};

DRR_FUNCTION DrrSquare drr_square(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD const DrrSteps &steps, DrrPlace place, DrrPosition u, DrrPosition v) {
    DrrSquare square;
    drr_read_square(launch, voxels, steps, place, square.corner);
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

// Samples whose corners have several labels: each label's density is interpolated apart. The last corner's label begins
// the next run.
template <uint N>
DRR_FUNCTION void drr_add_mixed(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                DRR_THREAD DrrSums &sums, DRR_THREAD const DrrSquare *squares, float length) {
    float density[N][4];
    uint labels = 0;
    DRR_UNROLL
    for (uint n = 0; n < N; n++) {
        DRR_UNROLL
        for (uint c = 0; c < 4; c++) {
            density[n][c] = drr_density(launch, voxels, squares[n].corner[c]);
            labels |= 1u << drr_label(squares[n].corner[c]);
        }
    }
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (!DRR_HAS(m) || !(labels >> m & 1)) continue;
        float sum = 0.0f;
        DRR_UNROLL
        for (uint n = 0; n < N; n++) {
            float corner[4];
            DRR_UNROLL
            for (uint c = 0; c < 4; c++) corner[c] = drr_label(squares[n].corner[c]) == m ? density[n][c] : 0.0f;
            sum += drr_bilinear(corner, squares[n].u, squares[n].v);
        }
        drr_add_to(sums.total[m], length * sum);
    }
    drr_end_run(sums);
    drr_start_run(launch, sums, drr_label(squares[N - 1].corner[3]));
}

// N samples, each for the same length.
template <uint N>
DRR_FUNCTION void drr_add_squares(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD DrrSums &sums, DRR_THREAD const DrrSquare *squares, float length) {
    uint unlike = 0;
    DRR_UNROLL
    for (uint n = 0; n < N; n++) unlike |= drr_unlike(sums, squares[n]);
#if !defined(DRR_ONE_LABEL)
    if (!drr_any(unlike != 0)) return;
    if (drr_any((unlike & DRR_UNLIKE) != 0)) {
        if (unlike & DRR_UNLIKE) {
            drr_add_mixed<N>(launch, voxels, sums, squares, length);
            return;
        }
    }
#endif
    float run = 0.0f;
    DRR_UNROLL
    for (uint n = 0; n < N; n++) run += drr_in_run(launch, voxels, sums, squares[n]);
    // Vacuum adds exactly nothing.
    const float counts = unlike != 0 ? length : 0.0f;
    sums.run = drr_fma(counts, run, sums.run);
    sums.length = drr_fma(counts, (float)N, sums.length);
}

// The square at the centre of a slice that the ray is in only partly: its centre may be beyond the volume's edge.
DRR_FUNCTION DrrSquare drr_square_of_part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                          DRR_THREAD const DrrRay &ray, DRR_THREAD const DrrSteps &steps, int slice) {
    const DrrTwofold s = drr_twofold((float)slice + 0.5f - drr_half_extent(launch, ray.axis));
    const DrrPosition u = drr_inside_across(launch, ray, 0, s);
    const DrrPosition v = drr_inside_across(launch, ray, 1, s);
    return drr_square(launch, voxels, steps, drr_place(launch, steps, drr_voxel(u), drr_voxel(v), slice), u, v);
}

struct DrrJoseph {
    DrrSums sums;

    DRR_METHOD void start(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray) {
        drr_start(launch, ray.cm_per_slice, sums);
    }

    // Positions count slices too where they can: see DRR_FOLDED.
    DRR_METHOD void begin(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at,
                          int cell) {
        drr_fold(launch, steps, at.u, cell);
    }

    // Cells are slices, and are sampled at their centres, also those that the ray is in only partly.
    DRR_METHOD DrrTwofold cell(DRR_CONSTANT DrrLaunch &) { return drr_twofold(1.0f); }
    DRR_METHOD float sample() { return 0.5f; }
    DRR_METHOD bool sees_only_matter() { return true; }
    DRR_METHOD bool end_block(DRR_CONSTANT DrrBeam &beam) { return drr_end_block(beam, sums); }

    DRR_METHOD void part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrRay &ray,
                         DRR_THREAD const DrrSteps &steps, int cell, DrrTwofold from, DrrTwofold to) {
        const DrrSquare square = drr_square_of_part(launch, voxels, ray, steps, cell);
        drr_add_squares<1>(launch, voxels, sums, &square, drr_rounded(drr_subtract(to, from)));
    }

    DRR_METHOD void whole(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                          DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at, int cell, int end) {
        for (; cell + DRR_TOGETHER <= end; cell += DRR_TOGETHER) {
            DrrSquare squares[DRR_TOGETHER];
            DRR_UNROLL
            for (int n = 0; n < DRR_TOGETHER; n++) squares[n] = next(launch, voxels, steps, at, cell + n);
            drr_add_squares<DRR_TOGETHER>(launch, voxels, sums, squares, 1.0f);
        }
        for (; cell < end; cell++) {
            const DrrSquare square = next(launch, voxels, steps, at, cell);
            drr_add_squares<1>(launch, voxels, sums, &square, 1.0f);
        }
    }

    DRR_METHOD DrrSquare next(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                              DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at, int cell) {
        const DrrPlace place = drr_folded_place(launch, steps, at.u.at, at.v.at, cell);
        const DrrSquare square = drr_square(launch, voxels, steps, place, at.u.at, at.v.at);
        at.u.at += at.u.step;
        at.v.at += at.v.step;
        return square;
    }
};

#endif
