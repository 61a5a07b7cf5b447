/* What scenes refuse. */
#ifndef SCENE_ROWS_H
#define SCENE_ROWS_H

#include <float.h>

#include "volume_rows.h"

static DrrStatus call_projector_create(const Given *g) {
    return drr_projector_create((const DrrVolume *)g->volume, (const DrrScene *)g->scene,
                                (DrrProjector **)g->projector);
}
static void projector_place(Given *g) { g->projector = &g->to.handle; }
static void destroy_made_projector(const Given *g) { drr_projector_destroy((DrrProjector *)g->to.handle); }

static const Function projector_create = {"drr_projector_create", projector_place, call_projector_create,
                                          destroy_made_projector};

static void own_spectrum(Given *g) { g->to.scene.spectrum = g->to.spectrum; }
static void own_response(Given *g) { g->to.scene.detector_response = g->to.response; }
static void own_materials(Given *g) { g->to.scene.mass_attenuation = g->to.attenuation; }
static void own_tables(Given *g) {
    own_spectrum(g);
    own_materials(g);
}
static void boneless_materials(Given *g) {
    own_materials(g);
    g->to.scene.effects = DRR_EFFECT_POLYENERGETIC;
}
static void monoenergetic(Given *g) { g->to.scene.effects = 0; }
static void monoenergetic_with_materials(Given *g) {
    monoenergetic(g);
    own_materials(g);
}
static void march(Given *g) { g->to.scene.algorithm = DRR_ALGORITHM_MARCH; }
static void dark(Given *g) {
    own_spectrum(g);
    memset(g->to.spectrum, 0, sizeof g->to.spectrum);
}
static void blind(Given *g) {
    own_response(g);
    memset(g->to.response, 0, sizeof g->to.response);
}
static void blinding(Given *g) {
    own_spectrum(g);
    for (int k = 0; k < ENERGIES; k++) g->to.spectrum[k] = FLT_MAX;
}
static void beyond_all_energies(Given *g) {
    own_tables(g);
    g->to.scene.first_energy_kev = g->to.scene.energy_step_kev = 1e6;
}
/* The bin is there, the built-in tables are not. */
static void monoenergetic_between(Given *g) {
    monoenergetic(g);
    g->to.scene.first_energy_kev = 15.5;
    g->to.scene.mono_energy_kev = 70.5;
}
/* Classified as air, lung, adipose, ...; the default table is air, lung, soft tissue, bone. */
static void another_classification(Given *g) { g->volume = live.adipose; }

/* Of these few voxels the finest march is still some HU off. */
static void tolerant(Given *g) { g->to.scene.tolerance_hu = 1000.0; }
static void expecting(Given *g) {
    g->to.scene.expected_poses = g->to.poses;
    g->to.scene.expected_pose_count = VIEWS;
}
static DrrStatus call_set_preset(const Given *g) { return drr_scene_set_preset((DrrScene *)g->scene, g->name); }
static void standard(Given *g) { g->name = "standard"; }

static const Function set_preset = {"drr_scene_set_preset", standard, call_set_preset, NULL};

/* Every function that reads a scene. */
#define EACH ((const Function *)0)
#define SCENE_ROW(field, type, kind, number, value, valid) \
    SCENE_ROW_WITH(NULL, field, type, kind, number, value, valid)
