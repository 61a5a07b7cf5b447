/* What the projectors of parallel beams refuse, in float32 and in float64. */
#ifndef PARALLEL_ROWS_H
#define PARALLEL_ROWS_H

#include "volume_rows.h"
#include "view_rows.h"

/* Good arguments that are the same in both widths. */
static void good_parallel(Given *g) {
    drr_parallel_geometry_init(&g->to.geometry);
    memcpy(g->to.geometry.dimensions, g->to.descriptor.dimensions, sizeof g->to.geometry.dimensions);
    g->to.geometry.detector_columns = WIDTH;
    g->to.geometry.detector_rows = HEIGHT;
    for (int i = 0; i < VOXELS; i++) g->to.field_f64[i] = g->to.field[i] = (float)(i % 7);
    for (int i = 0; i < IMAGES; i++) g->to.measured_f64[i] = g->to.measured[i] = (float)(i % 5);
    for (int i = 0; i < 6 * VIEWS; i++) g->to.parameters[i] = 0.125 * i;
    for (int i = 0; i < PIXELS; i++) {
        g->to.mask[i] = (uint8_t)(255 * (i % 2));
        g->to.lengths[2 * i] = -1.0;
        g->to.lengths[2 * i + 1] = 1.0 + i;
    }
    g->geometry = &g->to.geometry;
    g->parameters = g->to.parameters;
    g->mask = g->to.mask;
    g->lengths = g->to.lengths;
    g->loss = &g->to.loss;
    g->gradient = g->to.gradient;
    g->hessian = g->to.hessian;
}
static void good_float32(Given *g) {
    good_parallel(g);
    g->volume = g->to.field;
    g->measured = g->to.measured;
    g->image = g->images = g->to.images;
    g->jacobian = g->to.jacobian;
    g->parallel = live.parallel;
}
static void good_float64(Given *g) {
    good_parallel(g);
    g->volume = g->to.field_f64;
    g->measured = g->to.measured_f64;
    g->image = g->images = g->to.reference_images;
    g->jacobian = g->to.jacobian_f64;
    g->parallel = live.parallel_f64;
}
static void place_float32(Given *g) {
    good_float32(g);
    g->parallel = &g->to.handle;
}
static void place_float64(Given *g) {
    good_float64(g);
    g->parallel = &g->to.handle;
}

static DrrStatus call_geometry_init(const Given *g) {
    return drr_parallel_geometry_init((DrrParallelGeometry *)g->geometry);
}

/* The adjoint reads images. */
static void measured_images(Given *g) {
    good_float32(g);
    g->images = g->to.measured;
}
static void measured_images_f64(Given *g) {
    good_float64(g);
    g->images = g->to.measured_f64;
}

