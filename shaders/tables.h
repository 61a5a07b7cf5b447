// The spectral tables that a view brings itself, for engines whose host cannot read them: a kernel of its own makes of them
// what src/engine/gpu/spectra.rs makes of the scene's, before the projection reads it.
#ifndef DRR_TABLES_H
#define DRR_TABLES_H

#include "twofold.h"

// Prepares the tables of one view. The host has left it room for all energies, `beam.bins`, and the scene's tables there,
// the weights not normalised; `own_weight` (photons by energy) and `own_attenuation` (cm^2/g by material and energy) take
// their places unless they are null. Energies without weight are dropped.
DRR_FUNCTION void drr_prepare_tables(DRR_DEVICE DrrBeam &beam, DRR_DEVICE float *weights, DRR_DEVICE float *attenuations,
                                     const DRR_DEVICE float *own_weight, const DRR_DEVICE float *own_attenuation,
                                     uint materials) {
    DRR_DEVICE float *const weight = weights + beam.first_weight;
    DRR_DEVICE float *const attenuation = attenuations + beam.first_attenuation;
    const uint energies = beam.bins;
    if (own_weight) {
        for (uint k = 0; k < energies; k++) weight[k] = own_weight[k];
    }
    if (own_attenuation) {
        for (uint k = 0; k < materials * energies; k++) attenuation[k] = own_attenuation[k];
    }
    uint bins = 0;
    DrrTwofold photons = drr_twofold(0.0f);
    for (uint k = 0; k < energies; k++) {
        if (!(weight[k] > 0.0f)) continue;
        photons = drr_add(photons, drr_twofold(weight[k]));
        bins++;
    }
    // What is written never lies beyond what is still to be read.
    for (uint m = 0; m < materials; m++) {
        uint bin = m * bins;
        for (uint k = 0; k < energies; k++) {
            if (!(weight[k] > 0.0f)) continue;
            const float coefficient = attenuation[m * energies + k];
            attenuation[bin++] = coefficient;
            beam.least_attenuation[m] = bin == m * bins + 1 ? coefficient : drr_min(beam.least_attenuation[m], coefficient);
        }
    }
    uint bin = 0;
    for (uint k = 0; k < energies; k++) {
        if (weight[k] > 0.0f) weight[bin++] = weight[k];
    }
    const float i0 = drr_rounded(photons);
    DrrTwofold sum = drr_twofold(0.0f);
    for (uint k = 0; k < bins; k++) {
        weight[bins + k] = drr_log(weight[k]) - drr_log(i0);
        weight[k] /= i0;
        sum = drr_add(sum, drr_twofold(weight[k]));
    }
    beam.bins = bins;
    beam.i0 = i0;
    beam.weight_sum.high = sum.high;
    beam.weight_sum.low = sum.low;
}

#endif
