// Exact lengths through voxels of constant value (Siddon, Med. Phys. 12(2), 252, 1985). Within one slice of the driving
// axis a ray crosses at most one plane of each other axis, so it meets at most three voxels: every ray takes the same
// steps, without a branch on its direction.
#ifndef DRR_SIDDON_H
#define DRR_SIDDON_H

#include "walk.h"

// Along one transverse axis: the voxels in which the ray enters and leaves a slice, and how far it is from the one
// place to where it crosses into the other.
struct DrrCrossing {
    int first;
    int last;
    float at;
};

// From x on, over `length` slices, to x_end; positions are from the voxels' lower faces on.
DRR_FUNCTION DrrCrossing drr_crossing(DrrPosition x, DrrPosition x_end, float slope, float length) {
    DrrCrossing crossing;
    crossing.first = drr_voxel(x);
    crossing.last = drr_voxel(x_end);
    // All 32 bits: where the slope is small, so is the way, and an error of it is large along the ray.
    const uint beyond = slope > 0.0f ? ~(uint)x : (uint)x;
    const float way = (float)beyond / DRR_ONE_VOXEL;
    crossing.at = crossing.first == crossing.last ? length : drr_min(way / drr_abs(slope), length);
    return crossing;
}

DRR_FUNCTION void drr_take(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD DrrSums &sums,
                           DrrVoxel voxel, float length) {
#if !defined(DRR_ONE_LABEL)
    if ((drr_unlike(voxel, sums.label) & DRR_UNLIKE) != 0) {
        drr_end_run(sums);
        drr_start_run(launch, sums, drr_label(voxel));
    }
#endif
    // Vacuum adds exactly nothing.
    if (drr_unlike(voxel, sums.label) == 0) return;
    sums.run = drr_fma(length, drr_standing_in(launch, voxels, sums.how, voxel), sums.run);
    sums.length += length;
}

DRR_FUNCTION bool drr_sees_only_matter(DRR_THREAD const DrrSums &) { return true; }

#if defined(DRR_BONE_PATH)
// Length in bone, slices, also where it has no density.
struct DrrBonePath {
    float block;
    DrrTwofold total;
};

DRR_FUNCTION void drr_start(DRR_CONSTANT DrrLaunch &, float, DRR_THREAD DrrBonePath &path) {
    path.block = 0.0f;
    path.total = drr_twofold(0.0f);
}

DRR_FUNCTION void drr_take(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrVoxels &, DRR_THREAD DrrBonePath &path,
                           DrrVoxel voxel, float length) {
    path.block += drr_label(voxel) == DRR_BONE_PATH ? length : 0.0f;
}

DRR_FUNCTION bool drr_sees_only_matter(DRR_THREAD const DrrBonePath &) { return false; }

DRR_FUNCTION bool drr_end_block(DRR_CONSTANT DrrBeam &, DRR_THREAD DrrBonePath &path) {
    drr_add_to(path.total, path.block);
    path.block = 0.0f;
    return false;
}
#endif

// Sums is what takes the voxels and their lengths.
template <typename Sums>
struct DrrSiddon {
    Sums sums;
    float slope[2];

    DRR_METHOD void start(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray) {
        slope[0] = drr_rounded(ray.slope[0]);
        slope[1] = drr_rounded(ray.slope[1]);
        drr_start(launch, ray.cm_per_slice, sums);
    }

    // Positions are from the voxels' faces on, not from their centres.
    DRR_METHOD void begin(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrSteps &, DRR_THREAD DrrCourses &at, int) {
        at.u.at += (DrrPosition)1 << 31;
        at.v.at += (DrrPosition)1 << 31;
    }
    DRR_METHOD DrrTwofold cell(DRR_CONSTANT DrrLaunch &) { return drr_twofold(1.0f); }
    DRR_METHOD float sample() { return 0.0f; }
    DRR_METHOD bool sees_only_matter() { return drr_sees_only_matter(sums); }
    DRR_METHOD bool end_block(DRR_CONSTANT DrrBeam &beam) { return drr_end_block(beam, sums); }

    DRR_METHOD void slab(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                         DRR_THREAD const DrrSteps &steps, DrrCourse u, DrrCourse v, int slice, float length) {
        const DrrCrossing a = drr_crossing(u.at, u.at + u.step, slope[0], length);
        const DrrCrossing b = drr_crossing(v.at, v.at + v.step, slope[1], length);
        const bool u_leads = a.at < b.at;
        const float first = u_leads ? a.at : b.at, second = u_leads ? b.at : a.at;
        drr_take(launch, voxels, sums, drr_read(launch, voxels, drr_place(launch, steps, a.first, b.first, slice)), first);
        drr_take(launch, voxels, sums,
                 drr_read(launch, voxels,
                          drr_place(launch, steps, u_leads ? a.last : a.first, u_leads ? b.first : b.last, slice)),
                 second - first);
        drr_take(launch, voxels, sums, drr_read(launch, voxels, drr_place(launch, steps, a.last, b.last, slice)),
                 length - second);
    }

    DRR_METHOD void part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrRay &ray,
                         DRR_THREAD const DrrSteps &steps, int cell, DrrTwofold from, DrrTwofold to) {
        const DrrTwofold extent = drr_twofold(drr_half_extent(launch, ray.axis));
        DrrCourse course[2];
        for (uint t = 0; t < 2; t++) {
            const DrrTwofold face = drr_twofold(0.5f);
            const DrrPosition at =
                drr_position(drr_add(drr_across(launch, ray, t, drr_subtract(from, extent)), face));
            const DrrPosition end = drr_position(drr_add(drr_across(launch, ray, t, drr_subtract(to, extent)), face));
            // Where the ray enters and leaves through a face, rounding may have led beyond it.
            const DrrPosition last = ((DrrPosition)launch.dimensions[ray.across[t]] << 32) - 1;
            course[t].at = drr_limited(at, last);
            course[t].step = drr_limited(end, last) - course[t].at;
        }
        slab(launch, voxels, steps, course[0], course[1], cell, drr_rounded(drr_subtract(to, from)));
    }

    DRR_METHOD void whole(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                          DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at, int cell, int end) {
        for (; cell < end; cell++) {
            slab(launch, voxels, steps, at.u, at.v, cell, 1.0f);
            at.u.at += at.u.step;
            at.v.at += at.v.step;
        }
    }
};

#endif
