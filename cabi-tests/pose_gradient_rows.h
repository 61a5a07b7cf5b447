/* What pose gradients refuse, in float32 and in float64. */
#ifndef POSE_GRADIENT_ROWS_H
#define POSE_GRADIENT_ROWS_H

#include "parallel_rows.h"

static void pose_float32(Given *g) {
    good_float32(g);
    g->pose_gradient = live.pose_gradient;
    g->signal = DRR_SIGNAL_INTENSITY;
}
static void pose_float64(Given *g) {
    good_float64(g);
    g->pose_gradient = live.pose_gradient_f64;
    g->signal = DRR_SIGNAL_INTENSITY;
}
static void pose_place(Given *g) {
    good_parallel(g);
    g->volume = live.volume;
    g->pivot = g->to.centre;
    g->pose_gradient = &g->to.handle;
}

#define POSE_FUNCTIONS(suffix, Handle, real, good_of)                                                                 \
    static DrrStatus call_pose_create##suffix(const Given *g) {                                                       \
        return drr_pose_gradient_create##suffix((const DrrVolume *)g->volume, (const DrrScene *)g->scene,             \
                                                (const double *)g->pivot, (Handle **)g->pose_gradient);               \
    }                                                                                                                 \
    /* What there are no derivatives of is refused last of all: the scene is valid. */                                \
    static DrrStatus call_pose_plan##suffix(const Given *g) {                                                         \
        Handle *made = NULL;                                                                                          \
        const DrrStatus status =                                                                                      \
            drr_pose_gradient_create##suffix((const DrrVolume *)g->volume, (const DrrScene *)g->scene, NULL, &made);  \
        drr_pose_gradient_destroy##suffix(made);                                                                      \
        return status == DRR_STATUS_UNSUPPORTED ? DRR_STATUS_OK : status;                                             \
    }                                                                                                                 \
    static DrrStatus call_pose_destroy##suffix(const Given *g) {                                                      \
        return drr_pose_gradient_destroy##suffix((Handle *)g->pose_gradient);                                         \
    }                                                                                                                 \
    static DrrStatus call_pose_project##suffix(const Given *g) {                                                      \
        return drr_pose_gradient_project##suffix((const Handle *)g->pose_gradient, (const DrrDetectorPose *)g->pose,  \
                                                 (const double *)g->parameters, g->signal, (real *)g->image);         \
    }                                                                                                                 \
    static DrrStatus call_pose_loss##suffix(const Given *g) {                                                         \
        return drr_pose_gradient_loss_value_and_grad##suffix(                                                         \
            (const Handle *)g->pose_gradient, (const DrrDetectorPose *)g->pose, (const double *)g->parameters,        \
            g->signal, (const real *)g->measured, (const uint8_t *)g->mask, (double *)g->loss, (double *)g->gradient, \
            (double *)g->hessian);                                                                                    \
    }                                                                                                                 \
    static DrrStatus call_pose_jacobian##suffix(const Given *g) {                                                     \
        return drr_pose_gradient_jacobian##suffix((const Handle *)g->pose_gradient, (const DrrDetectorPose *)g->pose, \
                                                  (const double *)g->parameters, g->signal, (real *)g->image,         \
                                                  (real *)g->jacobian);                                               \
    }                                                                                                                 \
    static void destroy_made_pose##suffix(const Given *g) {                                                           \
        drr_pose_gradient_destroy##suffix((Handle *)g->to.handle);                                                    \
    }                                                                                                                 \
    static void no_pose##suffix(Given *g) { g->pose_gradient = NULL; }                                                \
    static void pose_destroyed##suffix(Given *g) {                                                                    \
        Handle *made = NULL;                                                                                          \
        drr_pose_gradient_create##suffix(live.volume, &g->to.scene, NULL, &made);                                     \
        drr_pose_gradient_destroy##suffix(made);                                                                      \
        g->pose_gradient = made;                                                                                      \
    }                                                                                                                 \
    static const Function                                                                                             \
        pose_create##suffix = {"drr_pose_gradient_create" #suffix, pose_place, call_pose_create##suffix,              \
                               destroy_made_pose##suffix},                                                            \
        pose_gradient_plan##suffix = {"drr_pose_gradient_create" #suffix, NULL, call_pose_plan##suffix, NULL},        \
        pose_destroy##suffix = {"drr_pose_gradient_destroy" #suffix, no_pose##suffix, call_pose_destroy##suffix,      \
                                NULL},                                                                                \
        pose_project##suffix = {"drr_pose_gradient_project" #suffix, good_of, call_pose_project##suffix, NULL},       \
        pose_loss##suffix = {"drr_pose_gradient_loss_value_and_grad" #suffix, good_of, call_pose_loss##suffix, NULL}, \
        pose_jacobian##suffix = {"drr_pose_gradient_jacobian" #suffix, good_of, call_pose_jacobian##suffix, NULL};

POSE_FUNCTIONS(, DrrPoseGradient, float, pose_float32)
POSE_FUNCTIONS(_f64, DrrPoseGradientF64, double, pose_float64)

static void pose_askew(Given *g) { g->pose_gradient = (char *)live.pose_gradient + 1; }
/* Of the other width. */
static void pose_foreign(Given *g) { g->pose_gradient = live.pose_gradient_f64; }
static void pose_foreign_f64(Given *g) { g->pose_gradient = live.pose_gradient; }

