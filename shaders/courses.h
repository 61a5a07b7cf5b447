// Places of voxels and coordinates of a ray as positions.
#ifndef DRR_COURSES_H
#define DRR_COURSES_H

#include "position.h"
#include "voxels.h"

// Makes a position along u count slices as well, from slice `slice` on; see DRR_FOLDED.
DRR_FUNCTION void drr_fold(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourse &u,
                           int slice) {
#if DRR_FOLDED
    u.at += (DrrPosition)(launch.first_voxel + (uint)slice * steps.s) << 32;
    u.step += (DrrPosition)steps.s << 32;
#endif
}

// The place of a voxel, when `u` may have been folded.
DRR_FUNCTION DrrPlace drr_folded_place(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrSteps &steps, DrrPosition u,
                                       DrrPosition v, int slice) {
#if DRR_FOLDED
    return (uint)drr_voxel(u) + (uint)drr_voxel(v) * steps.v;
#else
    return drr_place(launch, steps, drr_voxel(u), drr_voxel(v), slice);
#endif
}

// Index of the voxel centre that is the volume's centre plus x.
DRR_FUNCTION DrrTwofold drr_index(DRR_CONSTANT DrrLaunch &launch, uint axis, DrrTwofold x) {
    return drr_add(x, drr_twofold(drr_half_extent(launch, axis) - 0.5f));
}

// A transverse coordinate at s, relative to the volume's centre.
DRR_FUNCTION DrrTwofold drr_across(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray, uint t, DrrTwofold s) {
    return drr_index(launch, ray.across[t], drr_add(ray.base[t], drr_multiply(ray.slope[t], s)));
}

DRR_FUNCTION DrrPosition drr_inside_across(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray, uint t,
                                           DrrTwofold s) {
    return drr_inside(drr_position(drr_across(launch, ray, t, s)), launch.dimensions[ray.across[t]]);
}

#endif
