// Areal densities as they grow along a ray.
#ifndef DRR_SUMS_H
#define DRR_SUMS_H

#include "courses.h"

// DRR_LABELS has bit m set when voxels with label m can attenuate. With DRR_ONE_LABEL they are all that the volume
// holds, and nothing has to be told apart.
#define DRR_HAS(label) ((DRR_LABELS >> (label)) & 1)

// Sums over voxels of density and length, the length in cells. Most samples lie between voxels of one label, the same
// as the sample before: they add to a run of stand-ins, and only the others are sorted by label.
struct DrrSums {
    uint label; // of the run
    DrrStandIn how;
    float run;
    float length;
    DrrTwofold total[DRR_MAX_LABELS];
    float cm_per_cell;
};

DRR_FUNCTION void drr_start_run(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD DrrSums &sums, uint label) {
    sums.label = label;
    sums.how = drr_stand_in(launch, label);
    sums.run = 0.0f;
    sums.length = 0.0f;
}

DRR_FUNCTION void drr_end_run(DRR_THREAD DrrSums &sums) {
    const float grams = drr_fma(sums.how.scale, sums.run, sums.how.offset * sums.length);
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) drr_add_to(sums.total[m], DRR_LABELS == 1u << m || sums.label == m ? grams : 0.0f);
    }
    sums.run = 0.0f;
    sums.length = 0.0f;
}

DRR_FUNCTION void drr_start(DRR_CONSTANT DrrLaunch &launch, float cm_per_cell, DRR_THREAD DrrSums &sums) {
    sums.cm_per_cell = cm_per_cell;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) sums.total[m] = drr_twofold(0.0f);
    uint label = 0;
    while (!DRR_HAS(label)) label++;
    drr_start_run(launch, sums, label);
}

// g/cm^2 of one label.
DRR_FUNCTION float drr_areal_density(DRR_THREAD const DrrSums &sums, uint label) {
    return drr_max(drr_rounded(sums.total[label]) * sums.cm_per_cell, 0.0f);
}

#if defined(DRR_EARLY_EXIT)
// Depth at which an early exit may stop: exp(-15) of I0 is left at most, also after depth and intensity were rounded.
#define DRR_OPAQUE_DEPTH 15.0001f

// Whether the most penetrating energy with weight is attenuated so far that the rest of the ray cannot matter.
DRR_FUNCTION bool drr_opaque(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSums &sums) {
    float depth = 0.0f;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) depth = drr_fma(beam.least_attenuation[m], drr_areal_density(sums, m), depth);
    }
    return beam.early_exit && depth > DRR_OPAQUE_DEPTH;
}
#endif

// What is done after every block of cells. Whether to stop here.
DRR_FUNCTION bool drr_end_block(DRR_CONSTANT DrrBeam &beam, DRR_THREAD DrrSums &sums) {
    drr_end_run(sums);
#if defined(DRR_EARLY_EXIT)
    return drr_opaque(beam, sums);
#else
    (void)beam;
    return false;
#endif
}

#endif
