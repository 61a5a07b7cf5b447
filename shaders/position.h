// Positions along a ray as whole voxels and 32 bits of a voxel: integers, so that stepping adds no error, and so that
// the voxel and the place inside it fall out without a conversion.
#ifndef DRR_POSITION_H
#define DRR_POSITION_H

#include "twofold.h"

// Cells after which positions make good what the rounding of their step has cost, and whose sums in float32 go to a
// twofold sum.
#define DRR_BLOCK 64

// Voxels, times 2^32, modulo 2^64.
typedef DrrUlong DrrPosition;

#define DRR_ONE_VOXEL 4294967296.0f

// x to the nearest 2^-32, and what is left, in 2^-32. Not by way of its floor: from a small negative number it takes
// digits.
DRR_FUNCTION DrrPosition drr_split(DrrTwofold x, DRR_THREAD float &rest) {
    const float high = x.high * DRR_ONE_VOXEL, low = x.low * DRR_ONE_VOXEL;
    const float of_high = drr_rint(high), of_low = drr_rint(low);
    rest = (high - of_high) + (low - of_low);
    return (DrrPosition)((DrrLong)of_high + (DrrLong)of_low);
}

DRR_FUNCTION DrrPosition drr_position(DrrTwofold x) {
    float rest;
    return drr_split(x, rest);
}

// The voxel at or below.
DRR_FUNCTION int drr_voxel(DrrPosition x) { return (int)(x >> 32); }

// How far beyond it, 0 … 1.
DRR_FUNCTION float drr_fraction(DrrPosition x) {
    return drr_float_of_bits(((uint)x >> 9) | 0x3f800000u) - 1.0f;
}

DRR_FUNCTION DrrPosition drr_limited(DrrPosition x, DrrPosition last) {
    return (DrrLong)x < 0 ? 0 : x > last ? last : x;
}

// Limited to the volume: in the outer half voxel the edge value holds.
DRR_FUNCTION DrrPosition drr_inside(DrrPosition x, uint voxels) {
    return drr_limited(x, (DrrPosition)(voxels - 1) << 32);
}

// Where a coordinate is, how it changes from cell to cell, and what is to be added after every block of cells.
struct DrrCourse {
    DrrPosition at;
    DrrPosition step;
    int correction;
};

// The coordinates of a ray across the driving axis and along it.
struct DrrCourses {
    DrrCourse u;
    DrrCourse v;
    DrrCourse s;
};

DRR_FUNCTION DrrCourse drr_course(DrrTwofold at, DrrTwofold step) {
    DrrCourse course;
    float rest;
    course.at = drr_position(at);
    course.step = drr_split(step, rest);
    course.correction = (int)drr_rint((float)DRR_BLOCK * rest);
    return course;
}

// Moves on by some cells from the beginning, with the corrections of the blocks between.
DRR_FUNCTION void drr_advance(DRR_THREAD DrrCourse &course, int cells) {
    course.at += (DrrPosition)cells * course.step + (DrrPosition)((DrrLong)(cells / DRR_BLOCK) * course.correction);
}

#endif
