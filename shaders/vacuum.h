// Where a ray need not be walked, because there is nothing: at its beginning and at its end.
#ifndef DRR_VACUUM_H
#define DRR_VACUUM_H

#include "courses.h"

// Voxels along each side of a brick.
#define DRR_BRICK 8

// Cells that are passed over together: no longer than a brick, so that all voxels that they read are in the brick of
// their middle or beside it.
#define DRR_CHUNK 8

#if DRR_VOXELS != DRR_VOXELS_TEXTURE
// Whether the cells of the chunk that begins `cells` after `at` read nothing but vacuum. A brick is marked as occupied
// when it or a brick beside it holds anything.
DRR_FUNCTION bool drr_vacuum(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                             DRR_THREAD const DrrRay &ray, DRR_THREAD const DrrCourses &at, int cells) {
    const DrrPosition middle = (DrrPosition)(cells + DRR_CHUNK / 2);
    const DrrPosition position[3] = {at.u.at + middle * at.u.step, at.v.at + middle * at.v.step,
                                     at.s.at + middle * at.s.step};
    const uint axis[3] = {ray.across[0], ray.across[1], ray.axis};
    const uint stride[3] = {1, launch.bricks[0], launch.bricks[0] * launch.bricks[1]};
    uint brick = 0;
    DRR_UNROLL
    for (uint n = 0; n < 3; n++) {
        const uint voxel = (uint)drr_voxel(drr_inside(position[n], launch.dimensions[axis[n]]));
        brick += voxel / DRR_BRICK * stride[axis[n]];
    }
    return drr_load(voxels.occupied + brick) == 0;
}

// Moves `next`, the next cell, and `last`, the one past the last, over chunks of vacuum, and the courses with `next`. What
// is left of the walk has the same blocks as before.
DRR_FUNCTION void drr_pass_over_vacuum(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                       DRR_THREAD const DrrRay &ray, DRR_THREAD DrrCourses &at, DRR_THREAD int &next,
                                       DRR_THREAD int &last) {
    // A chunk of longer cells reaches further than the bricks beside its own.
    if (launch.step.high > 1.0f) return;
    int from = 0, to = last - next;
    while (from < to && drr_vacuum(launch, voxels, ray, at, from)) from += DRR_CHUNK;
    while (to > from) {
        const int chunk = (to - 1) / DRR_CHUNK * DRR_CHUNK;
        if (!drr_vacuum(launch, voxels, ray, at, chunk)) break;
        to = chunk;
    }
    last = next + to;
    next += from;
    drr_advance(at.u, from);
    drr_advance(at.v, from);
    drr_advance(at.s, from);
}
#endif

#endif
