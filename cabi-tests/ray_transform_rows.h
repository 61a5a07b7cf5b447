/* What ray transforms refuse, in float32 and in float64. */
#ifndef RAY_TRANSFORM_ROWS_H
#define RAY_TRANSFORM_ROWS_H

#include "parallel_rows.h"

static void march_float32(Given *g) {
    good_float32(g);
    g->algorithm = DRR_ALGORITHM_MARCH;
    g->step_voxels = 0.5;
    g->images = g->to.measured;
    g->transform = live.transform;
}
static void march_float64(Given *g) {
    good_float64(g);
    g->algorithm = DRR_ALGORITHM_MARCH;
    g->step_voxels = 0.5;
    g->images = g->to.measured_f64;
    g->transform = live.transform_f64;
}
static void transform_place_float32(Given *g) {
    march_float32(g);
    g->transform = &g->to.handle;
}
static void transform_place_float64(Given *g) {
    march_float64(g);
    g->transform = &g->to.handle;
}

#define TRANSFORM_FUNCTIONS(suffix, Handle, real, good_of, place_of)                                                  \
    static DrrStatus call_transform_create##suffix(const Given *g) {                                                  \
        return drr_ray_transform_create##suffix((const DrrContext *)g->context,                                       \
                                                (const DrrVolumeDescriptor *)g->descriptor,                           \
                                                (const DrrDetectorPose *)g->poses, g->view_count, g->width,           \
                                                g->height, g->algorithm, g->step_voxels, (Handle **)g->transform);    \
    }                                                                                                                 \
    static DrrStatus call_transform_destroy##suffix(const Given *g) {                                                 \
        return drr_ray_transform_destroy##suffix((Handle *)g->transform);                                             \
    }                                                                                                                 \
    static DrrStatus call_transform_forward##suffix(const Given *g) {                                                 \
        return drr_ray_transform_forward##suffix((const Handle *)g->transform, (const real *)g->volume,               \
                                                 (real *)g->images);                                                  \
    }                                                                                                                 \
    static DrrStatus call_transform_adjoint##suffix(const Given *g) {                                                 \
        return drr_ray_transform_adjoint##suffix((const Handle *)g->transform, (const real *)g->images,               \
                                                 (real *)g->volume);                                                  \
    }                                                                                                                 \
    static void destroy_made_transform##suffix(const Given *g) {                                                      \
        drr_ray_transform_destroy##suffix((Handle *)g->to.handle);                                                    \
    }                                                                                                                 \
    static void no_transform##suffix(Given *g) {                                                                      \
        good_of(g);                                                                                                   \
        g->transform = NULL;                                                                                          \
    }                                                                                                                 \
    static void transform_destroyed##suffix(Given *g) {                                                               \
        Handle *transform = NULL;                                                                                     \
        drr_ray_transform_create##suffix(live.context, &g->to.descriptor, g->to.poses, VIEWS, WIDTH, HEIGHT,          \
                                         DRR_ALGORITHM_JOSEPH, 0.0, &transform);                                      \
        drr_ray_transform_destroy##suffix(transform);                                                                 \
        g->transform = transform;                                                                                     \
    }                                                                                                                 \
    static const Function                                                                                             \
        transform_create##suffix = {"drr_ray_transform_create" #suffix, place_of, call_transform_create##suffix,      \
                                    destroy_made_transform##suffix},                                                  \
        transform_destroy##suffix = {"drr_ray_transform_destroy" #suffix, no_transform##suffix,                       \
                                     call_transform_destroy##suffix, NULL},                                           \
        transform_forward##suffix = {"drr_ray_transform_forward" #suffix, good_of, call_transform_forward##suffix,    \
                                     NULL},                                                                           \
        transform_adjoint##suffix = {"drr_ray_transform_adjoint" #suffix, good_of, call_transform_adjoint##suffix,    \
                                     NULL};

TRANSFORM_FUNCTIONS(, DrrRayTransform, float, march_float32, transform_place_float32)
TRANSFORM_FUNCTIONS(_f64, DrrRayTransformF64, double, march_float64, transform_place_float64)

static void transform_askew(Given *g) { g->transform = (char *)live.transform + 1; }
/* Of the other width. */
static void transform_foreign(Given *g) { g->transform = live.transform_f64; }
static void transform_foreign_f64(Given *g) { g->transform = live.transform; }

#define STEP_RANGE "0.015625 … 8 voxels"
#define STEP_ROW(f, kind, number, value)                                                                              \
    {f, "step_voxels", kind, NULL, PUT(step_voxels, double, number), INVALID, "step_voxels is " value ";", STEP_RANGE}