#define SCENE_ROW_WITH(setting, field, type, kind, number, value, valid)                             \
    {EACH, "scene." #field, kind, setting, PUT(to.scene.field, type, number), INVALID,  \
     "scene." #field " is " value ";", valid}
#define SIDE_ROWS(field)                                                                             \
    SCENE_ROW(field, size_t, "zero", 0, "0", "1 … 32768 pixels"),                                    \
    SCENE_ROW(field, size_t, "huge", 32769, "32769", "1 … 32768 pixels"),                            \
    SCENE_ROW(field, size_t, "huge", SIZE_MAX, "18446744073709551615", "1 … 32768 pixels")
/* A number that must be positive. */
#define POSITIVE_ROWS(setting, field, valid)                                                         \
    SCENE_ROW_WITH(setting, field, double, "zero", 0.0, "0", valid),                                 \
    SCENE_ROW_WITH(setting, field, double, "negative", -70.0, "-70", valid),                         \
    SCENE_ROW_WITH(setting, field, double, "NaN", NAN, "NaN", valid),                                \
    SCENE_ROW_WITH(setting, field, double, "+Inf", INFINITY, "inf", valid),                          \
    SCENE_ROW_WITH(setting, field, double, "-Inf", -INFINITY, "-inf", valid),                        \
    SCENE_ROW_WITH(setting, field, double, "huge", 1e300, "1e300", valid)
/* A number that may be 0. */
#define NUMBER_ROWS(setting, field, valid)                                                           \
    SCENE_ROW_WITH(setting, field, double, "negative", -70.0, "-70", valid),                         \
    SCENE_ROW_WITH(setting, field, double, "NaN", NAN, "NaN", valid),                                \
    SCENE_ROW_WITH(setting, field, double, "+Inf", INFINITY, "inf", valid),                          \
    SCENE_ROW_WITH(setting, field, double, "-Inf", -INFINITY, "-inf", valid),                        \
    SCENE_ROW_WITH(setting, field, double, "huge", 1e300, "1e300", valid)
#define WEIGHT_RANGE "finite, at least 0"
#define ATTENUATION_RANGE "0 … 1e9 cm²/g"
#define VALUE_ROW(setting, field, place, index, kind, number, value, valid)                          \
    {EACH, "scene." #field, kind, setting, PUT(to.place, float, number), INVALID,       \
     "scene." #field index " is " value ";", valid}
/* A value of a table, somewhere in it and last. */
#define TABLE_ROWS(setting, field, table, at, index, last, last_index, valid)                        \
    {EACH, "scene." #field, "misaligned", setting, ASKEW(to.scene.field, table),        \
     INVALID, "scene." #field " is 0x", "aligned to 4 bytes"},                                       \
    VALUE_ROW(setting, field, table[at], index, "negative", -1.0f, "-1", valid),                     \
    VALUE_ROW(setting, field, table[last], last_index, "NaN", NAN, "NaN", valid),                    \
    VALUE_ROW(setting, field, table[at], index, "+Inf", INFINITY, "inf", valid),                     \
    VALUE_ROW(setting, field, table[last], last_index, "-Inf", -INFINITY, "-inf", valid)

static const Row scene_field_rows[] = {
    STRUCT_SIZE_ROWS(EACH, "scene", scene, "336"),
    SIDE_ROWS(detector_width),
    SIDE_ROWS(detector_height),
    TABLE_ROWS(own_spectrum, spectrum, spectrum, 7, "[7]", ENERGIES - 1, "[135]", WEIGHT_RANGE),
    {EACH, "scene.spectrum", "zero", dark, NOTHING, INVALID, "scene.spectrum's sum is 0;",
     "finite, above 0"},
    {EACH, "scene.spectrum", "huge", blinding, NOTHING, INVALID, "scene.spectrum's sum is 4.6",
     "1.1754944e-38 … 3.4028235e38, which float32 images can hold"},
    TABLE_ROWS(own_response, detector_response, response, 7, "[7]", ENERGIES - 1, "[135]", WEIGHT_RANGE),
    {EACH, "scene.detector_response", "zero", blind, NOTHING, INVALID,
     "scene.detector_response × spectrum's sum is 0;", "finite, above 0"},
    TABLE_ROWS(own_materials, mass_attenuation, attenuation, 7, "[0][7]", MATERIALS * ENERGIES - 1, "[3][135]",
               ATTENUATION_RANGE),
    VALUE_ROW(own_materials, mass_attenuation, attenuation[7], "[0][7]", "huge", 1.5e9f, "1500000000",
              ATTENUATION_RANGE),
    VALUE_ROW(monoenergetic_with_materials, mass_attenuation, attenuation[ENERGIES + 55], "[1][55]", "NaN", NAN, "NaN",
              ATTENUATION_RANGE),
    VALUE_ROW(monoenergetic_with_materials, mass_attenuation, attenuation[3], "[0][3]", "negative", -1e-30f,
              "-1.0000000031710769e-30", ATTENUATION_RANGE),
    SCENE_ROW(material_count, size_t, "zero", 0, "0", "4 when mass_attenuation is NULL"),
    SCENE_ROW(material_count, size_t, "too few", 3, "3", "4 when mass_attenuation is NULL"),
    SCENE_ROW(material_count, size_t, "huge", SIZE_MAX, "18446744073709551615", "4 when mass_attenuation is NULL"),
    SCENE_ROW_WITH(own_materials, material_count, size_t, "zero", 0, "0", "1 … 8"),
    SCENE_ROW_WITH(own_materials, material_count, size_t, "huge", 9, "9", "1 … 8"),
    SCENE_ROW_WITH(own_materials, material_count, size_t, "huge", SIZE_MAX / ENERGIES + 1, "135637824071393762",
                   "1 … 8"),
    SCENE_ROW(energy_count, size_t, "zero", 0, "0", "1 … 4096"),
    SCENE_ROW(energy_count, size_t, "huge", 4097, "4097", "1 … 4096"),
    SCENE_ROW(energy_count, size_t, "huge", SIZE_MAX, "18446744073709551615", "1 … 4096"),
    {EACH, "scene.first_energy_kev", "not tabulated", NULL, PUT(to.scene.energy_count, size_t, 137),
     INVALID, "scene.first_energy_kev + 136 × energy_step_kev is 151 keV;", "whole keV from 15 to 150"},
    POSITIVE_ROWS(NULL, first_energy_kev, "above 0, at most 1e6 keV"),
    {EACH, "scene.first_energy_kev", "not tabulated", NULL, PUT(to.scene.first_energy_kev, double, 14.5),
     INVALID, "scene.first_energy_kev + 0 × energy_step_kev is 14.5 keV;", "whole keV from 15 to 150"},
    POSITIVE_ROWS(NULL, energy_step_kev, "1e-6 … 1e6 keV"),
    SCENE_ROW(energy_step_kev, double, "tiny", 1e-7, "0.0000001", "1e-6 … 1e6 keV"),
    {EACH, "scene.energy_step_kev", "not tabulated", NULL, PUT(to.scene.energy_step_kev, double, 0.5),
     INVALID, "scene.first_energy_kev + 1 × energy_step_kev is 15.5 keV;", "whole keV from 15 to 150"},
    {EACH, "scene.energy_step_kev", "product", beyond_all_energies, NOTHING, INVALID,
     "scene.first_energy_kev + 135 × energy_step_kev is 136000000 keV;", "at most 1e6 keV"},
    POSITIVE_ROWS(monoenergetic, mono_energy_kev, "one of 136 energies from 15 keV, step 1 keV"),
    SCENE_ROW_WITH(monoenergetic, mono_energy_kev, double, "not an energy", 70.5, "70.5", "one of 136 energies"),
    {EACH, "scene.mono_energy_kev", "not tabulated", monoenergetic_between, NOTHING, INVALID,
     "scene.mono_energy_kev is 70.5 keV;", "whole keV from 15 to 150"},
    POSITIVE_ROWS(march, step_voxels, "0.015625 … 8 voxels"),
    SCENE_ROW_WITH(march, step_voxels, double, "tiny", 0.0156, "0.0156", "0.015625 … 8 voxels"),
    SCENE_ROW_WITH(march, step_voxels, double, "huge", 8.0001, "8.0001", "0.015625 … 8 voxels"),
    SCENE_ROW(effects, DrrEffects, "unknown", 1u << 9, "0x200", "DRR_EFFECT bits, 0x1ff, only"),
    SCENE_ROW(effects, DrrEffects, "unknown", 0x80000001u, "0x80000001", "DRR_EFFECT bits, 0x1ff, only"),
    SCENE_ROW(effects, DrrEffects, "unknown", UINT32_MAX, "0xffffffff", "DRR_EFFECT bits, 0x1ff, only"),
    SCENE_ROW(algorithm, DrrAlgorithm, "unknown", 5, "5", "DRR_ALGORITHM constants, 0 … 4"),
    SCENE_ROW(algorithm, DrrAlgorithm, "unknown", UINT32_MAX, "4294967295", "DRR_ALGORITHM constants, 0 … 4"),
    SCENE_ROW(supersampling, uint32_t, "zero", 0, "0", "1 … 16"),
    SCENE_ROW(supersampling, uint32_t, "huge", 17, "17", "1 … 16"),
    SCENE_ROW(supersampling, uint32_t, "huge", UINT32_MAX, "4294967295", "1 … 16"),
    SCENE_ROW(bone_material, uint32_t, "huge", 4, "4", "0 … 3"),
    SCENE_ROW(bone_material, uint32_t, "huge", 259, "259", "0 … 3"),
    SCENE_ROW(bone_material, uint32_t, "huge", UINT32_MAX, "4294967295", "0 … 3"),
    NUMBER_ROWS(NULL, tolerance_hu, "above 0, at most 1000 HU"),
    NUMBER_ROWS(tolerant, tolerance_mm, "0 (does not matter) … 1e6 mm"),
    NUMBER_ROWS(NULL, few_energies_hu, "1e-6 … 100 HU"),
    {EACH, "scene.expected_poses", "misaligned", expecting, ASKEW(to.scene.expected_poses, poses), INVALID,
     "scene.expected_poses is 0x", "aligned to 8 bytes"},
    {EACH, "scene.expected_poses[1].source", "NaN", expecting, PUT(to.poses[1].source[0], double, NAN),
     INVALID, "scene.expected_poses[1].source is [NaN, ", "1e10 mm"},
    SCENE_ROW_WITH(expecting, expected_pose_count, size_t, "zero", 0, "0", "1 … 65536"),
    SCENE_ROW_WITH(expecting, expected_pose_count, size_t, "huge", 65537, "65537", "1 … 65536"),
    SCENE_ROW_WITH(expecting, expected_pose_count, size_t, "huge", SIZE_MAX, "18446744073709551615", "1 … 65536"),
};

static const Row scene_rows[] = {
    {&projector_create, "volume", "NULL", NULL, POINT(volume, NULL), INVALID, "volume is NULL;", "a DrrVolume"},
    {&projector_create, "volume", "misaligned", volume_askew, NOTHING, INVALID, "volume is 0x", "a DrrVolume"},
    {&projector_create, "volume", "foreign", volume_foreign, NOTHING, INVALID, "volume is no such handle;",
     "a DrrVolume that has not been destroyed"},
    {&projector_create, "volume", "destroyed", volume_destroyed, NOTHING, INVALID, "volume is ", "a DrrVolume"},
    POINTER_ROWS(&projector_create, scene, scene, "8 bytes"),
    {&projector_create, "scene.mass_attenuation", "other materials", another_classification, NOTHING, INVALID,
     "scene.mass_attenuation[2] is soft_tissue;", "adipose, as the volume's thresholds classified"},
    /* Bone is not asked for: only the volume's labels mind. */
    {&projector_create, "scene.material_count", "label", boneless_materials, PUT(to.scene.material_count, size_t, 3),
     INVALID, "scene.material_count is 3;", "at least 4: the volume has voxels with label 3"},
    {&projector_create, "scene.algorithm", "unsupported", NULL,
     PUT(to.scene.algorithm, DrrAlgorithm, DRR_ALGORITHM_EXACT), DRR_STATUS_UNSUPPORTED, "algorithm exact",
     "reference engine only"},
    {&projector_create, "scene.tolerance", "out of reach", expecting, PUT(to.scene.tolerance_hu, double, 1e-9), INVALID,
     "scene.tolerance is 1e-9 HU;", "which the finest of the engine's methods reaches in this scene"},
    POINTER_ROWS(&projector_create, projector, handle, "8 bytes"),
    POINTER_ROWS(&set_preset, scene, scene, "8 bytes"),
    STRUCT_SIZE_ROWS(&set_preset, "scene", scene, "336"),
    {&set_preset, "name", "NULL", NULL, PUT(name, const char *, NULL), INVALID, "name is NULL;", "a pointer"},
    {&set_preset, "name", "unknown", NULL, PUT(name, const char *, "best"), INVALID, "name is best;", "draft, standard, reference"},
    {&set_preset, "name", "not UTF-8", NULL, PUT(name, const char *, "\xff"), INVALID, "name is ", "UTF-8"},
};

#endif
