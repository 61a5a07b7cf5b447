// From areal densities to the detector's signal, once per ray. As src/engine/cpu/signal.rs does it for the CPU.
#ifndef DRR_SPECTRUM_H
#define DRR_SPECTRUM_H

#include "sums.h"

// The tables of all views: weights by energy, followed by their logarithms; and mass attenuation by material and
// energy, cm^2/g.
struct DrrSpectra {
    const DRR_DEVICE float *DRR_RESTRICT weight;
    const DRR_DEVICE float *DRR_RESTRICT attenuation;
};

struct DrrSignal {
    float intensity;
    float line_integral;
};

// Energies of which tables hold a multiple, the last ones without weight, and which are summed in float32 before the sum
// goes to a twofold one.
#define DRR_ENERGIES_TOGETHER 8

#define DRR_LOG2_E 1.44269504f
#define DRR_LN_2 0.693147181f

// 2^y for y <= 0, relative error below 1e-7; 2^-126 for what is less. The polynomial is the minimax one for 2^r with
// |r| <= 1/2 that is exact at 0, to 2e-9.
DRR_FUNCTION float drr_power_of_2(float y) {
    const float kept = drr_max(y, -126.0f);
    // Adding 1.5 * 2^23 leaves the nearest whole number in the lowest bits.
    const float shifted = kept + 12582912.0f;
    const float r = kept - (shifted - 12582912.0f);
    float power = 1.5353362e-4f;
    power = drr_fma(power, r, 1.3398874e-3f);
    power = drr_fma(power, r, 9.6184369e-3f);
    power = drr_fma(power, r, 5.5503324e-2f);
    power = drr_fma(power, r, 2.4022648e-1f);
    power = drr_fma(power, r, 6.9314718e-1f);
    power = drr_fma(power, r, 1.0f);
    return drr_float_of_bits(drr_bits_of_float(power) + (drr_bits_of_float(shifted) << 23));
}

// exp(-x) for x >= 0; 0 below 2^-126.
DRR_FUNCTION float drr_exp_minus(float x) {
    const float y = x * -DRR_LOG2_E;
    return y < -126.0f ? 0.0f : drr_power_of_2(y);
}

// Sums 2^(reference - depth) over the energies by their weights; depths and areal densities are in powers of 2.
DRR_FUNCTION float drr_passing(DRR_CONSTANT DrrTable &table, DRR_THREAD const DrrSpectra &spectra,
                               DRR_THREAD const float *areal_density, float reference) {
    const DRR_DEVICE float *const weights = spectra.weight + table.first_weight;
    const DRR_DEVICE float *const attenuation = spectra.attenuation + table.first_attenuation;
    DrrTwofold sum = drr_twofold(0.0f);
    for (uint first = 0; first < table.bins; first += DRR_ENERGIES_TOGETHER) {
        float power[DRR_ENERGIES_TOGETHER], four[4];
        DRR_UNROLL
        for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) power[n] = reference;
        DRR_UNROLL
        for (uint m = 0; m < DRR_MAX_LABELS; m++) {
            if (!DRR_HAS(m)) continue;
            DRR_UNROLL
            for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) {
                if (n % 4 == 0) drr_load_four(attenuation + m * table.bins + first + n, four);
                power[n] = drr_fma(-four[n % 4], areal_density[m], power[n]);
            }
        }
        float block = 0.0f;
        DRR_UNROLL
        for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) {
            if (n % 4 == 0) drr_load_four(weights + first + n, four);
            block = drr_fma(four[n % 4], drr_power_of_2(power[n]), block);
        }
        drr_add_to(sum, block);
    }
    return drr_rounded(drr_divide(sum, table.weight_sum));
}

// The line integral, in powers of 2, by the logarithms of the weights: for rays that pass only where the weight is one
// that float32 holds badly or not at all.
DRR_FUNCTION float drr_faint_line_integral(DRR_CONSTANT DrrTable &table, DRR_THREAD const DrrSpectra &spectra,
                                           DRR_THREAD const float *areal_density) {
    const DRR_DEVICE float *const logarithm = spectra.weight + table.first_weight + table.bins;
    float least = 0.0f, sum = 0.0f;
    for (uint pass = 0; pass < 2; pass++) {
        for (uint k = 0; k < table.bins; k++) {
            float depth = -DRR_LOG2_E * logarithm[k];
            DRR_UNROLL
            for (uint m = 0; m < DRR_MAX_LABELS; m++) {
                const uint place = table.first_attenuation + m * table.bins + k;
                if (DRR_HAS(m)) depth = drr_fma(spectra.attenuation[place], areal_density[m], depth);
            }
            if (pass == 0) least = k == 0 ? depth : drr_min(least, depth);
            else sum += drr_power_of_2(least - depth);
        }
    }
    return least - DRR_LOG2_E * drr_log(sum);
}

// The table that a ray is summed over: the few energies only where their error is known.
DRR_FUNCTION DRR_CONSTANT DrrTable &drr_table(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const float *areal_density) {
#if defined(DRR_FEW_ENERGIES)
    bool known = true;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) known = known && areal_density[m] <= beam.few_up_to[m];
    }
    if (known) return beam.few;
#else
    (void)areal_density;
#endif
    return beam.all;
}

// What is left of the weights below which they are not trusted.
#define DRR_FAINT 1e-30f

// Intensity and line integral, by log-sum-exp: with depths tau_k and t <= min tau_k, p = t - ln sum w_k exp(t - tau_k).
// Nothing overflows, and the intensity underflows to 0 while p stays finite.
DRR_FUNCTION DrrSignal drr_signal(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra,
                                  DRR_THREAD const float *areal_density) {
    DrrSignal signal;
    signal.intensity = beam.i0;
    signal.line_integral = 0.0f;
    float in_powers_of_2[DRR_MAX_LABELS], present = 0.0f, least = 0.0f;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (!DRR_HAS(m)) continue;
        present = drr_max(present, areal_density[m]);
        in_powers_of_2[m] = DRR_LOG2_E * areal_density[m];
        least = drr_fma(beam.least_attenuation[m], in_powers_of_2[m], least);
    }
    if (present == 0.0f) return signal;
    DRR_CONSTANT DrrTable &table = drr_table(beam, areal_density);
    const float passing = drr_passing(table, spectra, in_powers_of_2, least);
    if (passing < DRR_FAINT) {
        signal.line_integral = DRR_LN_2 * drr_faint_line_integral(beam.all, spectra, in_powers_of_2);
        signal.intensity = beam.i0 * drr_exp_minus(signal.line_integral);
        return signal;
    }
    signal.line_integral = drr_fma(DRR_LN_2, least, -drr_log(passing));
    signal.intensity = least > 126.0f ? 0.0f : beam.i0 * (passing * drr_power_of_2(-least));
    return signal;
}

#endif