#define TRANSFORM_OWN_ROWS(f, suffix, Handle)                                                                         \
    {f, "transform", "misaligned", transform_askew, NOTHING, INVALID, "transform is 0x", "a " Handle},                \
    {f, "transform", "foreign", transform_foreign##suffix, NOTHING, INVALID, "transform is no such handle;",          \
     "a " Handle " that has not been destroyed"},                                                                     \
    {f, "transform", "destroyed", transform_destroyed##suffix, NOTHING, INVALID, "transform is ", "a " Handle}
#define TRANSFORM_HANDLE_ROWS(f, suffix, Handle)                                                                      \
    {f, "transform", "NULL", NULL, POINT(transform, NULL), INVALID, "transform is NULL;", "a " Handle},               \
        TRANSFORM_OWN_ROWS(f, suffix, Handle)

#define TRANSFORM_ROWS(suffix, Handle, real, alignment, field_, images_)                                              \
    GRID_ROWS(&transform_create##suffix), POINTER_ROWS(&transform_create##suffix, poses, poses, "8 bytes"),           \
    POSE_ROWS(&transform_create##suffix, "poses[1]"),                                                                 \
    COUNT_ROWS(&transform_create##suffix, "view_count", view_count, "65536", 65537),                                  \
    COUNT_ROWS(&transform_create##suffix, "width", width, "32768 pixels", 32769),                                     \
    COUNT_ROWS(&transform_create##suffix, "height", height, "32768 pixels", 32769),                                   \
    {&transform_create##suffix, "algorithm", "unknown", NULL, PUT(algorithm, DrrAlgorithm, UINT32_MAX), INVALID,      \
     "algorithm is 4294967295;", "DRR_ALGORITHM constants"},                                                          \
    STEP_ROW(&transform_create##suffix, "NaN", NAN, "NaN"), STEP_ROW(&transform_create##suffix, "+Inf", INFINITY, "inf"),\
    STEP_ROW(&transform_create##suffix, "-Inf", -INFINITY, "-inf"),                                                   \
    STEP_ROW(&transform_create##suffix, "zero", 0.0, "0"), STEP_ROW(&transform_create##suffix, "huge", 8.5, "8.5"),   \
    POINTER_ROWS(&transform_create##suffix, transform, handle, "8 bytes"),                                            \
                                                                                                                      \
    TRANSFORM_OWN_ROWS(&transform_destroy##suffix, suffix, Handle),                                                   \
                                                                                                                      \
    TRANSFORM_HANDLE_ROWS(&transform_forward##suffix, suffix, Handle),                                                \
    ARRAY_ROWS(&transform_forward##suffix, volume, field_, alignment),                                                \
    FINITE_ROWS(&transform_forward##suffix, "volume", field_[5], real, "volume[5]", "finite numbers"),                \
    ARRAY_ROWS(&transform_forward##suffix, images, images_, alignment),                                               \
                                                                                                                      \
    TRANSFORM_HANDLE_ROWS(&transform_adjoint##suffix, suffix, Handle),                                                \
    ARRAY_ROWS(&transform_adjoint##suffix, images, images_, alignment),                                               \
    FINITE_ROWS(&transform_adjoint##suffix, "images", images_[IMAGES - 1], real, "images[11]", "finite numbers"),     \
    ARRAY_ROWS(&transform_adjoint##suffix, volume, field_, alignment)

static const Row ray_transform_rows[] = {
    TRANSFORM_ROWS(, "DrrRayTransform", float, "4 bytes", field, measured),
    TRANSFORM_ROWS(_f64, "DrrRayTransformF64", double, "8 bytes", field_f64, measured_f64),
};

static inline int create_live_transforms(void) {
    good(&given);
    OK(drr_ray_transform_create(live.context, &given.to.descriptor, given.to.poses, VIEWS, WIDTH, HEIGHT,
                                DRR_ALGORITHM_JOSEPH, 0.0, &live.transform));
    OK(drr_ray_transform_create_f64(live.context, &given.to.descriptor, given.to.poses, VIEWS, WIDTH, HEIGHT,
                                    DRR_ALGORITHM_JOSEPH, 0.0, &live.transform_f64));
    return 0;
}

static inline int destroy_live_transforms(void) {
    OK(drr_ray_transform_destroy_f64(live.transform_f64));
    OK(drr_ray_transform_destroy(live.transform));
    return 0;
}

#endif
