/* What volumes refuse. */
#ifndef VOLUME_ROWS_H
#define VOLUME_ROWS_H

#include "context_rows.h"
#include "nifti.h"

static DrrStatus call_volume_create(const Given *g) {
    return drr_volume_create((const DrrContext *)g->context, (const DrrVolumeDescriptor *)g->descriptor,
                             (const int16_t *)g->hu, (const uint8_t *)g->labels, (DrrVolume **)g->volume);
}
static DrrStatus call_volume_create_float32(const Given *g) {
    return drr_volume_create_float32((const DrrContext *)g->context, (const DrrVolumeDescriptor *)g->descriptor,
                                     (const float *)g->hu, (const uint8_t *)g->labels, (DrrVolume **)g->volume);
}
static void volume_place(Given *g) { g->volume = &g->to.handle; }
static void volume_place_and_float32(Given *g) {
    volume_place(g);
    g->hu = g->to.hu_float32;
}
/* The context has no GPU, so the good call is refused as well, last of all: the texture is not looked at. */
static DrrStatus call_volume_create_texture(const Given *g) {
    const DrrStatus status = drr_volume_create_metal_texture((const DrrContext *)g->context,
                                                             (const DrrVolumeDescriptor *)g->descriptor,
                                                             (void *)g->texture, (DrrVolume **)g->volume);
    return status == DRR_STATUS_UNSUPPORTED ? DRR_STATUS_OK : status;
}
static void volume_place_and_texture(Given *g) {
    volume_place(g);
    g->texture = &g->to.handle;
}
static void destroy_made_volume(const Given *g) { drr_volume_destroy((DrrVolume *)g->to.handle); }
/* Builds without readers of files refuse a good file, last of all. */
static DrrStatus call_volume_load(const Given *g) {
    const DrrStatus status = drr_volume_load((const DrrContext *)g->context, g->path,
                                             (DrrVolumeDescriptor *)g->descriptor, (DrrVolume **)g->volume);
    return status == DRR_STATUS_UNSUPPORTED ? DRR_STATUS_OK : status;
}
static void volume_place_and_path(Given *g) {
    volume_place(g);
    g->path = nifti_path();
    write_nifti(g->path, &g->to.descriptor, g->to.hu, sizeof g->to.hu);
}
static void destroy_loaded_volume(const Given *g) {
    destroy_made_volume(g);
    remove(g->path);
}
static DrrStatus call_volume_destroy(const Given *g) { return drr_volume_destroy((DrrVolume *)g->volume); }
static void no_volume(Given *g) { g->volume = NULL; }

static const Function volume_create = {"drr_volume_create", volume_place, call_volume_create, destroy_made_volume},
                      volume_create_float32 = {"drr_volume_create_float32", volume_place_and_float32,
                                               call_volume_create_float32, destroy_made_volume},
                      volume_create_texture = {"drr_volume_create_metal_texture", volume_place_and_texture,
                                               call_volume_create_texture, NULL},
                      volume_load = {"drr_volume_load", volume_place_and_path, call_volume_load, destroy_loaded_volume},
                      volume_destroy = {"drr_volume_destroy", no_volume, call_volume_destroy, NULL};

/* 2^45 voxels: each side is valid. */
static void all_sides_largest(Given *g) {
    for (int axis = 0; axis < 3; axis++) g->to.descriptor.dimensions[axis] = 32768;
}
/* Products that wrap to 0 in 64 bits. */
static void sides_overflow(Given *g) {
    for (int axis = 0; axis < 3; axis++) g->to.descriptor.dimensions[axis] = (size_t)1 << 32;
}
/* Determinant 1e11, columns that differ in direction by 1e-7. */
static void nearly_singular_and_large(Given *g) {
    static const double matrix[16] = {1e6, 0, 0, 0, 1e6, 0.1, 0, 0, 0, 0, 1e6, 0, 0, 0, 0, 1};
    memcpy(g->to.descriptor.index_to_world, matrix, sizeof matrix);
}
static void singular(Given *g) {
    static const double matrix[16] = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 0, 0, 0, 1};
    memcpy(g->to.descriptor.index_to_world, matrix, sizeof matrix);
}
static void two_wrong_labels(Given *g) { g->to.labels[1] = g->to.labels[VOXELS - 1] = 8; }
static void three_wrong_voxels(Given *g) {
    g->to.hu_float32[NX + 1] = NAN;
    g->to.hu_float32[NX + 2] = INFINITY;
    g->to.hu_float32[VOXELS - 1] = -INFINITY;
}
static void volume_askew(Given *g) { g->volume = (char *)live.volume + 1; }
static void volume_foreign(Given *g) { g->volume = live.projector; }
static void volume_destroyed(Given *g) {
    DrrVolume *volume = NULL;
    drr_volume_create(live.context, &g->to.descriptor, g->to.hu, NULL, &volume);
    drr_volume_destroy(volume);
    g->volume = volume;
}

