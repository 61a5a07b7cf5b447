// One pixel: its rays, and the layers that were asked for.
#ifndef DRR_PIXEL_H
#define DRR_PIXEL_H

#include "march.h"
#include "siddon.h"
#include "signals.h"
#include "specification.h"
#include "spectrum.h"

// How line integrals are taken, chosen by DRR_ALGORITHM:
#define DRR_JOSEPH 0
#define DRR_MARCH 1
#define DRR_SIDDON 2

#if DRR_ALGORITHM == DRR_JOSEPH
typedef DrrJoseph DrrRule;
#elif DRR_ALGORITHM == DRR_MARCH
typedef DrrMarch DrrRule;
#else
typedef DrrSiddon<DrrSums> DrrRule;
#endif

// Where the layers go. Pixel (i, j) of view v is at (v * height + j) * width + i; of material m of view v at
// ((v * DRR_MATERIALS + m) * height + j) * width + i.
struct DrrImages {
    DRR_DEVICE float *DRR_RESTRICT intensity;
    DRR_DEVICE float *DRR_RESTRICT line_integral;
    DRR_DEVICE float *DRR_RESTRICT areal_density;
    DRR_DEVICE float *DRR_RESTRICT bone_path;
};

// What one ray came to.
struct DrrRayValue {
    DrrSignal signal;
    float areal_density[DRR_MAX_LABELS];
    float bone_path; // mm
};

DRR_FUNCTION void drr_cast(DRR_CONSTANT DrrLaunch &launch, DRR_CONSTANT DrrBeam &beam,
                           DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrSpectra &spectra, DrrTwofold column,
                           DrrTwofold row, DRR_THREAD DrrRayValue &value) {
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) value.areal_density[m] = 0.0f;
    value.bone_path = 0.0f;
    value.signal.intensity = beam.i0;
    value.signal.line_integral = 0.0f;
    DrrRay ray;
    if (!drr_ray(launch, beam, column, row, ray)) return;
#if defined(DRR_SPECIFICATION_LOOP)
    DrrSpecification loop;
    loop.start(beam, spectra);
    drr_walk(launch, beam, voxels, ray, loop);
    value.signal.intensity = loop.intensity(beam, spectra, ray.cm_per_slice);
#else
#if DRR_LABELS != 0
    DrrRule rule;
    rule.start(launch, ray);
    drr_walk(launch, beam, voxels, ray, rule);
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) value.areal_density[m] = drr_areal_density(rule.sums, m);
    }
#if defined(DRR_INTENSITY) || defined(DRR_LINE_INTEGRAL)
    value.signal = drr_signal(beam, spectra, value.areal_density);
#endif
#endif
#if defined(DRR_BONE_PATH)
    DrrSiddon<DrrBonePath> bone;
    bone.start(launch, ray);
    drr_walk(launch, beam, voxels, ray, bone);
    value.bone_path = 10.0f * ray.cm_per_slice * drr_rounded(bone.sums.total);
#endif
#endif
}

DRR_FUNCTION void drr_store(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrImages &images, uint column, uint row,
                            uint view, DRR_THREAD const DrrRayValue &value) {
    const uint plane = launch.width * launch.height;
    const uint pixel = row * launch.width + column;
#if defined(DRR_INTENSITY)
    images.intensity[view * plane + pixel] = value.signal.intensity;
#endif
#if defined(DRR_LINE_INTEGRAL)
    images.line_integral[view * plane + pixel] = value.signal.line_integral;
#endif
#if defined(DRR_AREAL_DENSITY)
    DRR_UNROLL
    for (uint m = 0; m < DRR_MATERIALS; m++) {
        images.areal_density[(view * DRR_MATERIALS + m) * plane + pixel] = value.areal_density[m];
    }
#endif
#if defined(DRR_BONE_PATH)
    images.bone_path[view * plane + pixel] = value.bone_path;
#endif
}

// Column or row of the nth ray along a pixel's side.
DRR_FUNCTION DrrTwofold drr_subray(uint pixel, uint n) {
    return drr_sum_of((float)pixel, ((float)n + 0.5f) / (float)DRR_SUPERSAMPLING - 0.5f);
}

// All rays of a pixel: the detector sums photons, so intensities are averaged, and the line integral is that of the mean,
// by log-sum-exp so that it stays finite when the intensity underflows.
DRR_FUNCTION void drr_pixel(DRR_CONSTANT DrrLaunch &launch, DRR_CONSTANT DrrBeam &beam,
                            DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrSpectra &spectra,
#if defined(DRR_SIGNALS)
                            DRR_CONSTANT DrrChannels &channels, DRR_THREAD const DrrSignals &signals,
#endif
                            DRR_THREAD const DrrImages &images, uint column, uint row, uint view) {
    DrrRayValue first;
    drr_cast(launch, beam, voxels, spectra, drr_subray(column, 0), drr_subray(row, 0), first);
#if DRR_SUPERSAMPLING == 1
    const DrrRayValue pixel = first;
#else
    // Twofold: in float32 equal terms are all rounded the same way. The mean of equal values is that value, bit for bit.
    DrrRayValue pixel;
    DrrTwofold intensity = drr_twofold(first.signal.intensity), bone_path = drr_twofold(first.bone_path);
    DrrTwofold areal_density[DRR_MAX_LABELS], beyond = drr_twofold(1.0f);
    for (uint m = 0; m < DRR_MAX_LABELS; m++) areal_density[m] = drr_twofold(first.areal_density[m]);
    float least = first.signal.line_integral;
    for (uint n = 1; n < DRR_SUPERSAMPLING * DRR_SUPERSAMPLING; n++) {
        DrrRayValue ray;
        drr_cast(launch, beam, voxels, spectra, drr_subray(column, n % DRR_SUPERSAMPLING),
                 drr_subray(row, n / DRR_SUPERSAMPLING), ray);
        drr_add_to(intensity, ray.signal.intensity);
        drr_add_to(bone_path, ray.bone_path);
        for (uint m = 0; m < DRR_MAX_LABELS; m++) drr_add_to(areal_density[m], ray.areal_density[m]);
        const float p = ray.signal.line_integral;
        if (p < least) beyond = drr_multiply(beyond, drr_twofold(drr_exp_minus(least - p)));
        drr_add_to(beyond, p < least ? 1.0f : drr_exp_minus(p - least));
        least = drr_min(p, least);
    }
    const DrrTwofold count = drr_twofold((float)(DRR_SUPERSAMPLING * DRR_SUPERSAMPLING));
    pixel.signal.intensity = drr_rounded(drr_divide(intensity, count));
    pixel.signal.line_integral = least - drr_log(drr_rounded(drr_divide(beyond, count)));
    pixel.bone_path = drr_rounded(drr_divide(bone_path, count));
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        pixel.areal_density[m] = drr_rounded(drr_divide(areal_density[m], count));
    }
#endif
    drr_store(launch, images, column, row, view, pixel);
#if defined(DRR_SIGNALS)
    drr_store_signals(launch, channels, spectra, signals, pixel.areal_density, column, row, view);
#endif
}

#endif
