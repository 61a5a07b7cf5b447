// What shaders/tables.h makes of the tables that a view brings: what src/physics/model.rs makes of them in float64.
#include "../../shaders/tables.h"

#include <cstdio>
#include <cstdlib>
#include <vector>

enum { ENERGIES = 9, MATERIALS = 3, FIRST_WEIGHT = 5, FIRST_ATTENUATION = 4 };

#define CHECK(condition)                                                                  \
    do {                                                                                  \
        if (!(condition)) {                                                               \
            std::fprintf(stderr, "%s:%d: not %s\n", __FILE__, __LINE__, #condition);      \
            std::exit(1);                                                                 \
        }                                                                                 \
    } while (0)

static bool near(double a, double b) { return std::fabs(a - b) <= 4e-7 * std::fabs(b); }

// Energies without weight first, last, alone and together; weights from the smallest normal number up.
static const float photons[ENERGIES] = {0, 3.0e7f, 0, 0, 1.2e-38f, 2.5e6f, 4.0f, 9.0e8f, 0};
static float coefficient(unsigned m, unsigned k) { return 0.1f * (float)(m + 1) + 1.0f / (float)(k + 2 + m); }

static void prepares(bool own_weight, bool own_attenuation) {
    std::vector<float> own[2] = {std::vector<float>(ENERGIES), std::vector<float>(MATERIALS *ENERGIES)};
    std::vector<float> scene[2] = {own[0], own[1]};
    std::vector<float> weights(FIRST_WEIGHT + 2 * ENERGIES + 1, -7.0f);
    std::vector<float> attenuations(FIRST_ATTENUATION + MATERIALS * ENERGIES + 1, -7.0f);
    for (unsigned k = 0; k < ENERGIES; k++) {
        own[0][k] = photons[k];
        scene[0][k] = photons[ENERGIES - 1 - k];
        weights[FIRST_WEIGHT + k] = scene[0][k];
    }
    for (unsigned m = 0; m < MATERIALS; m++) {
        for (unsigned k = 0; k < ENERGIES; k++) {
            own[1][m * ENERGIES + k] = coefficient(m, k);
            scene[1][m * ENERGIES + k] = coefficient(m + 1, k);
            attenuations[FIRST_ATTENUATION + m * ENERGIES + k] = scene[1][m * ENERGIES + k];
        }
    }
    DrrBeam beam = {};
    beam.bins = ENERGIES;
    beam.first_weight = FIRST_WEIGHT;
    beam.first_attenuation = FIRST_ATTENUATION;
    drr_prepare_tables(beam, weights.data(), attenuations.data(), own_weight ? own[0].data() : nullptr,
                       own_attenuation ? own[1].data() : nullptr, MATERIALS);

    const std::vector<float> &weight = own_weight ? own[0] : scene[0];
    const std::vector<float> &attenuation = own_attenuation ? own[1] : scene[1];
    double i0 = 0.0, sum = 0.0;
    for (float w : weight) i0 += w;
    unsigned bin = 0;
    for (unsigned k = 0; k < ENERGIES; k++) {
        if (weight[k] == 0.0f) continue;
        CHECK(near(weights[FIRST_WEIGHT + bin], (float)(weight[k] / i0)) || weight[k] < 1e-37f);
        CHECK(near(weights[FIRST_WEIGHT + 5 + bin], std::log(weight[k] / i0)) || weight[k] / i0 > 0.9);
        for (unsigned m = 0; m < MATERIALS; m++) {
            CHECK(attenuations[FIRST_ATTENUATION + m * 5 + bin] == attenuation[m * ENERGIES + k]);
            CHECK(beam.least_attenuation[m] <= attenuation[m * ENERGIES + k]);
        }
        sum += weights[FIRST_WEIGHT + bin];
        bin++;
    }
    CHECK(bin == 5 && beam.bins == bin);
    CHECK(near(beam.i0, i0));
    CHECK(std::fabs((double)beam.weight_sum.high + beam.weight_sum.low - sum) < 1e-13);
    for (unsigned m = 0; m < MATERIALS; m++) {
        bool is_one = false;
        for (unsigned k = 0; k < ENERGIES; k++) {
            is_one = is_one || (weight[k] > 0.0f && beam.least_attenuation[m] == attenuation[m * ENERGIES + k]);
        }
        CHECK(is_one);
    }
    // The neighbours' tables.
    CHECK(weights[FIRST_WEIGHT - 1] == -7.0f && weights.back() == -7.0f);
    CHECK(attenuations[FIRST_ATTENUATION - 1] == -7.0f && attenuations.back() == -7.0f);
}

int main() {
    prepares(true, true);
    prepares(true, false);
    prepares(false, true);
    std::printf("PASS\n");
}