#define DIMENSION_ROWS(f, axis)                                                                                     \
    {f, "descriptor.dimensions[" #axis "]", "zero", NULL, PUT(to.descriptor.dimensions[axis], size_t, 0), INVALID,  \
     "descriptor.dimensions[" #axis "] is 0;", "1 … 32768"},                                                        \
    {f, "descriptor.dimensions[" #axis "]", "huge", NULL, PUT(to.descriptor.dimensions[axis], size_t, 32769),       \
     INVALID, "descriptor.dimensions[" #axis "] is 32769;", "1 … 32768"},                                           \
    {f, "descriptor.dimensions[" #axis "]", "huge", NULL, PUT(to.descriptor.dimensions[axis], size_t, SIZE_MAX),    \
     INVALID, "descriptor.dimensions[" #axis "] is 18446744073709551615;", "1 … 32768"}
#define MATRIX_ROW(f, entry, place, kind, number, value)                                                            \
    {f, "descriptor.index_to_world", kind, NULL, PUT(to.descriptor.index_to_world[entry], double, number), INVALID, \
     "descriptor.index_to_world " place " is " value, "−1e10 … 1e10 mm"}
#define LAST_ROW_ROW(f, entry, kind, number, value)                                                                 \
    {f, "descriptor.index_to_world", kind, NULL, PUT(to.descriptor.index_to_world[entry], double, number), INVALID, \
     "descriptor.index_to_world, last row (entries 3, 7, 11, 15) is " value, "0, 0, 0, 1"}
#define SINGULAR_ROW(f, kind, setting, change)                                                                      \
    {f, "descriptor.index_to_world", kind, setting, change, INVALID,                                                \
     "descriptor.index_to_world is singular (ratio",                                                                \
     "|det|/(product of column norms) ≥ 1e-6"}
#define MADE_IN_ROWS(f)                                                                                             \
    {f, "context", "NULL", NULL, POINT(context, NULL), INVALID, "context is NULL;", "a DrrContext"},                \
    {f, "context", "misaligned", context_askew, NOTHING, INVALID, "context is 0x", "a DrrContext"},                 \
    {f, "context", "foreign", context_foreign, NOTHING, INVALID, "context is no such handle;", "a DrrContext"},     \
    {f, "context", "destroyed", context_destroyed, NOTHING, INVALID, "context is ", "a DrrContext"},                \
    POINTER_ROWS(f, descriptor, descriptor, "8 bytes"),                                                             \
    STRUCT_SIZE_ROWS(f, "descriptor", descriptor, "168")
#define MEANING_ROWS(f)                                                                                             \
    {f, "descriptor.calibration", "unknown", NULL, PUT(to.descriptor.calibration, uint32_t, 4), INVALID,            \
     "descriptor.calibration is 4;", "DRR_CALIBRATION constants, 0 … 3"},                                           \
    {f, "descriptor.calibration", "unknown", NULL, PUT(to.descriptor.calibration, uint32_t, UINT32_MAX), INVALID,   \
     "descriptor.calibration is 4294967295;", "DRR_CALIBRATION constants, 0 … 3"},                                  \
    {f, "descriptor.thresholds", "unknown", NULL, PUT(to.descriptor.thresholds, uint32_t, 4), INVALID,              \
     "descriptor.thresholds is 4;", "DRR_THRESHOLDS constants, 0 … 3"},                                             \
    {f, "descriptor.thresholds", "unknown", NULL, PUT(to.descriptor.thresholds, uint32_t, UINT32_MAX), INVALID,     \
     "descriptor.thresholds is 4294967295;", "DRR_THRESHOLDS constants, 0 … 3"}
#define GRID_ROWS(f)                                                                                                \
    MADE_IN_ROWS(f),                                                                                                \
    DIMENSION_ROWS(f, 0), DIMENSION_ROWS(f, 1), DIMENSION_ROWS(f, 2),                                               \
    {f, "descriptor.dimensions", "product", all_sides_largest, NOTHING, INVALID,                                    \
     "descriptor.dimensions is [32768, 32768, 32768];", "at most 4294967296 voxels in all"},                        \
    {f, "descriptor.dimensions", "product", sides_overflow, NOTHING, INVALID,                                       \
     "descriptor.dimensions[0] is 4294967296;", "1 … 32768"},                                                       \
    MATRIX_ROW(f, 5, "column 1, row 1", "NaN", NAN, "NaN"),                                                         \
    MATRIX_ROW(f, 9, "column 2, row 1", "+Inf", INFINITY, "inf"),                                                   \
    MATRIX_ROW(f, 12, "column 3, row 0", "-Inf", -INFINITY, "-inf"),                                                \
    MATRIX_ROW(f, 14, "column 3, row 2", "huge", 1e11, "100000000000"),                                             \
    MATRIX_ROW(f, 0, "column 0, row 0", "huge", -1e300, "-1e300"),                                                  \
    {f, "descriptor.index_to_world", "tiny", NULL, PUT(to.descriptor.index_to_world[5], double, 1e-10), INVALID,    \
     "descriptor.index_to_world column 1, length is 0.0000000001;", "at least 1e-9 mm"},                            \
    LAST_ROW_ROW(f, 3, "last row", 1e-9, "[1e-9, 0.0, 0.0, 1.0]"),                                                  \
    LAST_ROW_ROW(f, 7, "last row", NAN, "[0.0, NaN, 0.0, 1.0]"),                                                    \
    LAST_ROW_ROW(f, 15, "last row", 0.0, "[0.0, 0.0, 0.0, 0.0]"),                                                   \
    LAST_ROW_ROW(f, 15, "last row", INFINITY, "[0.0, 0.0, 0.0, inf]"),                                              \
    SINGULAR_ROW(f, "singular", NULL, PUT(to.descriptor.index_to_world[5], double, 0.0)),                           \
    SINGULAR_ROW(f, "singular", singular, NOTHING),                                                                 \
    SINGULAR_ROW(f, "nearly singular", nearly_singular_and_large, NOTHING),                                         \
    MEANING_ROWS(f)
#define PLACE_ROWS(f) GRID_ROWS(f), POINTER_ROWS(f, volume, handle, "8 bytes")
#define VOXELS_ROWS(f, voxels, alignment)                                                                           \
    {f, "hu", "NULL", NULL, POINT(hu, NULL), INVALID, "hu is NULL;", "a pointer to 24 values"},                     \
    {f, "hu", "misaligned", NULL, ASKEW(hu, voxels), INVALID, "hu is 0x", "aligned to " alignment},                 \
    {f, "labels", "label", NULL, PUT(to.labels[NX * NY + 1], uint8_t, 255), INVALID,                                \
     "labels at voxel [1, 0, 1] is 255;", "0 … 7"},                                                                 \
    {f, "labels", "label", two_wrong_labels, NOTHING, INVALID, "labels at voxel [1, 0, 0] is 8;", "0 … 7"}
#define VOXEL_ROW(kind, number, value)                                                                              \
    {&volume_create_float32, "hu", kind, NULL, PUT(to.hu_float32[VOXELS - 1], float, number), INVALID,              \
     "hu at voxel [3, 2, 1] is " value ";", "finite HU (1 are not)"}

static const Row volume_rows[] = {
    PLACE_ROWS(&volume_create),
    PLACE_ROWS(&volume_create_float32),
    PLACE_ROWS(&volume_create_texture),
    VOXELS_ROWS(&volume_create, hu, "2 bytes"),
    VOXELS_ROWS(&volume_create_float32, hu_float32, "4 bytes"),
    POINTER_ROWS(&volume_create_texture, texture, hu, "8 bytes"),
    MADE_IN_ROWS(&volume_load),
    MEANING_ROWS(&volume_load),
    POINTER_ROWS(&volume_load, volume, handle, "8 bytes"),
    {&volume_load, "path", "NULL", NULL, PUT(path, const char *, NULL), INVALID, "path is NULL;", "a pointer"},
    {&volume_load, "path", "not UTF-8", NULL, PUT(path, const char *, "\xff.nii"), INVALID, "path is ", "UTF-8"},
    {&volume_load, "path", "unknown", NULL, PUT(path, const char *, "missing.nii"), DRR_STATUS_FILE, "missing.nii: ",
     "No such file"},
    VOXEL_ROW("NaN", NAN, "NaN"),
    VOXEL_ROW("+Inf", INFINITY, "inf"),
    VOXEL_ROW("-Inf", -INFINITY, "-inf"),
    {&volume_create_float32, "hu", "count", three_wrong_voxels, NOTHING, INVALID, "hu at voxel [1, 1, 0] is NaN;",
     "finite HU (3 are not)"},
    {&volume_destroy, "volume", "misaligned", volume_askew, NOTHING, INVALID, "volume is 0x", "a DrrVolume"},
    {&volume_destroy, "volume", "foreign", volume_foreign, NOTHING, INVALID, "volume is no such handle;",
     "a DrrVolume that has not been destroyed"},
    {&volume_destroy, "volume", "destroyed", volume_destroyed, NOTHING, INVALID, "volume is ",
     "a DrrVolume that has not been destroyed"},
};

#endif
