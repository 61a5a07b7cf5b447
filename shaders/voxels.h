// What a voxel holds, however it is stored, and how densities are interpolated between voxels.
#ifndef DRR_VOXELS_H
#define DRR_VOXELS_H

#include "ray.h"

// How voxels are stored, chosen by DRR_VOXELS:
#define DRR_VOXELS_CODED 0   // one 16-bit code each, 8 * value + label, with a frame of one voxel around the volume
#define DRR_VOXELS_DENSE 1   // float32 density and 8-bit label, with the same frame
#define DRR_VOXELS_TEXTURE 2 // the caller's own texture of int16 HU; a table makes codes of them

// How codes become densities, chosen by DRR_DENSITY:
#define DRR_DENSITY_LINE 0   // in proportion to the value
#define DRR_DENSITY_KINK 1   // the lower of two lines
#define DRR_DENSITY_TABLE 2  // a table by value

// A volume's voxels and, where they need one, their table.
struct DrrVoxels {
#if DRR_VOXELS == DRR_VOXELS_TEXTURE
    metal::texture3d<short, metal::access::read> hu;
    const DRR_DEVICE ushort *code_of_hu;
#elif DRR_VOXELS == DRR_VOXELS_DENSE
    const DRR_DEVICE float *DRR_RESTRICT density;
    const DRR_DEVICE uchar *DRR_RESTRICT label;
#else
    const DRR_DEVICE ushort *DRR_RESTRICT code;
#endif
#if DRR_VOXELS != DRR_VOXELS_TEXTURE
    const DRR_DEVICE uchar *DRR_RESTRICT occupied; // see vacuum.h
#endif
#if DRR_DENSITY == DRR_DENSITY_TABLE
    const DRR_DEVICE float *DRR_RESTRICT density_of_value;
#endif
};

// One voxel as it was read.
#if DRR_VOXELS == DRR_VOXELS_DENSE
struct DrrVoxel {
    float density;
    uint label;
};
#else
typedef uint DrrVoxel;
#endif

#if DRR_VOXELS == DRR_VOXELS_TEXTURE

#define DRR_FOLDED 0

// A voxel's indices, and the steps from it to its neighbours across the driving axis and along it.
typedef metal::int3 DrrPlace;

struct DrrSteps {
    DrrPlace u;
    DrrPlace v;
    DrrPlace s;
};

DRR_FUNCTION DrrSteps drr_steps(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrVoxels &, DRR_THREAD const DrrRay &ray) {
    DrrSteps steps;
    const uint3 axes = uint3(ray.across[0], ray.across[1], ray.axis);
    steps.u = metal::int3(axes.x == 0, axes.x == 1, axes.x == 2);
    steps.v = metal::int3(axes.y == 0, axes.y == 1, axes.y == 2);
    steps.s = metal::int3(axes.z == 0, axes.z == 1, axes.z == 2);
    return steps;
}

DRR_FUNCTION DrrPlace drr_place(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrSteps &steps, int u, int v, int s) {
    return u * steps.u + v * steps.v + s * steps.s;
}

// The frame around the volume repeats the outermost voxels.
DRR_FUNCTION DrrVoxel drr_read(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DrrPlace place) {
    const metal::int3 last = metal::int3(launch.dimensions[0], launch.dimensions[1], launch.dimensions[2]) - 1;
    const metal::int3 nearest = metal::clamp(place, metal::int3(0), last);
    const short hu = voxels.hu.read(uint3(nearest)).x;
    return voxels.code_of_hu[as_type<ushort>(hu)];
}

DRR_FUNCTION void drr_read_square(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD const DrrSteps &steps, DrrPlace place, DRR_THREAD DrrVoxel *corner) {
    corner[0] = drr_read(launch, voxels, place);
    corner[1] = drr_read(launch, voxels, place + steps.u);
    corner[2] = drr_read(launch, voxels, place + steps.v);
    corner[3] = drr_read(launch, voxels, place + steps.v + steps.u);
}

#else

// A voxel's place in memory, and the steps from it to its neighbours across the driving axis and along it. Modulo 2^32.
typedef uint DrrPlace;

struct DrrSteps {
    DrrPlace u;
    DrrPlace v;
    DrrPlace s;
    DrrVoxels beyond; // the voxels one step of v further
};

// Where the driving axis is known and u counts voxels one by one, a position along u can count slices as well: its whole
// part is then a place in memory, but for v.
#define DRR_FOLDED (DRR_AXIS == 1 || DRR_AXIS == 2)

