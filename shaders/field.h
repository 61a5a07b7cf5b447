// A trilinear field with a border of zeros, z fastest: neighbouring rows of the detector find theirs side by side, whatever
// the angle about z.
#ifndef DRR_FIELD_H
#define DRR_FIELD_H

#include "parallel_wire.h"
#include "position.h"

// A sample's place: whole voxels and their fractions, along x, y, z.
struct DrrPoint {
    DrrPosition at[3];
};

// Whether a point is in a cell of the field.
DRR_FUNCTION bool drr_in_field(DRR_CONSTANT DrrParallelLaunch &launch, DRR_THREAD const DrrPoint &point) {
    return (uint)drr_voxel(point.at[0]) < launch.cells[0] && (uint)drr_voxel(point.at[1]) < launch.cells[1] &&
           (uint)drr_voxel(point.at[2]) < launch.cells[2];
}

// The field, and with DRR_DERIVATIVES its slope, per voxel.
struct DrrSample {
    float value;
    float slope[3];
};

// a at 0 … a + slope at 1.
struct DrrEdge {
    float value;
    float slope;
};

DRR_FUNCTION DrrEdge drr_edge(const DRR_DEVICE float *place, float fraction) {
    const float lower = drr_load(place), upper = drr_load(place + 1);
    DrrEdge edge;
    edge.slope = upper - lower;
    edge.value = drr_fma(fraction, edge.slope, lower);
    return edge;
}

// On a plane through voxel centres the slope is the upper cell's. The point is in the field.
DRR_FUNCTION DrrSample drr_sample(DRR_CONSTANT DrrParallelLaunch &launch, const DRR_DEVICE float *field,
                                  DRR_THREAD const DrrPoint &point) {
    const uint x = (uint)drr_voxel(point.at[0]), y = (uint)drr_voxel(point.at[1]), z = (uint)drr_voxel(point.at[2]);
    const float fx = drr_fraction(point.at[0]), fy = drr_fraction(point.at[1]), fz = drr_fraction(point.at[2]);
    const DRR_DEVICE float *const place = field + (x * launch.stride[0] + y * launch.stride[1] + z);
    const DrrEdge e00 = drr_edge(place, fz);
    const DrrEdge e01 = drr_edge(place + launch.stride[1], fz);
    const DrrEdge e10 = drr_edge(place + launch.stride[0], fz);
    const DrrEdge e11 = drr_edge(place + launch.stride[0] + launch.stride[1], fz);
    const float y0 = e01.value - e00.value, y1 = e11.value - e10.value;
    const float v0 = drr_fma(fy, y0, e00.value), v1 = drr_fma(fy, y1, e10.value);
    DrrSample sample;
    sample.slope[0] = v1 - v0;
    sample.value = drr_fma(fx, sample.slope[0], v0);
#if defined(DRR_DERIVATIVES)
    const float z0 = drr_fma(fy, e01.slope - e00.slope, e00.slope);
    const float z1 = drr_fma(fy, e11.slope - e10.slope, e10.slope);
    sample.slope[1] = drr_fma(fx, y1 - y0, y0);
    sample.slope[2] = drr_fma(fx, z1 - z0, z0);
#endif
    return sample;
}

#endif