#define PIVOT_ROW(f, at, kind, number, value)                                                                         \
    {f, "pivot", kind, NULL, PUT(to.centre[at], double, number), INVALID, "pivot is [" value, WHERE_RANGE}
#define POSE_OWN_ROWS(f, suffix, Handle)                                                                              \
    {f, "pose_gradient", "misaligned", pose_askew, NOTHING, INVALID, "pose_gradient is 0x", "a " Handle},             \
    {f, "pose_gradient", "foreign", pose_foreign##suffix, NOTHING, INVALID, "pose_gradient is no such handle;",       \
     "a " Handle " that has not been destroyed"},                                                                     \
    {f, "pose_gradient", "destroyed", pose_destroyed##suffix, NOTHING, INVALID, "pose_gradient is ", "a " Handle}
#define POSE_VIEW_ROWS(f, suffix, Handle)                                                                             \
    {f, "pose_gradient", "NULL", NULL, POINT(pose_gradient, NULL), INVALID, "pose_gradient is NULL;", "a " Handle},   \
        POSE_OWN_ROWS(f, suffix, Handle), POINTER_ROWS(f, pose, poses, "8 bytes"), POSE_ROWS(f, "pose"),              \
        MOTION_ROWS(f, 2, "phi", 5, "[3] to [5], the translation"),                                                   \
        {f, "signal", "unknown", NULL, PUT(signal, DrrPoseSignal, 2), INVALID, "signal is 2;", "DRR_SIGNAL constants, 0 … 1"}

#define POSE_GRADIENT_ROWS(suffix, Handle, real, alignment, measured_, image_, jacobian_)                             \
    {&pose_create##suffix, "volume", "NULL", NULL, POINT(volume, NULL), INVALID, "volume is NULL;", "a DrrVolume"},   \
    {&pose_create##suffix, "volume", "misaligned", volume_askew, NOTHING, INVALID, "volume is 0x", "a DrrVolume"},    \
    {&pose_create##suffix, "volume", "foreign", volume_foreign, NOTHING, INVALID, "volume is no such handle;",        \
     "a DrrVolume that has not been destroyed"},                                                                      \
    {&pose_create##suffix, "volume", "destroyed", volume_destroyed, NOTHING, INVALID, "volume is ", "a DrrVolume"},   \
    POINTER_ROWS(&pose_create##suffix, scene, scene, "8 bytes"),                                                      \
    PLACE_ROW(&pose_create##suffix, pivot, centre, "8 bytes"),                                                        \
    PIVOT_ROW(&pose_create##suffix, 0, "NaN", NAN, "NaN, "), PIVOT_ROW(&pose_create##suffix, 0, "+Inf", INFINITY, "inf"),\
    PIVOT_ROW(&pose_create##suffix, 0, "-Inf", -INFINITY, "-inf, "), PIVOT_ROW(&pose_create##suffix, 0, "huge", 2e10, "2e10"),\
    POINTER_ROWS(&pose_create##suffix, pose_gradient, handle, "8 bytes"),                                             \
                                                                                                                      \
    POSE_OWN_ROWS(&pose_destroy##suffix, suffix, Handle),                                                             \
                                                                                                                      \
    POSE_VIEW_ROWS(&pose_project##suffix, suffix, Handle),                                                            \
    ARRAY_ROWS(&pose_project##suffix, image, image_, alignment),                                                      \
                                                                                                                      \
    POSE_VIEW_ROWS(&pose_loss##suffix, suffix, Handle),                                                               \
    ARRAY_ROWS(&pose_loss##suffix, measured, measured_, alignment),                                                   \
    FINITE_ROWS(&pose_loss##suffix, "measured", measured_[5], real, "measured[5]", "finite numbers where pixels count"),\
    {&pose_loss##suffix, "mask", "empty", no_rays, NOTHING, INVALID, "mask is empty;", "at least one pixel that counts"},\
    ARRAY_ROWS(&pose_loss##suffix, loss, loss, "8 bytes"), ARRAY_ROWS(&pose_loss##suffix, gradient, gradient, "8 bytes"),\
    PLACE_ROW(&pose_loss##suffix, hessian, hessian, "8 bytes"),                                                       \
                                                                                                                      \
    POSE_VIEW_ROWS(&pose_jacobian##suffix, suffix, Handle),                                                           \
    PLACE_ROW(&pose_jacobian##suffix, image, image_, alignment),                                                      \
    ARRAY_ROWS(&pose_jacobian##suffix, jacobian, jacobian_, alignment)

static const Row pose_gradient_rows[] = {
    POSE_GRADIENT_ROWS(, "DrrPoseGradient", float, "4 bytes", measured, images, jacobian),
    POSE_GRADIENT_ROWS(_f64, "DrrPoseGradientF64", double, "8 bytes", measured_f64, reference_images, jacobian_f64),
};

static inline int create_live_pose_gradients(void) {
    good(&given);
    OK(drr_pose_gradient_create(live.volume, &given.to.scene, NULL, &live.pose_gradient));
    OK(drr_pose_gradient_create_f64(live.volume, &given.to.scene, NULL, &live.pose_gradient_f64));
    return 0;
}

static inline int destroy_live_pose_gradients(void) {
    OK(drr_pose_gradient_destroy_f64(live.pose_gradient_f64));
    OK(drr_pose_gradient_destroy(live.pose_gradient));
    return 0;
}

#endif
