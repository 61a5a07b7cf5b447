/* What makers of views and projections refuse. */
#ifndef VIEW_ROWS_H
#define VIEW_ROWS_H

#include "scene_rows.h"

static DrrStatus call_uniforms_cone(const Given *g) {
    return drr_uniforms_cone((const DrrDetectorPose *)g->pose, g->width, g->height,
                             (ProjectionUniforms *)g->uniforms);
}
static DrrStatus call_pose_c_arm(const Given *g) {
    return drr_pose_c_arm((const double *)g->centre, g->angle_degrees, g->source_axis_mm, g->source_detector_mm,
                          g->pixel_mm, g->width, g->height, (DrrDetectorPose *)g->pose);
}
static DrrStatus call_projector_destroy(const Given *g) { return drr_projector_destroy((DrrProjector *)g->projector); }
static DrrStatus call_describe(const Given *g) {
    return drr_projector_describe((const DrrProjector *)g->projector) == NULL ? INVALID : DRR_STATUS_OK;
}
static DrrStatus call_project(const Given *g) {
    return drr_projector_project((const DrrProjector *)g->projector, (const ProjectionUniforms *)g->views,
                                 g->view_count, (const DrrOutputs *)g->outputs);
}
static DrrStatus call_project_poses(const Given *g) {
    return drr_projector_project_poses((const DrrProjector *)g->projector, (const DrrDetectorPose *)g->poses,
                                       g->view_count, (const DrrOutputs *)g->outputs);
}
static DrrStatus call_reference_project(const Given *g) {
    return drr_reference_project((const DrrProjector *)g->projector, g->algorithm, (const DrrDetectorPose *)g->poses,
                                 g->view_count, (const DrrReferenceOutputs *)g->outputs);
}
static DrrStatus call_certify(const Given *g) {
    return drr_projector_certify((const DrrProjector *)g->projector, (const DrrDetectorPose *)g->poses, g->view_count,
                                 (DrrCertificate *)g->certificate);
}
/* Engines of the CPU have no queues: a call that is valid gets as far as that. */
static DrrStatus valid(DrrStatus status) { return status == DRR_STATUS_UNSUPPORTED ? DRR_STATUS_OK : status; }
static DrrStatus call_encode(const Given *g) {
    return valid(drr_projector_encode((const DrrProjector *)g->projector, (const ProjectionUniforms *)g->views,
                                      g->view_count, g->queue, (const DrrDeviceOutputs *)g->outputs));
}
static DrrStatus call_encode_poses(const Given *g) {
    return valid(drr_projector_encode_poses((const DrrProjector *)g->projector, (const DrrDetectorPose *)g->poses,
                                            g->view_count, g->queue, (const DrrDeviceOutputs *)g->outputs));
}
static void device_places(Given *g) { g->outputs = &g->to.device_outputs; }
static void no_projector(Given *g) { g->projector = NULL; }
static void float64_places(Given *g) { g->outputs = &g->to.reference_outputs; }

static const Function uniforms_cone = {"drr_uniforms_cone", NULL, call_uniforms_cone, NULL},
                      pose_c_arm = {"drr_pose_c_arm", NULL, call_pose_c_arm, NULL},
                      projector_destroy = {"drr_projector_destroy", no_projector, call_projector_destroy, NULL},
                      describe = {"drr_projector_describe", NULL, call_describe, NULL},
                      project = {"drr_projector_project", NULL, call_project, NULL},
                      project_poses = {"drr_projector_project_poses", NULL, call_project_poses, NULL},
                      certify = {"drr_projector_certify", NULL, call_certify, NULL},
                      encode = {"drr_projector_encode", device_places, call_encode, NULL},
                      encode_poses = {"drr_projector_encode_poses", device_places, call_encode_poses, NULL},
                      reference_project = {"drr_reference_project", float64_places, call_reference_project, NULL};

