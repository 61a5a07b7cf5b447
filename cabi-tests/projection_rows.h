/* What projections refuse. */
#ifndef PROJECTION_ROWS_H
#define PROJECTION_ROWS_H

#include "view_rows.h"

static void projector_askew(Given *g) { g->projector = (char *)live.projector + 1; }
static void projector_foreign(Given *g) { g->projector = live.volume; }
static void projector_destroyed(Given *g) {
    DrrProjector *projector = NULL;
    drr_projector_create(live.volume, &g->to.scene, &projector);
    drr_projector_destroy(projector);
    g->projector = projector;
}
static void no_images(Given *g) {
    drr_outputs_init(&g->to.outputs);
    drr_reference_outputs_init(&g->to.reference_outputs);
    drr_device_outputs_init(&g->to.device_outputs);
}
static void no_bone_path(Given *g) {
    g->to.outputs.bone_path_mm = NULL;
    g->to.reference_outputs.bone_path_mm = NULL;
    g->to.device_outputs.bone_path_mm = NULL;
}
static void boneless(Given *g) {
    g->projector = live.boneless;
    g->exposure = live.boneless_exposure;
    no_bone_path(g);
}
static void march_without_step(Given *g) { g->projector = live.unstepped; }

/* 2^46 pixels. The images are never touched: there is no memory to compute them in. */
static DrrDetectorPose most_poses[DRR_MAX_VIEWS];
static ProjectionUniforms most_views[DRR_MAX_VIEWS];
static void more_than_memory(Given *g) {
    boneless(g);
    g->projector = live.vast;
    for (size_t v = 0; v < DRR_MAX_VIEWS; v++) {
        most_poses[v] = g->to.poses[0];
        most_views[v] = g->to.views[0];
    }
    g->poses = most_poses;
    g->views = most_views;
    g->view_count = DRR_MAX_VIEWS;
}

/* Uniforms. The second view is wrong. */
typedef float Matrix[4][4]; /* columns of rows */
static void read_matrix(const Given *g, Matrix matrix) {
    memcpy(matrix, &g->to.views[1].modelViewProjectionMatrix, sizeof(Matrix));
}
static void write_matrix(Given *g, Matrix matrix) {
    memcpy(&g->to.views[1].modelViewProjectionMatrix, matrix, sizeof(Matrix));
}
static void matrix_of_zeros(Given *g) {
    memset(&g->to.views[1].modelViewProjectionMatrix, 0, sizeof(Matrix));
}
static void equal_rows(Given *g) {
    Matrix matrix;
    read_matrix(g, matrix);
    for (int column = 0; column < 4; column++) matrix[column][1] = matrix[column][0];
    write_matrix(g, matrix);
}
/* Rows that differ in direction by the last bit of float32, and are large: the determinant is about 1e11. */
static void nearly_equal_rows_and_large(Given *g) {
    Matrix matrix;
    read_matrix(g, matrix);
    for (int column = 0; column < 4; column++) {
        matrix[column][0] *= 1e6f;
        matrix[column][1] = matrix[column][0];
        matrix[column][3] *= 1e6f;
    }
    matrix[2][1] += 0.125f;
    write_matrix(g, matrix);
}
/* Rays along +y. */
static void parallel(Given *g) {
    Matrix matrix = {{1, 0, 0, 0}, {0, 0, 0.01f, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}};
    write_matrix(g, matrix);
}
static void spectrum_lut(Given *g) {
    g->to.views[1].spectrumLutAddress = (DrrAddress)(uintptr_t)g->to.spectrum;
}
static void mu_lut(Given *g) { g->to.views[1].muLutAddress = (DrrAddress)(uintptr_t)g->to.attenuation; }
static void spectrum_lut_askew(Given *g) {
    spectrum_lut(g);
    g->to.views[1].spectrumLutAddress += 2;
}
static void mu_lut_askew(Given *g) {
    mu_lut(g);
    g->to.views[1].muLutAddress += 1;
}
static void spectrum_lut_of_zeros(Given *g) {
    spectrum_lut(g);
    memset(g->to.spectrum, 0, sizeof g->to.spectrum);
}
static void spectrum_lut_too_bright(Given *g) {
    spectrum_lut(g);
    for (int k = 0; k < ENERGIES; k++) g->to.spectrum[k] = FLT_MAX;
}
static void spectrum_lut_at_one_energy(Given *g) {
    g->projector = live.monoenergetic;
    no_bone_path(g);
    spectrum_lut(g);
}
static void mu_lut_at_one_energy(Given *g) {
    g->projector = live.monoenergetic;
    no_bone_path(g);
    mu_lut(g);
}

