// Sums over equal steps along the rays of a parallel beam, and their derivatives: a sample is at o + k s, so that a derivative
// is (do . sum of slopes) + (ds . sum of k slopes), whatever the parameter.
#ifndef DRR_PARALLEL_H
#define DRR_PARALLEL_H

#include "field.h"

// What rays read beside their view.
struct DrrParallelRays {
    const DRR_DEVICE float *DRR_RESTRICT field;
    const DRR_DEVICE uchar *DRR_RESTRICT mask;           // with DRR_MASK: 0 where a ray does not count
    const DRR_DEVICE DrrInterval *DRR_RESTRICT interval; // with DRR_LENGTHS
    const DRR_DEVICE float *DRR_RESTRICT measured;       // with DRR_RESIDUAL
};

// The field and its slope summed along a ray, in steps; k is counted from the middle one.
struct DrrRaySums {
    DrrTwofold value;
#if defined(DRR_DERIVATIVES)
    DrrTwofold slope[3];
    DrrTwofold moment[3]; // of k * slope
#endif
};

// Keeps of first … last, k, what may be between two planes across one axis; false when nothing is. A plane that is not
// met along the ray is not divided by.
DRR_FUNCTION bool drr_limit(DrrTwofold base, DrrTwofold step, uint cells, float steps, DRR_THREAD float &first,
                            DRR_THREAD float &last) {
    DRR_UNROLL
    for (uint side = 0; side < 2; side++) {
        const float off = drr_rounded(drr_subtract(drr_twofold(side == 0 ? 0.0f : (float)cells), base));
        if (step.high == 0.0f || drr_abs(off) > drr_abs(step.high) * steps) {
            if (side == 0 ? off > 0.0f : off < 0.0f) return false;
            continue;
        }
        const float k = off / step.high;
        if ((step.high > 0.0f) == (side == 0)) first = drr_max(first, k);
        else last = drr_min(last, k);
    }
    return first <= last;
}

// Steps of a ray from one block to the next.
struct DrrSpan {
    DrrCourse course[3];
    int first;
    int end;
};

DRR_FUNCTION DrrPoint drr_point(DRR_THREAD const DrrSpan &span, int steps) {
    DrrPoint point;
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) point.at[i] = span.course[i].at + (DrrPosition)(DrrLong)steps * span.course[i].step;
    return point;
}

// The steps at which a ray can be in the field, and perhaps two more at either end.
DRR_FUNCTION DrrSpan drr_span(DRR_CONSTANT DrrParallelLaunch &launch, DRR_CONSTANT DrrParallelView &view, float middle,
                              uint column, uint row) {
    DrrSpan span;
    span.first = 0;
    span.end = 0;
    DrrTwofold base[3];
    float first = -middle, last = middle;
    bool meets = true;
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        base[i] = drr_at(view.at[i], drr_twofold((float)column), drr_twofold((float)row));
        meets = meets && drr_limit(base[i], view.step[i], launch.cells[i], (float)launch.steps, first, last);
    }
    if (!meets) return span;
    span.first = (int)drr_max(drr_floor(first + middle) - 1.0f, 0.0f);
    span.end = (int)drr_min(drr_floor(last + middle) + 3.0f, (float)launch.steps);
    return span;
}

DRR_FUNCTION void drr_start_courses(DRR_CONSTANT DrrParallelView &view, float k, uint column, uint row,
                                    DRR_THREAD DrrSpan &span) {
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        const DrrTwofold base = drr_at(view.at[i], drr_twofold((float)column), drr_twofold((float)row));
        const DrrTwofold step = view.step[i];
        span.course[i] = drr_course(drr_add(base, drr_multiply(step, drr_twofold(k))), step);
    }
}

// Adds `count` steps, at most DRR_BLOCK, of which the first is k from the middle one.
DRR_FUNCTION void drr_add_block(DRR_CONSTANT DrrParallelLaunch &launch, const DRR_DEVICE float *field,
                                DRR_THREAD const DrrSpan &span, int count, float k, DrrInterval interval,
                                DRR_THREAD DrrRaySums &sums) {
    // Within a block points are on a line to the last bit, and the field is convex.
    int from = 0, to = count;
    while (from < to && !drr_in_field(launch, drr_point(span, from))) from++;
    while (from < to && !drr_in_field(launch, drr_point(span, to - 1))) to--;
    DrrPoint point = drr_point(span, from);
    float value = 0.0f;
#if defined(DRR_DERIVATIVES)
    float slope[3] = {0.0f, 0.0f, 0.0f}, moment[3] = {0.0f, 0.0f, 0.0f}, at = (float)from;
#endif
    DRR_UNROLL_FOUR
    for (int step = from; step < to; step++) {
        DrrSample sample = drr_sample(launch, field, point);
#if defined(DRR_LENGTHS)
        const uint number = (uint)(span.first + step);
        const float part = number == interval.first ? interval.first_part
                                                    : (number + 1 == interval.end ? interval.last_part : 1.0f);
        sample.value *= part;
#if defined(DRR_DERIVATIVES)
        DRR_UNROLL
        for (uint i = 0; i < 3; i++) sample.slope[i] *= part;
#endif
#endif
        value += sample.value;
        DRR_UNROLL
        for (uint i = 0; i < 3; i++) {
            point.at[i] += span.course[i].step;
#if defined(DRR_DERIVATIVES)
            slope[i] += sample.slope[i];
            moment[i] = drr_fma(at, sample.slope[i], moment[i]);
#endif
        }
#if defined(DRR_DERIVATIVES)
        at += 1.0f;
#endif
    }
    drr_add_to(sums.value, value);
#if defined(DRR_DERIVATIVES)
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        drr_add_to(sums.slope[i], slope[i]);
        drr_add_to(sums.moment[i], drr_fma(k, slope[i], moment[i]));
    }
