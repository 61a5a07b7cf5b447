// Trilinear samples at equal steps: one in the middle of every cell of the driving axis, or of the part of it that the
// ray is in, weighted by its length.
#ifndef DRR_MARCH_H
#define DRR_MARCH_H

#include "joseph.h"

// The eight voxels around a point, as the squares before and behind it, and where between them it is.
struct DrrCube {
    DrrSquare square[2];
    float s;
};

DRR_FUNCTION DrrCube drr_cube(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                              DRR_THREAD const DrrSteps &steps, DrrPosition u, DrrPosition v, DrrPosition s) {
    DrrCube cube;
    const DrrPlace place = drr_place(launch, steps, drr_voxel(u), drr_voxel(v), drr_voxel(s));
    cube.square[0] = drr_square(launch, voxels, steps, place, u, v);
    cube.square[1] = drr_square(launch, voxels, steps, place + steps.s, u, v);
    cube.s = drr_fraction(s);
    return cube;
}

// What Joseph's rule does with one square, weighted, with two.
DRR_FUNCTION void drr_add_cube(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                               DRR_THREAD DrrSums &sums, DRR_THREAD const DrrCube &cube, float length) {
    const uint unlike = drr_unlike(sums, cube.square[0]) | drr_unlike(sums, cube.square[1]);
    if (unlike == 0) return;
#if !defined(DRR_ONE_LABEL)
    if (unlike & DRR_UNLIKE) {
        const float behind = cube.s * length;
        drr_add_squares<1>(launch, voxels, sums, &cube.square[0], length - behind);
        drr_add_squares<1>(launch, voxels, sums, &cube.square[1], behind);
        return;
    }
#endif
    const float sample = drr_between(drr_in_run(launch, voxels, sums, cube.square[0]),
                                     drr_in_run(launch, voxels, sums, cube.square[1]), cube.s);
    sums.run = drr_fma(length, sample, sums.run);
    sums.length += length;
}

struct DrrMarch {
    DrrSums sums;

    DRR_METHOD void start(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray) {
        drr_start(launch, ray.cm_per_slice * drr_rounded(launch.step), sums);
    }
    DRR_METHOD void begin(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrSteps &, DRR_THREAD DrrCourses &, int) {}
    DRR_METHOD DrrTwofold cell(DRR_CONSTANT DrrLaunch &launch) { return launch.step; }
    DRR_METHOD float sample() { return 0.5f; }
    DRR_METHOD bool sees_only_matter() { return true; }
    DRR_METHOD bool end_block(DRR_CONSTANT DrrBeam &beam) { return drr_end_block(beam, sums); }

    DRR_METHOD void part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrRay &ray,
                         DRR_THREAD const DrrSteps &steps, int, DrrTwofold from, DrrTwofold to) {
        const DrrTwofold middle = drr_multiply(drr_add(from, to), drr_twofold(0.5f));
        const DrrTwofold from_face = drr_multiply(middle, launch.step);
        const DrrTwofold s = drr_subtract(from_face, drr_twofold(drr_half_extent(launch, ray.axis)));
        const DrrPosition u = drr_inside_across(launch, ray, 0, s);
        const DrrPosition v = drr_inside_across(launch, ray, 1, s);
        const DrrPosition along =
            drr_inside(drr_position(drr_index(launch, ray.axis, s)), launch.dimensions[ray.axis]);
        const float length = drr_rounded(drr_subtract(to, from));
        drr_add_cube(launch, voxels, sums, drr_cube(launch, voxels, steps, u, v, along), length);
    }

    DRR_METHOD void whole(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                          DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at, int cell, int end) {
        for (; cell < end; cell++) {
            drr_add_cube(launch, voxels, sums, drr_cube(launch, voxels, steps, at.u.at, at.v.at, at.s.at), 1.0f);
            at.u.at += at.u.step;
            at.v.at += at.v.step;
            at.s.at += at.s.step;
        }
    }
};

#endif