#define HANDLE_ROWS(f)                                                                                               \
    {f, "projector", "NULL", NULL, POINT(projector, NULL), INVALID, "projector is NULL;", "a DrrProjector"},         \
    {f, "projector", "misaligned", projector_askew, NOTHING, INVALID, "projector is 0x", "a DrrProjector"},          \
    {f, "projector", "foreign", projector_foreign, NOTHING, INVALID, "projector is no such handle;",                 \
     "a DrrProjector that has not been destroyed"},                                                                  \
    {f, "projector", "destroyed", projector_destroyed, NOTHING, INVALID, "projector is ", "a DrrProjector"}
#define IMAGE_ROW(f, member, name, alignment)                                                                        \
    {f, "outputs." #name, "misaligned", NULL, ASKEW(to.member.name, images), INVALID, "outputs." #name " is 0x",     \
     "aligned to " alignment}
#define OUTPUTS_ROWS(f, member, size, alignment)                                                                     \
    POINTER_ROWS(f, outputs, member, "8 bytes"), STRUCT_SIZE_ROWS(f, "outputs", member, size),                       \
    {f, "outputs", "NULL images", no_images, NOTHING, INVALID, "outputs is NULL for every image;",                   \
     "at least one image"},                                                                                          \
    IMAGE_ROW(f, member, intensity, alignment), IMAGE_ROW(f, member, line_integral, alignment),                      \
    IMAGE_ROW(f, member, areal_density, alignment), IMAGE_ROW(f, member, bone_path_mm, alignment),                   \
    {f, "outputs.bone_path_mm", "unplanned", boneless, PUT(to.member.bone_path_mm, void *, given.to.images),         \
     INVALID, "outputs.bone_path_mm is not NULL;", "NULL, because the scene is without DRR_EFFECT_BONE_PATH"}
#define PROJECTION_ROWS(f, member, alignment)                                                                        \
    HANDLE_ROWS(f), COUNT_ROWS(f, "view_count", view_count, "65536", 65537),                                         \
    {f, "view_count", "more than memory", more_than_memory, NOTHING, DRR_STATUS_OUT_OF_MEMORY, " bytes for ",        \
     "the images"},                                                                                                  \
    OUTPUTS_ROWS(f, member, "56", alignment)
#define ENCODING_ROWS(f)                                                                                             \
    HANDLE_ROWS(f), COUNT_ROWS(f, "view_count", view_count, "65536", 65537),                                         \
    OUTPUTS_ROWS(f, device_outputs, "48", "4 bytes"), IMAGE_ROW(f, device_outputs, intensity_texture, "4 bytes")

#define ENTRY(entry, number)                                                                                         \
    {offsetof(Given, to.views[1].modelViewProjectionMatrix) + sizeof(float) * (entry), sizeof(float), sizeof(float), \
     &(float){number}}
#define ENTRY_ROW(f, name, setting, entry, place, kind, number, value, valid)                                        \
    {f, name ".modelViewProjectionMatrix", kind, setting, ENTRY(entry, number), INVALID,                          \
     name ".modelViewProjectionMatrix " place " is " value ";", valid}
#define SINGULAR_VIEW_ROW(f, name, kind, setting, change, rows)                                                      \
    {f, name ".modelViewProjectionMatrix", kind, setting, change, INVALID,                                        \
     name ".modelViewProjectionMatrix is singular (ratio ", "independent " rows " rows: |det|"}
#define SOURCE_ROW(f, name, axis, kind, number, value, valid)                                                        \
    {f, name ".sourcePosition", kind, NULL, PUT(to.views[1].sourcePosition.axis, float, number), INVALID,         \
     name ".sourcePosition is [" value, valid}