#define COUNT_ROWS(f, name, member, largest, beyond)                                                                 \
    {f, name, "zero", NULL, PUT(member, size_t, 0), INVALID, name " is 0;", "1 … " largest},                         \
    {f, name, "huge", NULL, PUT(member, size_t, beyond), INVALID, name " is " #beyond ";", "1 … " largest},          \
    {f, name, "huge", NULL, PUT(member, size_t, SIZE_MAX), INVALID, name " is 18446744073709551615;", "1 … " largest}

/* Poses. In both functions that take many, the second is wrong. */
static double *pose_of(Given *g, size_t field) { return (double *)(void *)((char *)&g->to.poses[1] + field); }
#define COLUMN_STEP offsetof(DrrDetectorPose, column_step)
#define ROW_STEP offsetof(DrrDetectorPose, row_step)
static void second_pose(Given *g) { g->pose = &g->to.poses[1]; }
static void steps_parallel(Given *g) {
    second_pose(g);
    for (int axis = 0; axis < 3; axis++) pose_of(g, ROW_STEP)[axis] = -3.0 * pose_of(g, COLUMN_STEP)[axis];
}
static void steps_nearly_parallel(Given *g) {
    steps_parallel(g);
    pose_of(g, ROW_STEP)[2] = 1e-7;
}
static void step_of_zero(Given *g) {
    second_pose(g);
    memset(pose_of(g, COLUMN_STEP), 0, 3 * sizeof(double));
}
/* At pixel (4, -3), which is not on the detector but in its plane. */
static void source_on_detector(Given *g) {
    second_pose(g);
    DrrDetectorPose *pose = &g->to.poses[1];
    for (int axis = 0; axis < 3; axis++) {
        pose->source[axis] = pose->first_pixel[axis] + 4.0 * pose->column_step[axis] - 3.0 * pose->row_step[axis];
    }
}
static void source_on_first_pixel(Given *g) {
    second_pose(g);
    memcpy(g->to.poses[1].source, g->to.poses[1].first_pixel, 3 * sizeof(double));
}
static void pixels_below_float32(Given *g) {
    second_pose(g);
    for (int axis = 0; axis < 3; axis++) {
        pose_of(g, COLUMN_STEP)[axis] *= 1e-40;
        pose_of(g, ROW_STEP)[axis] *= 1e-40;
    }
}
#define COORDINATE_ROW(f, name, field, axis, kind, number, value)                                                    \
    {f, name "." #field, kind, second_pose, PUT(to.poses[1].field[axis], double, number), INVALID,                   \
     name "." #field " is [", value}
#define VECTOR_ROWS(f, name, field)                                                                                  \
    COORDINATE_ROW(f, name, field, 0, "NaN", NAN, "NaN, "),                                                          \
    COORDINATE_ROW(f, name, field, 1, "+Inf", INFINITY, ", inf, "),                                                  \
    COORDINATE_ROW(f, name, field, 2, "-Inf", -INFINITY, ", -inf]; valid: −1e10 … 1e10 mm"),                         \
    COORDINATE_ROW(f, name, field, 0, "huge", 1e300, "[1e300, "),                                                    \
    COORDINATE_ROW(f, name, field, 2, "huge", -1.1e10, ", -1.1e10]; valid: −1e10 … 1e10 mm")
#define STEPS_ROW(f, name, field, kind, setting)                                                                     \
    {f, name "." field, kind, setting, NOTHING, INVALID, name ".column_step and row_step is [",                      \
     "two independent vectors, mm"}
#define POSE_ROWS(f, name)                                                                                           \
    VECTOR_ROWS(f, name, source), VECTOR_ROWS(f, name, first_pixel),                                                 \
    VECTOR_ROWS(f, name, column_step), VECTOR_ROWS(f, name, row_step),                                               \
    STEPS_ROW(f, name, "column_step", "zero", step_of_zero),                                                         \
    STEPS_ROW(f, name, "row_step", "singular", steps_parallel),                                                      \
    STEPS_ROW(f, name, "row_step", "nearly singular", steps_nearly_parallel),                                        \
    {f, name ".source", "on the detector", source_on_detector, NOTHING, INVALID, name ".source is [",                \
     "a point off the detector's plane"},                                                                            \
    {f, name ".source", "on the detector", source_on_first_pixel, NOTHING, INVALID, name ".source is [",             \
     "a point off the detector's plane"}

/* A C-arm's numbers. */
#define LENGTH_ROW(field, kind, number, value, valid)                                                                \
    {&pose_c_arm, #field, kind, NULL, PUT(field, double, number), INVALID, #field " is " value ";", valid}
#define LENGTH_ROWS(field, valid)                                                                                    \
    LENGTH_ROW(field, "negative", -1.0, "-1", valid), LENGTH_ROW(field, "NaN", NAN, "NaN", valid),                   \
    LENGTH_ROW(field, "+Inf", INFINITY, "inf", valid), LENGTH_ROW(field, "-Inf", -INFINITY, "-inf", valid),          \
    LENGTH_ROW(field, "huge", 1e300, "1e300", valid), LENGTH_ROW(field, "huge", 1.1e10, "11000000000", valid)
#define CENTRE_ROW(axis, kind, number, value)                                                                        \
    {&pose_c_arm, "centre", kind, NULL, PUT(to.centre[axis], double, number), INVALID, "centre is [", value}
static void detector_at_source(Given *g) {
    g->source_detector_mm = 1e-12;
    g->pixel_mm = 1e10;
}

static const Row geometry_rows[] = {
    POINTER_ROWS(&uniforms_cone, pose, poses, "8 bytes"),
    POSE_ROWS(&uniforms_cone, "pose"),
    {&uniforms_cone, "pose", "tiny", pixels_below_float32, NOTHING, INVALID,
     "pose in float32.modelViewProjectionMatrix column 0, row 0 is inf;", "finite numbers"},
    COUNT_ROWS(&uniforms_cone, "width", width, "32768 pixels", 32769),
    COUNT_ROWS(&uniforms_cone, "height", height, "32768 pixels", 32769),
    POINTER_ROWS(&uniforms_cone, uniforms, views, "16 bytes"),
    {&pose_c_arm, "centre", "NULL", NULL, POINT(centre, NULL), INVALID, "centre is NULL;", "a pointer to 3 values"},
    {&pose_c_arm, "centre", "misaligned", NULL, ASKEW(centre, centre), INVALID, "centre is 0x", "aligned to 8 bytes"},
    CENTRE_ROW(0, "NaN", NAN, "NaN"),
    CENTRE_ROW(1, "+Inf", INFINITY, ", inf, "),
    CENTRE_ROW(2, "-Inf", -INFINITY, ", -inf]; valid: −1e10 … 1e10 mm"),
    CENTRE_ROW(0, "huge", 1e11, "1e11"),
    LENGTH_ROW(angle_degrees, "NaN", NAN, "NaN", "a finite number"),
    LENGTH_ROW(angle_degrees, "+Inf", INFINITY, "inf", "a finite number"),
    LENGTH_ROW(angle_degrees, "-Inf", -INFINITY, "-inf", "a finite number"),
    LENGTH_ROWS(source_axis_mm, "0 … 1e10 mm"),
    LENGTH_ROWS(source_detector_mm, "1e-12 … 1e10 mm"),
    LENGTH_ROW(source_detector_mm, "zero", 0.0, "0", "1e-12 … 1e10 mm"),
    LENGTH_ROW(source_detector_mm, "tiny", 1e-13, "0.0000000000001", "1e-12 … 1e10 mm"),
    {&pose_c_arm, "pose", "on the detector", detector_at_source, NOTHING, INVALID, "pose.source is [",
     "a point off the detector's plane"},
    LENGTH_ROWS(pixel_mm, "1e-12 … 1e10 mm"),
    LENGTH_ROW(pixel_mm, "zero", 0.0, "0", "1e-12 … 1e10 mm"),
    LENGTH_ROW(pixel_mm, "tiny", 1e-300, "1e-300", "1e-12 … 1e10 mm"),
    COUNT_ROWS(&pose_c_arm, "width", width, "32768 pixels", 32769),
    COUNT_ROWS(&pose_c_arm, "height", height, "32768 pixels", 32769),
    POINTER_ROWS(&pose_c_arm, pose, poses, "8 bytes"),
};

#endif
