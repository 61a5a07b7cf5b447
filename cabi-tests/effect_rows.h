/* What the effects of a scene refuse. */
#ifndef EFFECT_ROWS_H
#define EFFECT_ROWS_H

#include "scene_rows.h"

static void counting(Given *g) {
    own_response(g);
    g->to.scene.detector_efficiency = g->to.efficiency;
}
static void two_layers(Given *g) { g->to.scene.second_detector_response = g->to.second_response; }
static void two_counting_layers(Given *g) {
    two_layers(g);
    g->to.scene.second_detector_efficiency = g->to.second_efficiency;
}
static void second_layer_blind(Given *g) {
    two_layers(g);
    memset(g->to.second_response, 0, sizeof g->to.second_response);
}
static void efficiency_alone(Given *g) { g->to.scene.detector_efficiency = g->to.efficiency; }
static void second_efficiency_alone(Given *g) { g->to.scene.second_detector_efficiency = g->to.second_efficiency; }
static void filtered(Given *g) {
    g->to.scene.filters = g->to.filters;
    g->to.scene.filter_count = 2;
}
static void filtered_by_nothing(Given *g) {
    filtered(g);
    g->to.filters[0].material = NULL;
}
static void filtered_by_both(Given *g) {
    filtered(g);
    g->to.filters[0].mass_attenuation = g->to.filter_attenuation;
}
static void implanted(Given *g) {
    g->to.scene.implants = g->to.implants;
    g->to.scene.implant_count = 4;
}
static void blurred(Given *g) {
    g->to.scene.blur = g->to.blur;
    g->to.scene.blur_count = 2;
}
static void blurred_by_a_curve(Given *g) {
    g->to.scene.mtf_frequencies_per_mm = g->to.frequencies;
    g->to.scene.mtf = g->to.mtf;
    g->to.scene.mtf_count = 3;
}
static void blurred_by_both(Given *g) {
    blurred(g);
    blurred_by_a_curve(g);
}
static void heel(Given *g) { g->to.scene.effects |= DRR_EFFECT_HEEL; }
static void focal_spot(Given *g) {
    g->to.scene.effects |= DRR_EFFECT_FOCAL_SPOT;
    g->to.scene.focal_spot_width_mm = g->to.scene.focal_spot_height_mm = 0.5;
}
static void focal_spot_of_no_size(Given *g) { g->to.scene.effects |= DRR_EFFECT_FOCAL_SPOT; }
static void partly_filled(Given *g) { g->to.scene.effects |= DRR_EFFECT_FILL_FACTOR; }
static void scattered(Given *g) {
    g->to.scene.effects |= DRR_EFFECT_SCATTER;
    g->to.scene.scatter_photons = 1000;
}
static void noisy(Given *g) {
    g->to.scene.effects |= DRR_EFFECT_QUANTUM_NOISE | DRR_EFFECT_ELECTRONIC_NOISE;
    g->to.scene.photons_per_pixel = 1000.0;
    g->to.scene.electronic_noise_photons = 2.0;
}
static void noisy_with_a_mean_response(Given *g) {
    noisy(g);
    own_response(g);
}
static void noisy_with_a_second_mean_response(Given *g) {
    noisy(g);
    two_layers(g);
}
/* Effects whose tables are built in, at energies that are not in them. */
static void energies_of_ones_own(Given *g) {
    own_tables(g);
    g->to.scene.first_energy_kev = 15.5;
}
static void heel_between(Given *g) {
    energies_of_ones_own(g);
    heel(g);
}
static void scattered_beyond(Given *g) {
    energies_of_ones_own(g);
    scattered(g);
}
static void filtered_between(Given *g) {
    energies_of_ones_own(g);
    filtered(g);
}
static void filtered_between_at_one_energy(Given *g) {
    filtered_between(g);
    g->to.scene.effects = 0;
    g->to.scene.mono_energy_kev = 70.5;
}

