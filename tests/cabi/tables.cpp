// What shaders/tables.h makes of the tables that a view brings, against float64; and that it stays within its room.
#define DRR_LABELS 7
#define DRR_MATERIALS 3
// The kernel text leaves unused what its definitions switch off.
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include "../../shaders/tables.h"

#include <cstdio>
#include <cstdlib>
#include <vector>

enum { ENERGIES = 9, MATERIALS = 3, PADDED = 16, FIRST = 8 };

#define CHECK(condition)                                                                  \
    do {                                                                                  \
        if (!(condition)) {                                                               \
            std::fprintf(stderr, "%s:%d: not %s\n", __FILE__, __LINE__, #condition);      \
            std::exit(1);                                                                 \
        }                                                                                 \
    } while (0)

typedef std::vector<float> Table;

static const float OUTSIDE = -7.0f;

static bool near(double a, double b, double error) { return std::fabs(a - b) <= error * std::fabs(b); }

// The array of all views' tables: rows of this view's, padded, with others' before and after.
static Table room(const Table &table, unsigned rows, unsigned copies) {
    Table all(FIRST + copies * rows * PADDED + 1, OUTSIDE);
    for (unsigned row = 0; row < copies * rows; row++) {
        for (unsigned k = 0; k < PADDED; k++) {
            all[FIRST + row * PADDED + k] = k < ENERGIES ? table[row % rows * ENERGIES + k] : 0.0f;
        }
    }
    return all;
}

static void check_row(const float *row, const float *table, const std::vector<unsigned> &kept, unsigned padded, float least) {
    float smallest = table[kept[0]];
    for (unsigned bin = 0; bin < padded; bin++) {
        CHECK(row[bin] == table[kept[bin < kept.size() ? bin : kept.size() - 1]]);
        smallest = std::fmin(smallest, row[bin]);
    }
    CHECK(least == smallest);
}

static void check_weights(const DrrBeam &beam, const float *row, const Table &photons, const std::vector<unsigned> &kept) {
    double i0 = 0.0, sum = 0.0;
    for (unsigned k : kept) i0 += photons[k];
    for (unsigned bin = 0; bin < beam.all.bins; bin++) {
        sum += row[bin];
        if (bin >= kept.size()) {
            CHECK(row[bin] == 0.0f && row[beam.all.bins + bin] == -1e30f);
            continue;
        }
        const double weight = photons[kept[bin]] / i0;
        CHECK(near(row[bin], weight, 2e-7) || weight < 1e-37);
        CHECK(std::fabs(row[beam.all.bins + bin] - std::log(weight)) <= 1e-6 + 2e-7 * std::fabs(std::log(weight)) + 4e-6);
    }
    CHECK(near(beam.i0, i0, 1e-7));
    CHECK(near((double)beam.all.weight_sum.high + beam.all.weight_sum.low, sum, 1e-13));
}

static void prepares(const Table &scene_photons, const Table *own_photons, bool own_attenuation) {
    Table scene(MATERIALS * ENERGIES), own(MATERIALS * ENERGIES);
    for (unsigned n = 0; n < MATERIALS * ENERGIES; n++) {
        scene[n] = 0.1f + 1.0f / (float)(n + 2);
        own[n] = 0.2f + 0.01f * (float)(n * 7 % 11);
    }
    Table weights = room(scene_photons, 1, 2), attenuations = room(scene, MATERIALS, 1);
    DrrBeam beam = {};
    beam.all.bins = ENERGIES;
    beam.all.first_weight = beam.all.first_attenuation = FIRST;
    drr_prepare_tables(beam, weights.data(), attenuations.data(), own_photons ? own_photons->data() : nullptr,
                       own_attenuation ? own.data() : nullptr, MATERIALS);

    const Table &photons = own_photons ? *own_photons : scene_photons;
    std::vector<unsigned> kept;
    for (unsigned k = 0; k < ENERGIES; k++) {
        if (photons[k] > 0.0f) kept.push_back(k);
    }
    CHECK(beam.all.bins == (kept.size() + 7) / 8 * 8);
    check_weights(beam, &weights[FIRST], photons, kept);
    for (unsigned m = 0; m < MATERIALS; m++) {
        const Table &table = own_attenuation ? own : scene;
        check_row(&attenuations[FIRST + m * beam.all.bins], &table[m * ENERGIES], kept, beam.all.bins, beam.least_attenuation[m]);
    }
    CHECK(weights[FIRST - 1] == OUTSIDE && weights.back() == OUTSIDE);
    CHECK(attenuations[FIRST - 1] == OUTSIDE && attenuations.back() == OUTSIDE);
}

int main() {
    // Without weight: the first, the last, some together; none; all but one. Down to the smallest normal number.
    const Table spectra[] = {
        {0, 3.0e7f, 0, 0, 1.2e-38f, 2.5e6f, 4.0f, 9.0e8f, 0},
        {1, 2, 3, 4, 5, 6, 7, 8, 9},
        {1, 2, 3, 0, 5, 6, 7, 8, 9},
        {0, 0, 0, 0, 0, 0, 0, 5, 0},
    };
    for (const Table &photons : spectra) {
        prepares(spectra[0], &photons, true);
        prepares(spectra[1], &photons, false);
        prepares(photons, nullptr, true);
    }
    std::printf("PASS\n");
}
