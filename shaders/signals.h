// Several signals of one ray: sums over the same energies by DRR_SIGNALS rows of weights, behind what the ray met in the
// volume and DRR_BEFORE materials before it.
#ifndef DRR_SIGNALS_H
#define DRR_SIGNALS_H

#include "spectrum.h"

#if defined(DRR_SIGNALS)

#if !defined(DRR_BEFORE)
#define DRR_BEFORE 0
#endif

// What a ray meets: labels of the volume, then what lies before it.
#define DRR_PARTS (DRR_MAX_LABELS + DRR_BEFORE)
#define DRR_MEETS(part) ((part) >= DRR_MAX_LABELS || DRR_HAS((part) % DRR_MAX_LABELS))

// The planes that a launch reads and writes. Pixel (i, j) is at j * width + i of a plane.
struct DrrSignals {
    const DRR_DEVICE float *DRR_RESTRICT before; // g/cm^2, a plane for each material
    DRR_DEVICE float *DRR_RESTRICT passing;      // a plane for each view and row, the rows of a view together
    DRR_DEVICE float *DRR_RESTRICT open;         // a plane for each row
};

// The row of a part in the table of mass attenuation.
DRR_FUNCTION uint drr_row_of(uint part) {
    return part < DRR_MAX_LABELS ? part : part - DRR_MAX_LABELS + DRR_MATERIALS;
}

// Sums 2^(reference - depth) over the energies by every row of weights, as drr_passing does by one.
DRR_FUNCTION void drr_pass(DRR_CONSTANT DrrChannels &channels, DRR_THREAD const DrrSpectra &spectra,
                           DRR_THREAD const float *met, float reference, DRR_THREAD DrrTwofold *sum) {
    const DRR_DEVICE float *const weights = spectra.weight + channels.first_weight;
    const DRR_DEVICE float *const attenuation = spectra.attenuation + channels.first_attenuation;
    DRR_UNROLL
    for (uint row = 0; row < DRR_SIGNALS; row++) sum[row] = drr_twofold(0.0f);
    for (uint first = 0; first < channels.bins; first += DRR_ENERGIES_TOGETHER) {
        float power[DRR_ENERGIES_TOGETHER], four[4];
        DRR_UNROLL
        for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) power[n] = reference;
        DRR_UNROLL
        for (uint part = 0; part < DRR_PARTS; part++) {
            if (!DRR_MEETS(part)) continue;
            DRR_UNROLL
            for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) {
                if (n % 4 == 0) drr_load_four(attenuation + drr_row_of(part) * channels.bins + first + n, four);
                power[n] = drr_fma(-four[n % 4], met[part], power[n]);
            }
        }
        DRR_UNROLL
        for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) power[n] = drr_power_of_2(power[n]);
        DRR_UNROLL
        for (uint row = 0; row < DRR_SIGNALS; row++) {
            float block = 0.0f;
            DRR_UNROLL
            for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) {
                if (n % 4 == 0) drr_load_four(weights + row * channels.bins + first + n, four);
                block = drr_fma(four[n % 4], power[n], block);
            }
            drr_add_to(sum[row], block);
        }
    }
}

// The logarithm of what passes by one row, by the logarithms of the weights: as drr_faint_line_integral.
DRR_FUNCTION float drr_faint_logarithm(DRR_CONSTANT DrrChannels &channels, DRR_THREAD const DrrSpectra &spectra,
                                       DRR_THREAD const float *met, uint row) {
    const DRR_DEVICE float *const logarithm =
        spectra.weight + channels.first_weight + (DRR_SIGNALS + row) * channels.bins;
    float least = 0.0f, sum = 0.0f;
    for (uint pass = 0; pass < 2; pass++) {
        for (uint k = 0; k < channels.bins; k++) {
            float depth = -DRR_LOG2_E * logarithm[k];
            DRR_UNROLL
            for (uint part = 0; part < DRR_PARTS; part++) {
                const uint place = channels.first_attenuation + drr_row_of(part) * channels.bins + k;
                if (DRR_MEETS(part)) depth = drr_fma(spectra.attenuation[place], met[part], depth);
            }
            if (pass == 0) least = k == 0 ? depth : drr_min(least, depth);
            else sum += drr_power_of_2(least - depth);
        }
    }
    return drr_fma(-DRR_LN_2, least, drr_log(sum));
}

// Writes what passes of every row behind areal densities, g/cm^2: the part, or below DRR_FAINT its logarithm, which float32
// can hold always. Planes follow one another, `plane` numbers apart.
DRR_FUNCTION void drr_store_passing(DRR_CONSTANT DrrChannels &channels, DRR_THREAD const DrrSpectra &spectra,
                                    DRR_THREAD const float *areal_density, DRR_DEVICE float *passing, uint plane) {
    float met[DRR_PARTS], present = 0.0f, least = 0.0f;
    DRR_UNROLL
    for (uint part = 0; part < DRR_PARTS; part++) {
        if (!DRR_MEETS(part)) continue;
        present = drr_max(present, areal_density[part]);
        met[part] = DRR_LOG2_E * areal_density[part];
        least = drr_fma(channels.least_attenuation[part], met[part], least);
    }
    if (present == 0.0f) {
        for (uint row = 0; row < DRR_SIGNALS; row++) passing[row * plane] = 1.0f;
        return;
    }
    DrrTwofold sum[DRR_SIGNALS];
    drr_pass(channels, spectra, met, least, sum);
    DRR_UNROLL
    for (uint row = 0; row < DRR_SIGNALS; row++) {
        const float beyond = drr_rounded(drr_divide(sum[row], channels.weight_sum[row]));
        float part = least > 126.0f ? 0.0f : beyond * drr_power_of_2(-least);
        if (beyond < DRR_FAINT) part = drr_faint_logarithm(channels, spectra, met, row);
        else if (part < DRR_FAINT) part = drr_fma(-DRR_LN_2, least, drr_log(beyond));
        passing[row * plane] = part;
    }
}

// All signals of one ray, which is all of its pixel; of view 0 those of the open field as well.
DRR_FUNCTION void drr_store_signals(DRR_CONSTANT DrrLaunch &launch, DRR_CONSTANT DrrChannels &channels,
                                    DRR_THREAD const DrrSpectra &spectra, DRR_THREAD const DrrSignals &signals,
                                    DRR_THREAD const float *areal_density, uint column, uint row, uint view) {
    const uint plane = launch.width * launch.height;
    const uint pixel = row * launch.width + column;
    float met[DRR_PARTS];
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) met[m] = areal_density[m];
#if DRR_BEFORE != 0
    DRR_UNROLL
    for (uint b = 0; b < DRR_BEFORE; b++) met[DRR_MAX_LABELS + b] = signals.before[b * plane + pixel];
#endif
    drr_store_passing(channels, spectra, met, signals.passing + view * DRR_SIGNALS * plane + pixel, plane);
#if defined(DRR_OPEN)
    if (view != 0) return;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) met[m] = 0.0f;
    drr_store_passing(channels, spectra, met, signals.open + pixel, plane);
#endif
}

#endif

#endif
