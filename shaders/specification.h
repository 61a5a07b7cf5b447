// The specification's own inner loop, for comparison only: one accumulator per energy along the ray. At every sample
// the interpolated density is multiplied by the mass attenuation at every energy. The sum over samples and the product
// with attenuation commute, so areal densities give the same number for less: compare drr_signal. Samples are Joseph's;
// their material is the nearest voxel's, as a material index that is interpolated has no meaning.
#ifndef DRR_SPECIFICATION_H
#define DRR_SPECIFICATION_H

#include "joseph.h"
#include "spectrum.h"

// Energies of the specification, 15 … 150 keV.
#define DRR_SPECIFICATION_ENERGIES 136

struct DrrSpecification {
    const DRR_DEVICE float *attenuation;
    uint bins; // energies with weight; what the others come to is not used
    float depth[DRR_SPECIFICATION_ENERGIES];

    DRR_METHOD void begin(DRR_CONSTANT DrrLaunch &, DRR_THREAD const DrrSteps &, DRR_THREAD DrrCourses &, int) {}
    DRR_METHOD DrrTwofold cell(DRR_CONSTANT DrrLaunch &) { return drr_twofold(1.0f); }
    DRR_METHOD float sample() { return 0.5f; }
    DRR_METHOD bool sees_only_matter() { return false; }
    DRR_METHOD bool end_block(DRR_CONSTANT DrrBeam &) { return false; }

    DRR_METHOD void start(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra) {
        attenuation = spectra.attenuation + beam.all.first_attenuation;
        bins = beam.all.bins;
        DRR_UNROLL
        for (uint k = 0; k < DRR_SPECIFICATION_ENERGIES; k++) depth[k] = 0.0f;
    }

    DRR_METHOD void add(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                        DRR_THREAD const DrrSquare &square, float length) {
        float corner[4];
        DRR_UNROLL
        for (uint c = 0; c < 4; c++) corner[c] = drr_density(launch, voxels, square.corner[c]);
        const float density = length * drr_bilinear(corner, square.u, square.v);
        const DrrVoxel lower = square.u < 0.5f ? square.corner[0] : square.corner[1];
        const DrrVoxel upper = square.u < 0.5f ? square.corner[2] : square.corner[3];
        const uint material = drr_label(square.v < 0.5f ? lower : upper);
        const DRR_DEVICE float *const row = attenuation + material * bins;
        DRR_UNROLL
        for (uint k = 0; k < DRR_SPECIFICATION_ENERGIES; k++) depth[k] = drr_fma(density, row[k], depth[k]);
    }

    DRR_METHOD void part(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels, DRR_THREAD const DrrRay &ray,
                         DRR_THREAD const DrrSteps &steps, int cell, DrrTwofold from, DrrTwofold to) {
        add(launch, voxels, drr_square_of_part(launch, voxels, ray, steps, cell), drr_rounded(drr_subtract(to, from)));
    }

    DRR_METHOD void whole(DRR_CONSTANT DrrLaunch &launch, DRR_THREAD const DrrVoxels &voxels,
                          DRR_THREAD const DrrSteps &steps, DRR_THREAD DrrCourses &at, int cell, int end) {
        for (; cell < end; cell++) {
            const DrrPlace place = drr_place(launch, steps, drr_voxel(at.u.at), drr_voxel(at.v.at), cell);
            add(launch, voxels, drr_square(launch, voxels, steps, place, at.u.at, at.v.at), 1.0f);
            at.u.at += at.u.step;
            at.v.at += at.v.step;
        }
    }

    DRR_METHOD float intensity(DRR_CONSTANT DrrBeam &beam, DRR_THREAD const DrrSpectra &spectra, float cm) {
        const DRR_DEVICE float *const weight = spectra.weight + beam.all.first_weight;
        float sum = 0.0f;
        DRR_UNROLL
        for (uint k = 0; k < DRR_SPECIFICATION_ENERGIES; k++) {
            if (k < bins) sum = drr_fma(weight[k], drr_exp_minus(cm * depth[k]), sum);
        }
        return beam.i0 * sum;
    }
};

#endif
