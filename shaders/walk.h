// The walk along a ray, from cell to cell of the driving axis, for every rule that integrates over cells.
#ifndef DRR_WALK_H
#define DRR_WALK_H

#include "sums.h"
#include "vacuum.h"

// Walks a ray through the volume. The rule says how long a cell is (in slices), where in a cell it wants its positions,
// and integrates over parts of a cell and runs of whole ones, which it adds to its sums. Cell k covers k … k + 1 cell
// lengths from the volume's face on.
template <typename Rule>
DRR_FUNCTION void drr_walk(DRR_CONSTANT DrrLaunch &launch, DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrVoxels &voxels,
                           DRR_THREAD const DrrRay &ray, DRR_THREAD Rule &rule) {
    const DrrSteps steps = drr_steps(launch, voxels, ray);
    const DrrTwofold extent = drr_twofold(drr_half_extent(launch, ray.axis));
    const DrrTwofold cell = rule.cell(launch);
    const DrrTwofold enter = drr_divide(drr_add(ray.enter, extent), cell);
    const DrrTwofold leave = drr_divide(drr_add(ray.leave, extent), cell);
    const int first = (int)drr_floor_of(enter);
    const int beyond = -(int)drr_floor_of(drr_negated(leave));
    const int last = beyond - 1 > first ? beyond - 1 : first;

    rule.part(launch, voxels, ray, steps, first, enter, first == last ? leave : drr_twofold((float)first + 1.0f));
    if (last > first) rule.part(launch, voxels, ray, steps, last, drr_twofold((float)last), leave);

    // The ray itself is not needed any more, and its registers are free.
    const DrrTwofold from_face = drr_multiply(cell, drr_twofold((float)(first + 1) + rule.sample()));
    const DrrTwofold from_centre = drr_subtract(from_face, extent);
    DrrCourses at;
    at.u = drr_course(drr_across(launch, ray, 0, from_centre), drr_multiply(ray.slope[0], cell));
    at.v = drr_course(drr_across(launch, ray, 1, from_centre), drr_multiply(ray.slope[1], cell));
    at.s = drr_course(drr_add(from_face, drr_twofold(-0.5f)), cell);
    int next = first + 1, past = last;
#if DRR_VOXELS != DRR_VOXELS_TEXTURE
    if (rule.sees_only_matter()) drr_pass_over_vacuum(launch, voxels, ray, at, next, past);
#endif
    rule.begin(launch, steps, at, next);
    while (next < past) {
        if (rule.end_block(beam)) return;
        const int block = first + 1 + ((next - first - 1) / DRR_BLOCK + 1) * DRR_BLOCK;
        rule.whole(launch, voxels, steps, at, next, block < past ? block : past);
        next = block;
        at.u.at += at.u.correction;
        at.v.at += at.v.correction;
        at.s.at += at.s.correction;
    }
    rule.end_block(beam);
}

#endif
