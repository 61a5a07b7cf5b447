// The walk along a ray, from cell to cell of the driving axis, for every rule that integrates over cells.
#ifndef DRR_WALK_H
#define DRR_WALK_H

#include "sums.h"

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
    const int past = -(int)drr_floor_of(drr_negated(leave));
    const int last = past - 1 > first ? past - 1 : first;

    DrrCourse u, v, s;
    u.step = drr_position(drr_multiply(ray.slope[0], cell));
    v.step = drr_position(drr_multiply(ray.slope[1], cell));
    s.step = drr_position(cell);
    for (int at = first; at <= last;) {
        if (at == first || at == last) {
            const DrrTwofold to = at == last ? leave : drr_twofold((float)first + 1.0f);
            rule.part(launch, voxels, ray, steps, at, at == first ? enter : drr_twofold((float)last), to);
            at++;
        } else {
            const int end = at + DRR_BLOCK < last ? at + DRR_BLOCK : last;
            const DrrTwofold from_face = drr_multiply(cell, drr_twofold((float)at + rule.sample()));
            const DrrTwofold from_centre = drr_subtract(from_face, extent);
            u.at = drr_position(drr_across(launch, ray, 0, from_centre));
            v.at = drr_position(drr_across(launch, ray, 1, from_centre));
            s.at = drr_position(drr_add(from_face, drr_twofold(-0.5f)));
            rule.whole(launch, voxels, steps, u, v, s, at, end);
            at = end;
        }
        if (rule.end_block(beam)) break;
    }
}

#endif
