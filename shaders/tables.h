// The spectral tables that a view brings itself, for engines whose host cannot read them: a kernel of its own makes of them
// what src/engine/gpu/spectra.rs makes of the scene's, before the projection reads it.
#ifndef DRR_TABLES_H
#define DRR_TABLES_H

#include "spectrum.h"

// The logarithm of no weight, as far as float32 sums can tell.
#define DRR_NO_WEIGHT -1e30f

DRR_FUNCTION uint drr_padded(uint energies) {
    return (energies + DRR_ENERGIES_TOGETHER - 1) / DRR_ENERGIES_TOGETHER * DRR_ENERGIES_TOGETHER;
}

// Drops energies without weight from a row of coefficients, and fills it up to whole groups with the last that is kept.
// What is written to `kept` never lies beyond what is still to be read from `row`. The least that is kept.
DRR_FUNCTION float drr_keep_row(const DRR_DEVICE float *weight, uint energies, const DRR_DEVICE float *row,
                                DRR_DEVICE float *kept) {
    uint bins = 0;
    float least = 0.0f, last = 0.0f;
    for (uint k = 0; k < energies; k++) {
        if (!(weight[k] > 0.0f)) continue;
        last = row[k];
        least = bins == 0 ? last : drr_min(least, last);
        kept[bins++] = last;
    }
    for (; bins % DRR_ENERGIES_TOGETHER != 0; bins++) kept[bins] = last;
    return least;
}

// Drops energies without weight, normalises the weights and lets their logarithms follow. What the beam says of them.
DRR_FUNCTION void drr_keep_weights(DRR_DEVICE DrrBeam &beam, DRR_DEVICE float *weight, uint energies) {
    DrrTwofold photons = drr_twofold(0.0f);
    uint bins = 0;
    for (uint k = 0; k < energies; k++) {
        if (!(weight[k] > 0.0f)) continue;
        photons = drr_add(photons, drr_twofold(weight[k]));
        weight[bins++] = weight[k];
    }
    const float i0 = drr_rounded(photons);
    const uint padded = drr_padded(bins);
    DrrTwofold sum = drr_twofold(0.0f);
    for (uint k = 0; k < padded; k++) {
        weight[padded + k] = k < bins ? drr_log(weight[k]) - drr_log(i0) : DRR_NO_WEIGHT;
        weight[k] = k < bins ? weight[k] / i0 : 0.0f;
        sum = drr_add(sum, drr_twofold(weight[k]));
    }
    beam.all.bins = padded;
    beam.i0 = i0;
    beam.all.weight_sum.high = sum.high;
    beam.all.weight_sum.low = sum.low;
}

// Prepares the tables of one view. The host has left room for `beam.all.bins` energies, padded, and the scene's tables there:
// photons by energy, not normalised, and mass attenuation by material and energy, each row padded. `own_weight` and
// `own_attenuation`, which is without padding, take their places unless they are null.
DRR_FUNCTION void drr_prepare_tables(DRR_DEVICE DrrBeam &beam, DRR_DEVICE float *weights, DRR_DEVICE float *attenuations,
                                     const DRR_DEVICE float *own_weight, const DRR_DEVICE float *own_attenuation,
                                     uint materials) {
    DRR_DEVICE float *const weight = weights + beam.all.first_weight;
    DRR_DEVICE float *const attenuation = attenuations + beam.all.first_attenuation;
    const uint energies = beam.all.bins;
    uint bins = 0;
    for (uint k = 0; k < energies; k++) {
        if (own_weight) weight[k] = own_weight[k];
        if (weight[k] > 0.0f) bins++;
    }
    for (uint m = 0; m < materials; m++) {
        DRR_DEVICE float *const row = attenuation + m * drr_padded(energies);
        for (uint k = 0; own_attenuation && k < energies; k++) row[k] = own_attenuation[m * energies + k];
        beam.least_attenuation[m] = drr_keep_row(weight, energies, row, attenuation + m * drr_padded(bins));
    }
    drr_keep_weights(beam, weight, energies);
}

#endif