#endif
}

DRR_FUNCTION void drr_integrate(DRR_CONSTANT DrrParallelLaunch &launch, DRR_CONSTANT DrrParallelView &view,
                                const DRR_DEVICE float *field, DrrInterval interval, uint column, uint row,
                                DRR_THREAD DrrRaySums &sums) {
    const float middle = 0.5f * (float)(launch.steps - 1);
    DrrSpan span = drr_span(launch, view, middle, column, row);
    if (span.first < (int)interval.first) span.first = (int)interval.first;
    if (span.end > (int)interval.end) span.end = (int)interval.end;
    drr_start_courses(view, (float)span.first - middle, column, row, span);
    while (span.first < span.end) {
        const int left = span.end - span.first;
        drr_add_block(launch, field, span, left < DRR_BLOCK ? left : DRR_BLOCK, (float)span.first - middle, interval,
                      sums);
        span.first += DRR_BLOCK;
        DRR_UNROLL
        for (uint i = 0; i < 3; i++) drr_advance(span.course[i], DRR_BLOCK);
    }
}

// One ray: its integral, or with DRR_RESIDUAL what that is above the measured one, and with DRR_DERIVATIVES its derivatives.
// Plane p of view w has pixel (i, j) at ((w * planes + p) * height + j) * width + i.
DRR_FUNCTION void drr_parallel_pixel(DRR_CONSTANT DrrParallelLaunch &launch, DRR_CONSTANT DrrParallelView &view,
                                     DRR_THREAD const DrrParallelRays &rays, DRR_DEVICE float *planes, uint column,
                                     uint row, uint number) {
    const uint pixel = row * launch.width + column, plane = launch.width * launch.height;
#if defined(DRR_DERIVATIVES)
    DRR_DEVICE float *const out = planes + (number * DRR_PLANES * plane + pixel);
#else
    DRR_DEVICE float *const out = planes + (number * plane + pixel);
#endif
    DrrRaySums sums;
    sums.value = drr_twofold(0.0f);
#if defined(DRR_DERIVATIVES)
    DRR_UNROLL
    for (uint i = 0; i < 3; i++) {
        sums.slope[i] = drr_twofold(0.0f);
        sums.moment[i] = drr_twofold(0.0f);
    }
#endif
    DrrInterval interval = {0, launch.steps, 1.0f, 1.0f};
#if defined(DRR_LENGTHS)
    interval.first = rays.interval[pixel].first;
    interval.end = rays.interval[pixel].end;
    interval.first_part = rays.interval[pixel].first_part;
    interval.last_part = rays.interval[pixel].last_part;
#endif
#if defined(DRR_MASK)
    const bool counts = rays.mask[pixel] != 0;
#else
    const bool counts = true;
#endif
    if (counts) drr_integrate(launch, view, rays.field, interval, column, row, sums);
    const float value = launch.length * drr_rounded(sums.value);
#if defined(DRR_RESIDUAL)
    out[0] = counts ? value - rays.measured[pixel] : 0.0f;
#else
    out[0] = value;
#endif
#if defined(DRR_DERIVATIVES)
    DRR_UNROLL
    for (uint p = 0; p < DRR_PARAMETERS; p++) {
        float derivative = 0.0f;
        DRR_UNROLL
        for (uint i = 0; i < 3; i++) {
            const float across = drr_fma((float)column, view.motion[p].at[i][1], view.motion[p].at[i][0]);
            const float at = drr_fma((float)row, view.motion[p].at[i][2], across);
            derivative = drr_fma(at, drr_rounded(sums.slope[i]), derivative);
            derivative = drr_fma(view.motion[p].step[i], drr_rounded(sums.moment[i]), derivative);
        }
        out[(p + 1) * plane] = launch.length * derivative;
    }
#endif
}

// One sum over one part of a view's rays of the products of two planes a <= b: product n of (0, 0), (0, 1), … (5, 5).
DRR_FUNCTION void drr_parallel_sum(DRR_CONSTANT DrrParallelLaunch &launch, const DRR_DEVICE float *planes,
                                   DRR_DEVICE float *sums, uint number) {
    const uint plane = launch.width * launch.height;
    uint a = 0, b = number % DRR_PRODUCTS;
    while (b >= DRR_PLANES - a) {
        b -= DRR_PLANES - a;
        a++;
    }
    const uint first = number / DRR_PRODUCTS * launch.part;
    const uint count = plane - first < launch.part ? plane - first : launch.part;
    const DRR_DEVICE float *const one = planes + a * plane + first;
    const DRR_DEVICE float *const other = planes + (a + b) * plane + first;
    DrrTwofold sum = drr_twofold(0.0f);
    DRR_UNROLL_FOUR
    for (uint ray = 0; ray < count; ray++) drr_add_to(sum, drr_load(one + ray) * drr_load(other + ray));
    sums[number] = drr_rounded(sum);
}

// Number of such sums.
DRR_FUNCTION uint drr_parallel_sums(DRR_CONSTANT DrrParallelLaunch &launch) {
    return (launch.width * launch.height + launch.part - 1) / launch.part * DRR_PRODUCTS;
}

#endif
