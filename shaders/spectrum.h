// From areal densities to the detector's signal, once per ray. As src/engine/cpu/signal.rs does it for the CPU.
#ifndef DRR_SPECTRUM_H
#define DRR_SPECTRUM_H

#include "sums.h"

// The tables of all views: weights by energy, followed by their logarithms; and mass attenuation by material and energy,
// cm^2/g.
struct DrrSpectra {
    const DRR_DEVICE float *DRR_RESTRICT weight;
    const DRR_DEVICE float *DRR_RESTRICT attenuation;
};

struct DrrSignal {
    float intensity;
    float line_integral;
};

// Energies that are summed in float32 before the sum goes to a twofold one.
#define DRR_ENERGIES_TOGETHER 8

// exp(-x) for x >= 0: relative error below 2e-7 + x * 1e-7; 0 below 2^-126. Taylor's series on |r| <= ln(2)/2, where
// the first term left out is below 6e-9.
DRR_FUNCTION float drr_exp_minus(float x) {
    const float y = x * -1.44269504f;
    const float whole = drr_rint(y);
    const float r = (y - whole) * 0.693147181f;
    float series = 1.0f / 5040.0f;
    series = drr_fma(series, r, 1.0f / 720.0f);
    series = drr_fma(series, r, 1.0f / 120.0f);
    series = drr_fma(series, r, 1.0f / 24.0f);
    series = drr_fma(series, r, 1.0f / 6.0f);
    series = drr_fma(series, r, 0.5f);
    series = drr_fma(series, r, 1.0f);
    series = drr_fma(series, r, 1.0f);
    const float power = drr_float_of_bits((uint)((int)drr_max(whole, -126.0f) + 127) << 23);
    return y < -126.0f ? 0.0f : series * power;
}

// Optical depth at an energy.
DRR_FUNCTION float drr_depth(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra,
                             DRR_THREAD const float *areal_density, uint energy) {
    const DRR_DEVICE float *const attenuation = spectra.attenuation + beam.first_attenuation + energy;
    float depth = 0.0f;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) depth = drr_fma(attenuation[m * beam.bins], areal_density[m], depth);
    }
    return depth;
}

// The depth at an energy; of a faint ray, with what its weight makes of it.
DRR_FUNCTION float drr_depth_seen(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra,
                                  DRR_THREAD const float *areal_density, uint energy, bool faint) {
    const float depth = drr_depth(beam, spectra, areal_density, energy);
    return faint ? depth - spectra.weight[beam.first_weight + beam.bins + energy] : depth;
}

// Log-sum-exp: with depths tau_k and t = min tau_k, p = t - ln sum w_k exp(t - tau_k). Nothing overflows, and the
// intensity underflows to 0 while p stays finite.
DRR_FUNCTION DrrSignal drr_sum_over_energies(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra,
                                             DRR_THREAD const float *areal_density, bool faint) {
    const DRR_DEVICE float *const weight = spectra.weight + beam.first_weight;
    float least = drr_depth_seen(beam, spectra, areal_density, 0, faint);
    for (uint k = 1; k < beam.bins; k++) {
        least = drr_min(least, drr_depth_seen(beam, spectra, areal_density, k, faint));
    }
    DrrTwofold sum = drr_twofold(0.0f);
    for (uint first = 0; first < beam.bins; first += DRR_ENERGIES_TOGETHER) {
        float block = 0.0f;
        DRR_UNROLL
        for (uint n = 0; n < DRR_ENERGIES_TOGETHER; n++) {
            const uint energy = first + n < beam.bins ? first + n : beam.bins - 1;
            const float counts = first + n < beam.bins ? (faint ? 1.0f : weight[energy]) : 0.0f;
            const float depth = drr_depth_seen(beam, spectra, areal_density, energy, faint);
            block = drr_fma(counts, drr_exp_minus(depth - least), block);
        }
        const DrrTwofold next = drr_sum_of(sum.high, block);
        sum = drr_renormalised(next.high, sum.low + next.low);
    }
    DrrSignal signal;
    const float passing = drr_rounded(drr_divide(sum, beam.weight_sum));
    signal.intensity = beam.i0 * (passing * drr_exp_minus(least));
    signal.line_integral = least - drr_log(passing);
    return signal;
}

// A line integral that exceeds the least depth by this is due to energies whose weight float32 holds badly or not at all.
#define DRR_FAINT 69.0f

// Intensity and line integral.
DRR_FUNCTION DrrSignal drr_signal(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra,
                                  DRR_THREAD const float *areal_density) {
    DrrSignal signal;
    signal.intensity = beam.i0;
    signal.line_integral = 0.0f;
    float present = 0.0f;
    DRR_UNROLL
    for (uint m = 0; m < DRR_MAX_LABELS; m++) {
        if (DRR_HAS(m)) present = drr_max(present, areal_density[m]);
    }
    if (present == 0.0f) return signal;
    signal = drr_sum_over_energies(beam, spectra, areal_density, false);
    if (signal.line_integral > DRR_FAINT) signal = drr_sum_over_energies(beam, spectra, areal_density, true);
    return signal;
}

#endif