#define LUT_ROW(f, field, setting, table, index, kind, number, value, valid)                                         \
    {f, "views[1]." field, kind, setting, PUT(to.table, float, number), INVALID,                                     \
     "views[1]." field index " is " value ";", valid}
#define LUT_SETTING_ROW(f, field, kind, setting, value, valid)                                                       \
    {f, "views[1]." field, kind, setting, NOTHING, INVALID, "views[1]." field value, valid}
#define WHERE_RANGE "−1e10 … 1e10 mm"
#define UNIFORMS_ROWS(f, name)                                                                                       \
    ENTRY_ROW(f, name, NULL, 0, "column 0, row 0", "NaN", NAN, "NaN", "finite numbers"),                             \
    ENTRY_ROW(f, name, NULL, 6, "column 1, row 2", "+Inf", INFINITY, "inf", "finite numbers"),                       \
    ENTRY_ROW(f, name, NULL, 15, "column 3, row 3", "-Inf", -INFINITY, "-inf", "finite numbers"),                    \
    ENTRY_ROW(f, name, parallel, 15, "column 3, row 3", "zero", 0.0f, "0", "not 0"),                                 \
    SINGULAR_VIEW_ROW(f, name, "zero", matrix_of_zeros, NOTHING, "x and y"),                                         \
    SINGULAR_VIEW_ROW(f, name, "singular", equal_rows, NOTHING, "x, y and w"),                                       \
    SINGULAR_VIEW_ROW(f, name, "nearly singular", nearly_equal_rows_and_large, NOTHING, "x, y and w"),               \
    SINGULAR_VIEW_ROW(f, name, "singular", parallel, ENTRY(0, 0.0f), "x and y"),                                     \
    SINGULAR_VIEW_ROW(f, name, "nearly singular", parallel, ENTRY(1, 1e7f), "x and y"),                              \
    SOURCE_ROW(f, name, x, "NaN", NAN, "NaN", WHERE_RANGE),                                                          \
    SOURCE_ROW(f, name, y, "+Inf", INFINITY, "", ", inf, "),                                                         \
    SOURCE_ROW(f, name, z, "-Inf", -INFINITY, "", ", -inf]; valid: " WHERE_RANGE),                                   \
    SOURCE_ROW(f, name, x, "huge", 2e10f, "2e10, ", WHERE_RANGE),                                                    \
    SOURCE_ROW(f, name, x, "inconsistent", 100.0f, "100, ", "the point that modelViewProjectionMatrix sends to (0, 0, *, 0)")
#define MATRIX_ROWS(f) POINTER_ROWS(f, views, views, "16 bytes"), UNIFORMS_ROWS(f, "views[1]")
#define LUT_ROWS(f)                                                                                                  \
    LUT_SETTING_ROW(f, "spectrumLutAddress", "misaligned", spectrum_lut_askew, " is 0x", "aligned to 4 bytes"),      \
    LUT_ROW(f, "spectrumLutAddress", spectrum_lut, spectrum[7], "[7]", "negative", -1.0f, "-1", WEIGHT_RANGE),       \
    LUT_ROW(f, "spectrumLutAddress", spectrum_lut, spectrum[135], "[135]", "NaN", NAN, "NaN", WEIGHT_RANGE),         \
    LUT_ROW(f, "spectrumLutAddress", spectrum_lut, spectrum[0], "[0]", "+Inf", INFINITY, "inf", WEIGHT_RANGE),       \
    LUT_ROW(f, "spectrumLutAddress", spectrum_lut, spectrum[135], "[135]", "-Inf", -INFINITY, "-inf", WEIGHT_RANGE), \
    LUT_SETTING_ROW(f, "spectrumLutAddress", "zero", spectrum_lut_of_zeros, "'s sum is 0;", "finite, above 0"),      \
    LUT_SETTING_ROW(f, "spectrumLutAddress", "huge", spectrum_lut_too_bright, "'s sum is 4.6", "1.1754944e-38 … 3.4028235e38"),\
    LUT_SETTING_ROW(f, "spectrumLutAddress", "one energy", spectrum_lut_at_one_energy, " is 0x",                     \
                    "0, because the scene is without DRR_EFFECT_POLYENERGETIC"),                                     \
    LUT_SETTING_ROW(f, "muLutAddress", "misaligned", mu_lut_askew, " is 0x", "aligned to 4 bytes"),                  \
    LUT_ROW(f, "muLutAddress", mu_lut, attenuation[7], "[0][7]", "negative", -1.0f, "-1", ATTENUATION_RANGE),        \
    LUT_ROW(f, "muLutAddress", mu_lut, attenuation[4 * ENERGIES - 1], "[3][135]", "NaN", NAN, "NaN", ATTENUATION_RANGE),\
    LUT_ROW(f, "muLutAddress", mu_lut, attenuation[ENERGIES], "[1][0]", "+Inf", INFINITY, "inf", ATTENUATION_RANGE), \
    LUT_ROW(f, "muLutAddress", mu_lut, attenuation[0], "[0][0]", "-Inf", -INFINITY, "-inf", ATTENUATION_RANGE),      \
    LUT_ROW(f, "muLutAddress", mu_lut, attenuation[7], "[0][7]", "huge", 1.5e9f, "1500000000", ATTENUATION_RANGE),   \
    LUT_SETTING_ROW(f, "muLutAddress", "one energy", mu_lut_at_one_energy, " is 0x",                                 \
                    "0, because the scene is without DRR_EFFECT_POLYENERGETIC")

