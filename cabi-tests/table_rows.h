/* What the built-in tables refuse. */
#ifndef TABLE_ROWS_H
#define TABLE_ROWS_H

#include "view_rows.h"

static DrrStatus call_spectrum(const Given *g) {
    return drr_physics_spectrum(g->name, g->first_energy_kev, g->energy_step_kev, g->energy_count, (float *)g->weights);
}
static DrrStatus call_mass_attenuation(const Given *g) {
    return drr_physics_mass_attenuation(g->name, g->first_energy_kev, g->energy_step_kev, g->energy_count,
                                        (float *)g->coefficients);
}
static DrrStatus call_detector(const Given *g) {
    return drr_physics_detector(g->name, g->first_energy_kev, g->energy_step_kev, g->energy_count, (float *)g->factors);
}
static void tube(Given *g) { g->name = "W60_2p5Al"; }
static void titanium(Given *g) { g->name = "titanium"; }
static void top_energy(Given *g) { g->name = "top_energy"; }

static const Function spectrum = {"drr_physics_spectrum", tube, call_spectrum, NULL},
                      mass_attenuation = {"drr_physics_mass_attenuation", titanium, call_mass_attenuation, NULL},
                      detector = {"drr_physics_detector", top_energy, call_detector, NULL};

/* 60 kVp makes no photon of 100 keV. */
static void beyond_the_tube(Given *g) {
    g->first_energy_kev = 100.0;
    g->energy_count = 10;
}
static void last_energy_huge(Given *g) {
    g->first_energy_kev = g->energy_step_kev = 1e6;
    g->energy_count = 4096;
}

#define NAME_ROW(f, kind, text, value, valid) \
    {f, "name", kind, NULL, PUT(name, const char *, text), INVALID, "name is " value ";", valid}
#define NUMBER_ROW(f, field, type, kind, number, value, valid) \
    {f, #field, kind, NULL, PUT(field, type, number), INVALID, #field " is " value ";", valid}
#define POSITIVE_NUMBER_ROWS(f, field, valid)                                                                  \
    NUMBER_ROW(f, field, double, "zero", 0.0, "0", valid),                                                     \
    NUMBER_ROW(f, field, double, "negative", -15.0, "-15", valid),                                             \
    NUMBER_ROW(f, field, double, "NaN", NAN, "NaN", valid),                                                    \
    NUMBER_ROW(f, field, double, "+Inf", INFINITY, "inf", valid),                                              \
    NUMBER_ROW(f, field, double, "-Inf", -INFINITY, "-inf", valid),                                            \
    NUMBER_ROW(f, field, double, "huge", 1e300, "1e300", valid)
#define NOT_TABULATED_ROW(f, field, type, number, value)                                                       \
    {f, #field, "not tabulated", NULL, PUT(field, type, number), INVALID,                                      \
     "first_energy_kev + " value " keV;", "whole keV from 15 to 150"}
#define TABLE_FUNCTION_ROWS(f, place, known)                                                                   \
    NAME_ROW(f, "NULL", NULL, "NULL", "a pointer"), NAME_ROW(f, "unknown", "W999", "\"W999\"", known),         \
    NAME_ROW(f, "unknown", "", "\"\"", known), NAME_ROW(f, "not UTF-8", "\xff", "\xef\xbf\xbd", "UTF-8"),      \
    POSITIVE_NUMBER_ROWS(f, first_energy_kev, "above 0, at most 1e6 keV"),                                     \
    NOT_TABULATED_ROW(f, first_energy_kev, double, 14.5, "0 × energy_step_kev is 14.5"),                       \
    POSITIVE_NUMBER_ROWS(f, energy_step_kev, "1e-6 … 1e6 keV"),                                                \
    NOT_TABULATED_ROW(f, energy_step_kev, double, 0.5, "1 × energy_step_kev is 15.5"),                         \
    COUNT_ROWS(f, "energy_count", energy_count, "4096", 4097),                                                 \
    {f, "energy_step_kev", "product", last_energy_huge, NOTHING, INVALID,                                      \
     "first_energy_kev + 4095 × energy_step_kev is 4096000000 keV;", "at most 1e6 keV"},                       \
    {f, #place, "NULL", NULL, POINT(place, NULL), INVALID, #place " is NULL;", "a pointer to 136 values"},     \
    {f, #place, "misaligned", NULL, ASKEW(place, values), INVALID, #place " is 0x", "aligned to 4 bytes"}

static const Row table_rows[] = {
    TABLE_FUNCTION_ROWS(&spectrum, weights, "W120_2p5Al"),
    {&spectrum, "weights", "zero", beyond_the_tube, NOTHING, INVALID, "weights' sum is 0;", "finite, above 0"},
    TABLE_FUNCTION_ROWS(&mass_attenuation, coefficients, "air, lung"),
    TABLE_FUNCTION_ROWS(&detector, factors, "ideal, transmission"),
};

#endif