/* The functions of one width: `suffix` ends their names, `Handle` and `real` are its types. */
#define PARALLEL_FUNCTIONS(suffix, Handle, real, good_of, place_of)                                                   \
    static DrrStatus call_parallel_create##suffix(const Given *g) {                                                   \
        return drr_parallel_create##suffix((const DrrContext *)g->context, (const DrrParallelGeometry *)g->geometry,  \
                                           (const real *)g->volume, (Handle **)g->parallel);                          \
    }                                                                                                                 \
    static DrrStatus call_parallel_destroy##suffix(const Given *g) {                                                  \
        return drr_parallel_destroy##suffix((Handle *)g->parallel);                                                   \
    }                                                                                                                 \
    static DrrStatus call_forward_view##suffix(const Given *g) {                                                      \
        return drr_parallel_forward_project_view##suffix((const Handle *)g->parallel, (const double *)g->parameters,  \
                                                         (const uint8_t *)g->mask, (const double *)g->lengths,        \
                                                         (real *)g->image);                                           \
    }                                                                                                                 \
    static DrrStatus call_batch##suffix(const Given *g) {                                                             \
        return drr_parallel_batch_forward_project##suffix((const Handle *)g->parallel, (const double *)g->parameters, \
                                                          g->view_count, (real *)g->images);                          \
    }                                                                                                                 \
    static DrrStatus call_adjoint##suffix(const Given *g) {                                                           \
        return drr_parallel_adjoint##suffix((const Handle *)g->parallel, (const double *)g->parameters,               \
                                            g->view_count, (const real *)g->images, (real *)g->volume);               \
    }                                                                                                                 \
    static DrrStatus call_view_loss##suffix(const Given *g) {                                                         \
        return drr_parallel_view_loss_value_and_grad##suffix(                                                         \
            (const Handle *)g->parallel, (const double *)g->parameters, (const real *)g->measured,                    \
            (const uint8_t *)g->mask, (const double *)g->lengths, (double *)g->loss, (double *)g->gradient,           \
            (double *)g->hessian);                                                                                    \
    }                                                                                                                 \
    static DrrStatus call_view_jacobian##suffix(const Given *g) {                                                     \
        return drr_parallel_view_jacobian##suffix((const Handle *)g->parallel, (const double *)g->parameters,         \
                                                  (const uint8_t *)g->mask, (const double *)g->lengths,               \
                                                  (real *)g->image, (real *)g->jacobian);                             \
    }                                                                                                                 \
    static void destroy_made_parallel##suffix(const Given *g) {                                                       \
        drr_parallel_destroy##suffix((Handle *)g->to.handle);                                                         \
    }                                                                                                                 \
    static void no_parallel##suffix(Given *g) {                                                                       \
        good_of(g);                                                                                                   \
        g->parallel = NULL;                                                                                           \
    }                                                                                                                 \
    static void parallel_destroyed##suffix(Given *g) {                                                                \
        Handle *parallel = NULL;                                                                                      \
        drr_parallel_create##suffix(live.context, &g->to.geometry, (const real *)g->volume, &parallel);               \
        drr_parallel_destroy##suffix(parallel);                                                                       \
        g->parallel = parallel;                                                                                       \
    }                                                                                                                 \
    static const Function                                                                                             \
        parallel_create##suffix = {"drr_parallel_create" #suffix, place_of, call_parallel_create##suffix,             \
                                   destroy_made_parallel##suffix},                                                    \
        parallel_destroy##suffix = {"drr_parallel_destroy" #suffix, no_parallel##suffix,                              \
                                    call_parallel_destroy##suffix, NULL},                                             \
        forward_view##suffix = {"drr_parallel_forward_project_view" #suffix, good_of, call_forward_view##suffix, NULL},\
        batch##suffix = {"drr_parallel_batch_forward_project" #suffix, good_of, call_batch##suffix, NULL},            \
        adjoint##suffix = {"drr_parallel_adjoint" #suffix, measured_images##suffix, call_adjoint##suffix, NULL},           \
        view_loss##suffix = {"drr_parallel_view_loss_value_and_grad" #suffix, good_of, call_view_loss##suffix, NULL}, \
        view_jacobian##suffix = {"drr_parallel_view_jacobian" #suffix, good_of, call_view_jacobian##suffix, NULL};

PARALLEL_FUNCTIONS(, DrrParallel, float, good_float32, place_float32)
PARALLEL_FUNCTIONS(_f64, DrrParallelF64, double, good_float64, place_float64)

static const Function geometry_init = {"drr_parallel_geometry_init", good_parallel, call_geometry_init, NULL};

static void parallel_askew(Given *g) { g->parallel = (char *)live.parallel + 1; }
/* Of the other width. */
static void parallel_foreign(Given *g) { g->parallel = live.parallel_f64; }
static void parallel_foreign_f64(Given *g) { g->parallel = live.parallel; }
static void geometry_vast(Given *g) {
    for (int axis = 0; axis < 3; axis++) g->to.geometry.dimensions[axis] = 32768;
}
static void no_rays(Given *g) { memset(g->to.mask, 0, sizeof g->to.mask); }
static void rays_descend(Given *g) { g->to.lengths[2] = 3.0; }