#define PROBABILITY "0 … 1, a probability"
#define SETTING_ROW(field, kind, setting, value, valid) \
    {EACH, "scene." field, kind, setting, NOTHING, INVALID, "scene." field " is " value, valid}
/* A field of a struct in an array of the scene's; `place` is where it is given. */
#define PART_ROW(setting, field, place, type, kind, number, value, valid)                            \
    {EACH, "scene." field, kind, setting, PUT(to.place, type, number), INVALID, "scene." field " is " value, valid}
#define PART_NUMBER_ROWS(setting, field, place, valid)                                               \
    PART_FINITE_ROWS(setting, field, place, valid),                                                  \
    PART_ROW(setting, field, place, double, "huge", 1e300, "1e300;", valid)
#define PART_FINITE_ROWS(setting, field, place, valid)                                               \
    PART_ROW(setting, field, place, double, "negative", -5000.0, "-5000;", valid),                   \
    PART_ROW(setting, field, place, double, "NaN", NAN, "NaN;", valid),                              \
    PART_ROW(setting, field, place, double, "+Inf", INFINITY, "inf;", valid),                        \
    PART_ROW(setting, field, place, double, "-Inf", -INFINITY, "-inf;", valid)
/* A component of a vector, which the message shows as a whole. */
#define PART_VECTOR_ROWS(setting, field, place, called)                                              \
    {EACH, "scene." field, "NaN", setting, PUT(to.place, double, NAN), INVALID, "scene." called " is ", "valid: "},       \
    {EACH, "scene." field, "+Inf", setting, PUT(to.place, double, INFINITY), INVALID, "scene." called " is ", "valid: "},  \
    {EACH, "scene." field, "-Inf", setting, PUT(to.place, double, -INFINITY), INVALID, "scene." called " is ", "valid: "}, \
    {EACH, "scene." field, "huge", setting, PUT(to.place, double, 1e300), INVALID, "scene." called " is ", "valid: "}
#define PART_POINTER_ROW(setting, field, place, pointee, alignment)                                  \
    {EACH, "scene." field, "misaligned", setting, ASKEW(to.place, pointee), INVALID, "scene." field " is 0x",              \
     "aligned to " alignment}
#define PART_NULL_ROW(setting, field, place)                                                         \
    {EACH, "scene." field, "NULL", setting, POINT(to.place, NULL), INVALID, "scene." field " is NULL;", "a pointer to "}