static const Row projection_rows[] = {
    PROJECTION_ROWS(&project, outputs, "4 bytes"),
    MATRIX_ROWS(&project),
    LUT_ROWS(&project),

    PROJECTION_ROWS(&project_poses, outputs, "4 bytes"),
    POINTER_ROWS(&project_poses, poses, poses, "8 bytes"),
    POSE_ROWS(&project_poses, "poses[1]"),

    HANDLE_ROWS(&certify),
    COUNT_ROWS(&certify, "view_count", view_count, "65536", 65537),
    POINTER_ROWS(&certify, poses, poses, "8 bytes"),
    POSE_ROWS(&certify, "poses[1]"),
    POINTER_ROWS(&certify, certificate, certificate, "8 bytes"),
    STRUCT_SIZE_ROWS(&certify, "certificate", certificate, "96"),

    ENCODING_ROWS(&encode),
    /* Tables that this engine has no queue for are not looked at. */
    MATRIX_ROWS(&encode),

    ENCODING_ROWS(&encode_poses),
    POINTER_ROWS(&encode_poses, poses, poses, "8 bytes"),
    POSE_ROWS(&encode_poses, "poses[1]"),

    PROJECTION_ROWS(&reference_project, reference_outputs, "8 bytes"),
    POINTER_ROWS(&reference_project, poses, poses, "8 bytes"),
    POSE_ROWS(&reference_project, "poses[1]"),
    {&reference_project, "algorithm", "unknown", NULL, PUT(algorithm, DrrAlgorithm, 5), INVALID, "algorithm is 5;",
     "DRR_ALGORITHM constants, 0 … 4"},
    {&reference_project, "algorithm", "unknown", NULL, PUT(algorithm, DrrAlgorithm, UINT32_MAX), INVALID,
     "algorithm is 4294967295;", "DRR_ALGORITHM constants, 0 … 4"},
    {&reference_project, "scene.step_voxels", "zero", march_without_step, PUT(algorithm, DrrAlgorithm, 1), INVALID,
     "scene.step_voxels is 0;", "0.015625 … 8 voxels"},

    HANDLE_ROWS(&describe),
    {&projector_destroy, "projector", "misaligned", projector_askew, NOTHING, INVALID, "projector is 0x",
     "a DrrProjector"},
    {&projector_destroy, "projector", "foreign", projector_foreign, NOTHING, INVALID, "projector is no such handle;",
     "a DrrProjector that has not been destroyed"},
    {&projector_destroy, "projector", "destroyed", projector_destroyed, NOTHING, INVALID, "projector is ",
     "a DrrProjector that has not been destroyed"},
};

#endif