#define GEOMETRY_ROW(f, field, type, kind, number, value, valid)                                                      \
    {f, "geometry." #field, kind, NULL, PUT(to.geometry.field, type, number), INVALID, "geometry." value, valid}
#define GEOMETRY_SIZE_ROWS(f, field, valid)                                                                           \
    GEOMETRY_ROW(f, field, size_t, "zero", 0, #field " is 0;", valid),                                                \
    GEOMETRY_ROW(f, field, size_t, "huge", 32769, #field " is 32769;", valid),                                        \
    GEOMETRY_ROW(f, field, size_t, "huge", SIZE_MAX, #field " is 18446744073709551615;", valid)
#define GEOMETRY_LENGTH_ROWS(f, field, valid)                                                                         \
    GEOMETRY_ROW(f, field, double, "NaN", NAN, #field " is NaN;", valid),                                             \
    GEOMETRY_ROW(f, field, double, "+Inf", INFINITY, #field " is inf;", valid),                                       \
    GEOMETRY_ROW(f, field, double, "-Inf", -INFINITY, #field " is -inf;", valid),                                     \
    GEOMETRY_ROW(f, field, double, "negative", -1.0, #field " is -1;", valid),                                        \
    GEOMETRY_ROW(f, field, double, "huge", 2e6, #field " is 2000000;", valid)
#define POINT_ROW(f, field, at, kind, number, value)                                                              \
    {f, "geometry." #field, kind, NULL, PUT(to.geometry.field[at], double, number), INVALID,                          \
     "geometry." #field " is [" value, WHERE_RANGE}
#define GEOMETRY_POINT_ROWS(f, field, last)                                                                           \
    POINT_ROW(f, field, 0, "NaN", NAN, "NaN, "), POINT_ROW(f, field, 0, "+Inf", INFINITY, "inf, "),         \
    POINT_ROW(f, field, last, "-Inf", -INFINITY, "0e0, 0e0, -inf]; valid: "),                                    \
    POINT_ROW(f, field, last, "huge", 2e10, "0e0, 0e0, 2e10]; valid: ")
#define SPACING_RANGE "1e-9 … 1e6 mm"
#define PITCH_RANGE "1e-9 … 1e6 mm"
#define GEOMETRY_ROWS(f)                                                                                              \
    POINTER_ROWS(f, geometry, geometry, "8 bytes"), STRUCT_SIZE_ROWS(f, "geometry", geometry, "144"),                 \
    GEOMETRY_SIZE_ROWS(f, dimensions[0], "1 … 32768"), GEOMETRY_SIZE_ROWS(f, dimensions[2], "1 … 32768"),             \
    {f, "geometry.dimensions", "product", geometry_vast, NOTHING, INVALID,                                            \
     "geometry.dimensions is [32768, 32768, 32768];", "at most 4294967296 voxels in all"},                            \
    GEOMETRY_LENGTH_ROWS(f, spacing[1], SPACING_RANGE),                                                               \
    GEOMETRY_ROW(f, spacing[0], double, "zero", 0.0, "spacing[0] is 0;", SPACING_RANGE),                              \
    GEOMETRY_ROW(f, spacing[2], double, "tiny", 1e-10, "spacing[2] is 0.0000000001;", SPACING_RANGE),                 \
    GEOMETRY_POINT_ROWS(f, centre, 2),                                                                                \
    GEOMETRY_SIZE_ROWS(f, detector_columns, "1 … 32768 pixels"),                                                      \
    GEOMETRY_SIZE_ROWS(f, detector_rows, "1 … 32768 pixels"),                                                         \
    GEOMETRY_LENGTH_ROWS(f, pixel[0], PITCH_RANGE), GEOMETRY_LENGTH_ROWS(f, pixel[1], PITCH_RANGE),                   \
    GEOMETRY_POINT_ROWS(f, detector_centre, 1), GEOMETRY_LENGTH_ROWS(f, step, PITCH_RANGE),                           \
    GEOMETRY_ROW(f, steps, uint32_t, "huge", 1048577, "steps is 1048577;", "1 … 1048576"),                            \
    GEOMETRY_ROW(f, steps, uint32_t, "huge", UINT32_MAX, "steps is 4294967295;", "1 … 1048576"),                      \
    {f, "geometry.step", "too many", NULL, PUT(to.geometry.step, double, 0x1p-20), INVALID,                           \
     "geometry.step is 9.5367431640625e-7;", "has at most 1048576"},                                                  \
    GEOMETRY_ROW(f, step, double, "tiny", 1e-10, "step is 0.0000000001;", "has at most 1048576"),                     \
    GEOMETRY_ROW(f, quadrature, uint32_t, "unknown", 2, "quadrature is 2;", "DRR_PARALLEL constants, 0 … 1"),         \
    GEOMETRY_ROW(f, quadrature, uint32_t, "unknown", UINT32_MAX, "quadrature is 4294967295;", "DRR_PARALLEL constants")

/* Numbers behind a pointer. */
#define NUMBERS_ROW(f, name, kind, pointee, real, number, value, valid)                                               \
    {f, name, kind, NULL, PUT(to.pointee, real, number), INVALID, value ";", valid}
#define FINITE_ROWS(f, name, pointee, real, called, valid)                                                            \
    NUMBERS_ROW(f, name, "NaN", pointee, real, NAN, called " is NaN", valid),                                         \
    NUMBERS_ROW(f, name, "+Inf", pointee, real, INFINITY, called " is inf", valid),                                   \
    NUMBERS_ROW(f, name, "-Inf", pointee, real, -INFINITY, called " is -inf", valid)
#define PLACE_ROW(f, name, pointee, alignment)                                                                        \
    {f, #name, "misaligned", NULL, ASKEW(name, pointee), INVALID, #name " is 0x", "aligned to " alignment}
#define ARRAY_ROWS(f, name, pointee, alignment)                                                                       \
    {f, #name, "NULL", NULL, POINT(name, NULL), INVALID, #name " is NULL;", "a pointer"},                             \
        PLACE_ROW(f, name, pointee, alignment)
/* Angles and translation of the view whose parameters begin at `first`; `both` is what the translation is called. */
#define ANGLE_RANGE "−100 … 100 rad"
#define MOTION_ROWS(f, angle, called, moved, both)                                                                    \
    ARRAY_ROWS(f, parameters, parameters, "8 bytes"),                                                                 \
    FINITE_ROWS(f, "parameters", parameters[angle], double, "parameters[" #angle "], " called ",", ANGLE_RANGE),      \
    NUMBERS_ROW(f, "parameters", "huge", parameters[angle], double, 101.0,                                            \
                "parameters[" #angle "], " called ", is 101", ANGLE_RANGE),                                           \
    {f, "parameters", "NaN", NULL, PUT(to.parameters[moved], double, NAN), INVALID, "parameters" both ", is [",       \
     WHERE_RANGE},                                                                                                    \
    {f, "parameters", "huge", NULL, PUT(to.parameters[moved], double, -2e10), INVALID, "parameters" both ", is [",    \
     WHERE_RANGE}

#define OWN_HANDLE_ROWS(f, suffix, Handle)                                                                            \
    {f, "parallel", "misaligned", parallel_askew, NOTHING, INVALID, "parallel is 0x", "a " Handle},                   \
    {f, "parallel", "foreign", parallel_foreign##suffix, NOTHING, INVALID, "parallel is no such handle;",             \
     "a " Handle " that has not been destroyed"},                                                                     \
    {f, "parallel", "destroyed", parallel_destroyed##suffix, NOTHING, INVALID, "parallel is ", "a " Handle}
#define PARALLEL_HANDLE_ROWS(f, suffix, Handle)                                                                       \
    {f, "parallel", "NULL", NULL, POINT(parallel, NULL), INVALID, "parallel is NULL;", "a " Handle},                  \
        OWN_HANDLE_ROWS(f, suffix, Handle)
#define RAY_ROWS(f)                                                                                                   \
    {f, "mask", "empty", no_rays, NOTHING, INVALID, "mask is empty;", "at least one ray that counts"},                \
    PLACE_ROW(f, lengths, lengths, "8 bytes"),                                                                        \
    NUMBERS_ROW(f, "lengths", "NaN", lengths[2], double, NAN, "lengths of pixel [1] is [NaN, 2]", "from ≤ to"),       \
    NUMBERS_ROW(f, "lengths", "+Inf", lengths[11], double, INFINITY, "lengths of pixel [5] is [-1, inf]", "finite"),  \
    NUMBERS_ROW(f, "lengths", "-Inf", lengths[0], double, -INFINITY, "lengths of pixel [0] is [-inf, 1]", "finite"),  \
    {f, "lengths", "descending", rays_descend, NOTHING, INVALID, "lengths of pixel [1] is [3, 2];", "from ≤ to, mm"}

#define PARALLEL_ROWS(suffix, Handle, real, alignment, field_, measured_, image_, jacobian_)                           \
    {&parallel_create##suffix, "context", "NULL", NULL, POINT(context, NULL), INVALID, "context is NULL;",            \
     "a DrrContext"},                                                                                                 \
    CONTEXT_ROWS(&parallel_create##suffix), GEOMETRY_ROWS(&parallel_create##suffix),                                  \
    ARRAY_ROWS(&parallel_create##suffix, volume, field_, alignment),                                                   \
    FINITE_ROWS(&parallel_create##suffix, "volume", field_[VOXELS - 1], real, "volume at voxel [3, 2, 1]", "finite"),  \
    POINTER_ROWS(&parallel_create##suffix, parallel, handle, "8 bytes"),                                              \
                                                                                                                      \
    OWN_HANDLE_ROWS(&parallel_destroy##suffix, suffix, Handle),                                                       \
                                                                                                                      \
    PARALLEL_HANDLE_ROWS(&forward_view##suffix, suffix, Handle),                                                      \
    MOTION_ROWS(&forward_view##suffix, 0, "alpha", 3, "[3] and [4], (dx, 0, dz)"), RAY_ROWS(&forward_view##suffix),   \
    ARRAY_ROWS(&forward_view##suffix, image, image_, alignment),                                                       \
                                                                                                                      \
    PARALLEL_HANDLE_ROWS(&batch##suffix, suffix, Handle),                                                             \
    MOTION_ROWS(&batch##suffix, 6, "beta", 9, "[8] and [9], (dx, 0, dz)"),                                            \
    COUNT_ROWS(&batch##suffix, "view_count", view_count, "65536", 65537),                                             \
    ARRAY_ROWS(&batch##suffix, images, image_, alignment),                                                             \
                                                                                                                      \
    PARALLEL_HANDLE_ROWS(&adjoint##suffix, suffix, Handle),                                                           \
    MOTION_ROWS(&adjoint##suffix, 5, "alpha", 8, "[8] and [9], (dx, 0, dz)"),                                         \
    COUNT_ROWS(&adjoint##suffix, "view_count", view_count, "65536", 65537),                                           \
    ARRAY_ROWS(&adjoint##suffix, images, measured_, alignment),                                                       \
    FINITE_ROWS(&adjoint##suffix, "images", measured_[IMAGES - 1], real, "images[11]", "finite numbers"),             \
    ARRAY_ROWS(&adjoint##suffix, volume, field_, alignment),                                                          \
                                                                                                                      \
    PARALLEL_HANDLE_ROWS(&view_loss##suffix, suffix, Handle),                                                         \
    MOTION_ROWS(&view_loss##suffix, 1, "beta", 4, "[3] and [4], (dx, 0, dz)"), RAY_ROWS(&view_loss##suffix),          \
    ARRAY_ROWS(&view_loss##suffix, measured, measured_, alignment),                                                    \
    FINITE_ROWS(&view_loss##suffix, "measured", measured_[5], real, "measured[5]", "finite numbers where pixels count"),\
    ARRAY_ROWS(&view_loss##suffix, loss, loss, "8 bytes"),                                                            \
    ARRAY_ROWS(&view_loss##suffix, gradient, gradient, "8 bytes"),                                                    \
    PLACE_ROW(&view_loss##suffix, hessian, hessian, "8 bytes"),                                                       \
                                                                                                                      \
    PARALLEL_HANDLE_ROWS(&view_jacobian##suffix, suffix, Handle),                                                     \
    MOTION_ROWS(&view_jacobian##suffix, 2, "phi", 3, "[3] and [4], (dx, 0, dz)"), RAY_ROWS(&view_jacobian##suffix),   \
    PLACE_ROW(&view_jacobian##suffix, image, image_, alignment),                                                       \
    ARRAY_ROWS(&view_jacobian##suffix, jacobian, jacobian_, alignment)

static const Row parallel_rows[] = {
    POINTER_ROWS(&geometry_init, geometry, geometry, "8 bytes"),
    PARALLEL_ROWS(, "DrrParallel", float, "4 bytes", field, measured, images, jacobian),
    PARALLEL_ROWS(_f64, "DrrParallelF64", double, "8 bytes", field_f64, measured_f64, reference_images, jacobian_f64),
};

static inline int create_live_parallel(void) {
    good(&given);
    good_parallel(&given);
    OK(drr_parallel_create(live.context, &given.to.geometry, given.to.field, &live.parallel));
    OK(drr_parallel_create_f64(live.context, &given.to.geometry, given.to.field_f64, &live.parallel_f64));
    return 0;
}

static inline int destroy_live_parallel(void) {
    OK(drr_parallel_destroy_f64(live.parallel_f64));
    OK(drr_parallel_destroy(live.parallel));
    return 0;
}

#endif
