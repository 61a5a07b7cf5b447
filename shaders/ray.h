// From a pixel to the part of its ray inside the volume. As src/raycast does it in float64.
#ifndef DRR_RAY_H
#define DRR_RAY_H

#include "twofold.h"

#if !defined(DRR_AXIS)
#define DRR_AXIS 3 // the rays of a launch have different driving axes
#endif

// A clipped ray. s is the coordinate along the driving axis, u and v are those across it, the faster one in memory
// first; all are voxel indices relative to the volume's centre. The ray is at base + slope * s.
struct DrrRay {
    uint axis;
    uint across[2];
    DrrTwofold base[2];
    DrrTwofold slope[2];
    DrrTwofold enter; // s
    DrrTwofold leave;
    float cm_per_slice;
};

DRR_FUNCTION uint drr_driving_axis(DRR_THREAD const DrrTwofold *direction) {
#if DRR_AXIS < 3
    return DRR_AXIS;
#else
    const DrrTwofold x = drr_magnitude(direction[0]);
    const DrrTwofold y = drr_magnitude(direction[1]);
    const DrrTwofold z = drr_magnitude(direction[2]);
    if (!drr_less(x, y) && !drr_less(x, z)) return 0;
    return drr_less(y, z) ? 2 : 1;
#endif
}

// Half the box along an axis: half-integer, so exact.
DRR_FUNCTION float drr_half_extent(DRR_CONSTANT DrrLaunch &launch, uint axis) {
    return 0.5f * (float)launch.dimensions[axis];
}

// Keeps of enter … leave what is inside [-extent, extent) along one transverse axis; false when nothing can be. A plane that
// is not met within the box's length is not divided by: a slope may be 0, or so small that the quotient overflows.
DRR_FUNCTION bool drr_clip(DRR_THREAD DrrRay &ray, uint t, float extent, float length) {
    const DrrTwofold slope = ray.slope[t];
    DRR_UNROLL
    for (uint side = 0; side < 2; side++) {
        const DrrTwofold off = drr_subtract(drr_twofold(side == 0 ? -extent : extent), ray.base[t]);
        const bool meets = slope.high != 0.0f && drr_abs(off.high) <= drr_abs(slope.high) * (length + 2.0f);
        if (!meets) {
            const bool above = off.high > 0.0f || (off.high == 0.0f && off.low > 0.0f);
            // Half-open: the lower plane is inside, the upper is not.
            if (above != (side == 1)) return false;
            continue;
        }
        const DrrTwofold s = drr_divide(off, slope);
        if ((slope.high > 0.0f) == (side == 0)) {
            ray.enter = drr_larger(ray.enter, s);
        } else {
            ray.leave = drr_smaller(ray.leave, s);
        }
    }
    return true;
}

// World length of a step of one slice.
DRR_FUNCTION float drr_cm_per_slice(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrRay &ray) {
    float squares = 0.0f;
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        const DrrTwofold u = drr_multiply(ray.slope[0], launch.millimetres[ray.across[0]][i]);
        const DrrTwofold v = drr_multiply(ray.slope[1], launch.millimetres[ray.across[1]][i]);
        const float component = drr_rounded(drr_add(drr_add(u, v), launch.millimetres[ray.axis][i]));
        squares = drr_fma(component, component, squares);
    }
    return 0.1f * drr_sqrt(squares);
}

// The ray of a pixel; false when it misses the volume.
DRR_FUNCTION bool drr_ray(DRR_CONSTANT DrrLaunch &launch, DRR_CONSTANT DrrBeam &beam, DrrTwofold column, DrrTwofold row,
                          DRR_THREAD DrrRay &ray) {
    DrrTwofold direction[3], anchor[3];
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        direction[i] = drr_at(beam.direction[i], column, row);
        anchor[i] = drr_at(beam.anchor[i], column, row);
    }
    const uint a = drr_driving_axis(direction);
    ray.axis = a;
    ray.across[0] = a == 0 ? 1 : 0;
    ray.across[1] = a == 2 ? 1 : 2;
    DRR_UNROLL
    for (uint t = 0; t < 2; t++) {
        const uint b = ray.across[t];
        ray.slope[t] = drr_divide(direction[b], direction[a]);
        if (beam.anchor_kind == DRR_ANCHOR_MOMENT) {
            // moment = point x direction, and the point sought has 0 along the driving axis.
            const uint third = 3 - a - b;
            const bool ascending = (a + 1) % 3 == b;
            ray.base[t] = drr_divide(ascending ? drr_negated(anchor[third]) : anchor[third], direction[a]);
        } else {
            ray.base[t] = drr_subtract(anchor[b], drr_multiply(ray.slope[t], anchor[a]));
        }
    }
    const float extent = drr_half_extent(launch, a);
    ray.enter = drr_twofold(-extent);
    ray.leave = drr_twofold(extent);
    const bool forward = direction[a].high > 0.0f;
    if (beam.ends & DRR_ENDS_AT_SOURCE) {
        if (forward) ray.enter = drr_larger(ray.enter, beam.source[a]);
        else ray.leave = drr_smaller(ray.leave, beam.source[a]);
    }
    if (beam.ends & DRR_ENDS_AT_PIXEL) {
        const DrrTwofold pixel = drr_at(beam.pixel[a], column, row);
        if (forward) ray.leave = drr_smaller(ray.leave, pixel);
        else ray.enter = drr_larger(ray.enter, pixel);
    }
    for (uint t = 0; t < 2; t++) {
        if (!drr_clip(ray, t, drr_half_extent(launch, ray.across[t]), 2.0f * extent)) return false;
    }
    if (!drr_less(ray.enter, ray.leave)) return false;
    ray.cm_per_slice = drr_cm_per_slice(launch, ray);
    return true;
}

#endif