#define PART_COUNT_ROWS(setting, field, place, range, too_many)                                      \
    PART_ROW(setting, field, place, size_t, "zero", 0, "0;", range),                                 \
    PART_ROW(setting, field, place, size_t, "huge", too_many, #too_many ";", range),                 \
    PART_ROW(setting, field, place, size_t, "huge", SIZE_MAX, "18446744073709551615;", range)
#define EFFICIENCY_ROWS(setting, field, table)                                                       \
    TABLE_ROWS(setting, field, table, 7, "[7]", ENERGIES - 1, "[135]", PROBABILITY),                 \
    VALUE_ROW(setting, field, table[7], "[7]", "huge", 1.5f, "1.5", PROBABILITY),                    \
    VALUE_ROW(setting, field, table[7], "[7]", "zero", 0.0f, "0", "above 0, because detector_response[7] is 1")
#define SECTION_ROWS(field) PART_NUMBER_ROWS(implanted, "implants[1].sections[1]." #field, sections[1].field, "1e-6 … 1e6 mm")

static const Row effect_field_rows[] = {
    EFFICIENCY_ROWS(counting, detector_efficiency, efficiency),
    SETTING_ROW("detector_efficiency", "alone", efficiency_alone, "not NULL;", "NULL, because scene.detector_response is"),
    SETTING_ROW("detector_efficiency", "NULL", noisy_with_a_mean_response, "NULL;", "because noise depends on"),
    TABLE_ROWS(two_layers, second_detector_response, second_response, 7, "[7]", ENERGIES - 1, "[135]", WEIGHT_RANGE),
    {EACH, "scene.second_detector_response", "zero", second_layer_blind, NOTHING, INVALID,
     "scene.second_detector_response × spectrum's sum is 0;", "finite, above 0"},
    EFFICIENCY_ROWS(two_counting_layers, second_detector_efficiency, second_efficiency),
    SETTING_ROW("second_detector_efficiency", "alone", second_efficiency_alone, "not NULL;",
                "NULL, because scene.second_detector_response is"),
    SETTING_ROW("second_detector_efficiency", "NULL", noisy_with_a_second_mean_response, "NULL;",
                "because noise depends on"),

    PART_POINTER_ROW(filtered, "filters", scene.filters, filters, "8 bytes"),
    PART_COUNT_ROWS(filtered, "filter_count", scene.filter_count, "1 … 64", 65),
    PART_ROW(filtered, "filters[0].material", filters[0].material, const char *, "unknown", "lead ", "\"lead \";", "air, lung"),
    PART_ROW(filtered, "filters[0].material", filters[0].material, const char *, "not UTF-8", "\xff", "\xef\xbf\xbd;", "UTF-8"),
    SETTING_ROW("filters[0].material", "NULL", filtered_by_nothing, "NULL;", "unless there is mass_attenuation"),
    SETTING_ROW("filters[0].mass_attenuation", "both", filtered_by_both, "not NULL;", "NULL, because material says"),
    PART_POINTER_ROW(filtered, "filters[1].mass_attenuation", filters[1].mass_attenuation, filter_attenuation, "4 bytes"),
    PART_ROW(filtered, "filters[1].mass_attenuation[7]", filter_attenuation[7], float, "negative", -1.0f, "-1;", ATTENUATION_RANGE),
    PART_ROW(filtered, "filters[1].mass_attenuation[135]", filter_attenuation[135], float, "NaN", NAN, "NaN;", ATTENUATION_RANGE),
    PART_ROW(filtered, "filters[1].mass_attenuation[7]", filter_attenuation[7], float, "+Inf", INFINITY, "inf;", ATTENUATION_RANGE),
    PART_ROW(filtered, "filters[1].mass_attenuation[135]", filter_attenuation[135], float, "-Inf", -INFINITY, "-inf;", ATTENUATION_RANGE),
    PART_NUMBER_ROWS(filtered, "filters[1].density", filters[1].density, "1e-6 … 30 g/cm³"),
    PART_ROW(filtered, "filters[1].density", filters[1].density, double, "zero", 0.0, "0;", "1e-6 … 30 g/cm³"),
    PART_NUMBER_ROWS(filtered, "filters[0].thickness_mm", filters[0].thickness_mm, "0 … 1000 mm"),
    PART_POINTER_ROW(filtered, "filters[1].angles_degrees", filters[1].angles_degrees, angles, "8 bytes"),
    PART_NULL_ROW(filtered, "filters[1].angles_degrees", filters[1].angles_degrees),
    PART_NUMBER_ROWS(filtered, "filters[1].angles_degrees[2]", angles[2], "above −90, below 90 degrees"),
    PART_ROW(filtered, "filters[1].angles_degrees[1]", angles[1], double, "descending", -1.0, "-1;", "above the one before"),
    PART_POINTER_ROW(filtered, "filters[1].thicknesses_mm", filters[1].thicknesses_mm, thicknesses, "8 bytes"),
    PART_NULL_ROW(filtered, "filters[1].thicknesses_mm", filters[1].thicknesses_mm),
    PART_NUMBER_ROWS(filtered, "filters[1].thicknesses_mm[2]", thicknesses[2], "0 … 1000 mm"),
    PART_ROW(filtered, "filters[1].point_count", filters[1].point_count, size_t, "one", 1, "1;", "2 … 1024, or 0"),
    PART_ROW(filtered, "filters[1].point_count", filters[1].point_count, size_t, "huge", 1025, "1025;", "2 … 1024, or 0"),
    PART_ROW(filtered, "filters[1].point_count", filters[1].point_count, size_t, "huge", SIZE_MAX, "18446744073709551615;",
             "2 … 1024, or 0"),
    {EACH, "scene.first_energy_kev", "not tabulated for filters", filtered_between, NOTHING, INVALID,
     "scene.first_energy_kev + 0 × energy_step_kev is 15.5 keV;", "whole keV from 15 to 150"},
    {EACH, "scene.mono_energy_kev", "not tabulated for filters", filtered_between_at_one_energy, NOTHING, INVALID,
     "scene.mono_energy_kev is 70.5 keV;", "whole keV from 15 to 150"},

    PART_POINTER_ROW(implanted, "implants", scene.implants, implants, "8 bytes"),
    PART_COUNT_ROWS(implanted, "implant_count", scene.implant_count, "1 … 64", 65),
    PART_ROW(implanted, "implants[2].shape", implants[2].shape, DrrImplantShape, "unknown", 4, "4;", "0 … 3"),
    PART_ROW(implanted, "implants[2].shape", implants[2].shape, DrrImplantShape, "unknown", UINT32_MAX, "4294967295;", "0 … 3"),
    PART_ROW(implanted, "implants[2].material", implants[2].material, uint32_t, "huge", 4, "4;", "below 4"),
    PART_ROW(implanted, "implants[2].material", implants[2].material, uint32_t, "huge", 256, "256;", "0 … 3"),
    PART_ROW(implanted, "implants[2].material", implants[2].material, uint32_t, "huge", UINT32_MAX, "4294967295;", "0 … 3"),
    PART_NUMBER_ROWS(implanted, "implants[0].density", implants[0].density, "1e-6 … 30 g/cm³"),
    PART_VECTOR_ROWS(implanted, "implants[0].position", implants[0].position[1], "implants[0].position"),
    PART_VECTOR_ROWS(implanted, "implants[1].position", implants[1].position[0], "implants[1].position"),
    PART_VECTOR_ROWS(implanted, "implants[2].position", implants[2].position[2], "implants[2].position"),
    PART_VECTOR_ROWS(implanted, "implants[3].position", implants[3].position[2], "implants[3].position"),
    PART_VECTOR_ROWS(implanted, "implants[0].axes", implants[0].axes[1], "implants[0].position + axes[0 .. 3]"),
    {EACH, "scene.implants[0].axes", "zero", implanted, PUT(to.implants[0].axes[0], double, 0.0), INVALID,
     "scene.implants[0].axes[0 .. 3]'s length is 0;", "1e-6 … 1e6 mm"},
    PART_VECTOR_ROWS(implanted, "implants[1].axes", implants[1].axes[2], "implants[1].axes[0 .. 3]"),
    PART_VECTOR_ROWS(implanted, "implants[3].axes", implants[3].axes[5], "implants[3].axes[3 .. 6]"),
    {EACH, "scene.implants[3].axes", "askew", implanted, PUT(to.implants[3].axes[1], double, 0.001), INVALID,
     "scene.implants[3].axes is ", "at right angles"},
    PART_NUMBER_ROWS(implanted, "implants[0].radius_mm", implants[0].radius_mm, "1e-6 … 1e6 mm"),
    PART_NUMBER_ROWS(implanted, "implants[2].radius_mm", implants[2].radius_mm, "1e-6 … 1e6 mm"),
    PART_POINTER_ROW(implanted, "implants[1].sections", implants[1].sections, sections, "8 bytes"),
    PART_NULL_ROW(implanted, "implants[1].sections", implants[1].sections),
    PART_COUNT_ROWS(implanted, "implants[1].section_count", implants[1].section_count, "1 … 1024", 1025),
    SECTION_ROWS(length_mm),
    SECTION_ROWS(radius_mm),

    PART_POINTER_ROW(blurred, "blur", scene.blur, blur, "8 bytes"),
    PART_COUNT_ROWS(blurred, "blur_count", scene.blur_count, "1 … 8", 9),
    PART_NUMBER_ROWS(blurred, "blur[1].weight", blur[1].weight, "above 0, at most 1"),
    {EACH, "scene.blur", "sum", blurred, PUT(to.blur[1].weight, double, 0.75), INVALID,
     "scene.blur: sum of the weights is 1.25;", "1, to 1e-6"},
    PART_NUMBER_ROWS(blurred, "blur[1].sigma_mm", blur[1].sigma_mm, "0 … 100 mm"),
    PART_POINTER_ROW(blurred_by_a_curve, "mtf_frequencies_per_mm", scene.mtf_frequencies_per_mm, frequencies, "8 bytes"),
    SETTING_ROW("mtf_frequencies_per_mm", "both", blurred_by_both, "not NULL;", "NULL, because blur is given"),
    PART_FINITE_ROWS(blurred_by_a_curve, "mtf_frequencies_per_mm[2]", frequencies[2], "greater than the one before"),
    PART_POINTER_ROW(blurred_by_a_curve, "mtf", scene.mtf, mtf, "8 bytes"),
    PART_NULL_ROW(blurred_by_a_curve, "mtf", scene.mtf),
    PART_NUMBER_ROWS(blurred_by_a_curve, "mtf[1]", mtf[1], "0 … 1"),
    PART_ROW(blurred_by_a_curve, "mtf[0]", mtf[0], double, "not 1", 0.5, "0.5;", "1 at frequency 0"),
    PART_COUNT_ROWS(blurred_by_a_curve, "mtf_count", scene.mtf_count, "2 … 256", 257),

    POSITIVE_ROWS(heel, heel_target_angle_degrees, "above 0, at most 45 degrees"),
    POSITIVE_ROWS(heel, heel_depth_mm, "above 0, at most 1 mm"),
    PART_NUMBER_ROWS(heel, "heel_cathode_degrees", scene.heel_cathode_degrees, "−360 … 360 degrees"),
    {EACH, "scene.first_energy_kev", "not tabulated for tungsten", heel_between, NOTHING, INVALID,
     "scene.first_energy_kev + 0 × energy_step_kev is 15.5 keV;", "whole keV from 15 to 150"},
    NUMBER_ROWS(focal_spot, focal_spot_width_mm, "0 … 10 mm"),
    SETTING_ROW("focal_spot_width_mm", "zero", focal_spot_of_no_size, "0;", "above 0 mm where the height is 0"),
    NUMBER_ROWS(focal_spot, focal_spot_height_mm, "0 … 10 mm"),
    POSITIVE_ROWS(partly_filled, fill_factor, "0.01 … 1"),
    SCENE_ROW_WITH(partly_filled, fill_factor, double, "huge", 1.01, "1.01", "0.01 … 1"),
    POSITIVE_ROWS(noisy, photons_per_pixel, "above 0, at most 1e12 photons: noise needs a dose"),
    POSITIVE_ROWS(noisy, electronic_noise_photons, "1e6 photons"),
    SCENE_ROW_WITH(scattered, scatter_photons, uint64_t, "zero", 0, "0", "1000 … 10000000"),
    SCENE_ROW_WITH(scattered, scatter_photons, uint64_t, "huge", 10000001, "10000001", "1000 … 10000000"),
    SCENE_ROW_WITH(scattered, scatter_photons, uint64_t, "huge", UINT64_MAX, "18446744073709551615", "1000 … 10000000"),
    {EACH, "scene.spectrum", "without tables of scattering", scattered_beyond, NOTHING, INVALID,
     "scene.spectrum's energy is 150.5 keV;", "leave scatter out for other energies"},
};

#endif