// With one driving axis for the launch, the step of 1 is known to the compiler.
DRR_FUNCTION DrrSteps drr_steps(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                DRR_THREAD const DrrRay &ray) {
    DrrSteps steps;
    steps.u = ray.across[0] == 0 ? 1 : launch.stride[1];
    steps.v = ray.across[1] == 1 ? launch.stride[1] : launch.stride[2];
    steps.s = ray.axis == 0 ? 1 : launch.stride[ray.axis];
    steps.beyond = voxels;
#if DRR_VOXELS == DRR_VOXELS_DENSE
    steps.beyond.density += steps.v;
    steps.beyond.label += steps.v;
#else
    steps.beyond.code += steps.v;
#endif
    return steps;
}

DRR_FUNCTION DrrPlace drr_place(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrSteps &steps, int u, int v, int s) {
    return launch.first_voxel + (uint)u * steps.u + (uint)v * steps.v + (uint)s * steps.s;
}

// The voxel `step` further than `place`.
DRR_FUNCTION DrrVoxel drr_read(DRR_THREAD const DrrVoxels &voxels, DrrPlace place, DrrPlace step) {
#if DRR_VOXELS == DRR_VOXELS_DENSE
    DrrVoxel voxel;
    voxel.density = drr_load(voxels.density + place + (DrrLong)step);
    voxel.label = drr_load(voxels.label + place + (DrrLong)step);
    return voxel;
#else
    return drr_load(voxels.code + place + (DrrLong)step);
#endif
}

DRR_FUNCTION DrrVoxel drr_read(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrVoxels &voxels, DrrPlace place) {
    return drr_read(voxels, place, 0);
}

DRR_FUNCTION void drr_read_square(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrVoxels &voxels,
                                  DRR_THREAD const DrrSteps &steps, DrrPlace place, DRR_THREAD DrrVoxel *corner) {
    corner[0] = drr_read(voxels, place, 0);
    corner[1] = drr_read(voxels, place, steps.u);
    corner[2] = drr_read(steps.beyond, place, 0);
    corner[3] = drr_read(steps.beyond, place, steps.u);
}

#endif

#if DRR_VOXELS == DRR_VOXELS_DENSE
DRR_FUNCTION uint drr_label(DrrVoxel voxel) { return voxel.label; }
#else
DRR_FUNCTION uint drr_label(DrrVoxel voxel) { return voxel & 7; }
#endif

// 0 for vacuum with this label; the bits of DRR_UNLIKE are 0 for any voxel with this label.
DRR_FUNCTION uint drr_unlike(DrrVoxel voxel, uint label) {
#if DRR_VOXELS == DRR_VOXELS_DENSE
    return (voxel.label ^ label) | (voxel.density != 0.0f ? 8u : 0u);
#else
    return voxel ^ label;
#endif
}
#define DRR_UNLIKE 7

// g/cm^3.
DRR_FUNCTION float drr_density(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DrrVoxel voxel) {
#if DRR_VOXELS == DRR_VOXELS_DENSE
    return voxel.density;
#elif DRR_DENSITY == DRR_DENSITY_TABLE
    return voxels.density_of_value[voxel >> 3];
#else
    const float value = (float)(int)(voxel & ~7u);
#if DRR_DENSITY == DRR_DENSITY_KINK
    return launch.scale * drr_min(value, drr_fma(launch.kink[1], value, launch.kink[0]));
#else
    return launch.scale * value;
#endif
#endif
}

// Along voxels that all have one label, what is summed are not densities but their stand-ins, which cost less to make.
DRR_FUNCTION DrrStandIn drr_stand_in(DRR_CONSTANT DrrLaunch &launch, uint label) {
#if DRR_VOXELS == DRR_VOXELS_DENSE || DRR_DENSITY == DRR_DENSITY_TABLE
    return {0.0f, 0.0f, 1.0f, 0.0f};
#else
    // Chosen, not indexed: what is indexed has to lie in memory.
    DrrStandIn how = launch.stand_in[0];
    DRR_UNROLL
    for (uint m = 1; m < DRR_MAX_LABELS; m++) {
        if ((DRR_LABELS >> m & 1) && (label == m || DRR_LABELS == 1u << m)) how = launch.stand_in[m];
    }
    return how;
#endif
}

DRR_FUNCTION float drr_standing_in(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                                   DRR_THREAD const DrrStandIn &how, DrrVoxel voxel) {
#if DRR_VOXELS == DRR_VOXELS_DENSE || DRR_DENSITY == DRR_DENSITY_TABLE
    return drr_density(launch, voxels, voxel);
#else
    const float t = drr_number_of_code(voxel, how.origin);
#if DRR_DENSITY == DRR_DENSITY_KINK
    return drr_fma(-how.kink, drr_abs(t), t);
#else
    return t;
#endif
#endif
}

DRR_FUNCTION float drr_between(float a, float b, float fraction) { return drr_fma(fraction, b - a, a); }

#endif
