/* What the casting of rays refuses. */
#ifndef RAYCAST_ROWS_H
#define RAYCAST_ROWS_H

#include "projection_rows.h"

/* The second ray, and the second view, are the ones that are wrong. */
static void good_raycast(Given *g) {
    g->raycast = live.raycast;
    drr_camera_init(&g->to.camera);
    g->to.camera.position[2] = 64.0;
    g->camera = &g->to.camera;
    for (int n = 0; n < RAYS; n++) {
        for (int axis = 0; axis < 3; axis++) {
            g->to.rays[n].origin[axis] = 8.0 * n;
            g->to.rays[n].direction[axis] = axis == n ? -1.0 : 0.0;
        }
    }
    g->rays = g->to.rays;
    g->ray_count = RAYS;
    g->samples = g->to.samples;
    drr_matter_init(&g->to.matter);
    g->matter = &g->to.matter;
    g->uniforms = &g->to.views[1];
    g->spans = g->to.spans;
    drr_raycast_statistics_init(&g->to.statistics);
    g->statistics = &g->to.statistics;
}
static void raycast_place(Given *g) { g->raycast = &g->to.handle; }
static void no_raycast(Given *g) { g->raycast = NULL; }

static DrrStatus call_raycast_create(const Given *g) {
    return drr_raycast_create((const DrrVolume *)g->volume, (DrrRaycast **)g->raycast);
}
static void destroy_made_raycast(const Given *g) { drr_raycast_destroy((DrrRaycast *)g->to.handle); }
static DrrStatus call_raycast_destroy(const Given *g) { return drr_raycast_destroy((DrrRaycast *)g->raycast); }
static DrrStatus call_raycast_set_volume(const Given *g) {
    return drr_raycast_set_volume((DrrRaycast *)g->raycast, (const DrrVolume *)g->volume);
}
static DrrStatus call_camera_init(const Given *g) { return drr_camera_init((DrrCamera *)g->camera); }
static DrrStatus call_raycast_cast_camera(const Given *g) {
    return drr_raycast_cast_camera((DrrRaycast *)g->raycast, (const DrrCamera *)g->camera, (DrrRaySample *)g->samples);
}
static DrrStatus call_raycast_cast(const Given *g) {
    return drr_raycast_cast((DrrRaycast *)g->raycast, (const DrrWorldRay *)g->rays, g->ray_count,
                            (DrrRaySample *)g->samples);
}
static DrrStatus call_matter_init(const Given *g) { return drr_matter_init((DrrMatter *)g->matter); }
static DrrStatus call_raycast_update(const Given *g) {
    return drr_raycast_update((DrrRaycast *)g->raycast, (const ProjectionUniforms *)g->uniforms, g->width, g->height,
                              (const DrrMatter *)g->matter, (DrrRaySpan *)g->spans);
}
static DrrStatus call_raycast_update_pose(const Given *g) {
    return drr_raycast_update_pose((DrrRaycast *)g->raycast, (const DrrDetectorPose *)g->pose, g->width, g->height,
                                   (const DrrMatter *)g->matter, (DrrRaySpan *)g->spans);
}
static DrrStatus call_statistics_init(const Given *g) {
    return drr_raycast_statistics_init((DrrRaycastStatistics *)g->statistics);
}
static DrrStatus call_statistics(const Given *g) {
    return drr_raycast_statistics((DrrRaycast *)g->raycast, (DrrRaycastStatistics *)g->statistics);
}

static const Function raycast_create = {"drr_raycast_create", raycast_place, call_raycast_create, destroy_made_raycast},
                      raycast_destroy = {"drr_raycast_destroy", no_raycast, call_raycast_destroy, NULL},
                      raycast_set_volume = {"drr_raycast_set_volume", good_raycast, call_raycast_set_volume, NULL},
                      camera_init = {"drr_camera_init", good_raycast, call_camera_init, NULL},
                      raycast_cast_camera = {"drr_raycast_cast_camera", good_raycast, call_raycast_cast_camera, NULL},
                      raycast_cast = {"drr_raycast_cast", good_raycast, call_raycast_cast, NULL},
                      matter_init = {"drr_matter_init", good_raycast, call_matter_init, NULL},
                      raycast_update = {"drr_raycast_update", good_raycast, call_raycast_update, NULL},
                      raycast_update_pose = {"drr_raycast_update_pose", good_raycast, call_raycast_update_pose, NULL},
                      statistics_init = {"drr_raycast_statistics_init", good_raycast, call_statistics_init, NULL},
                      statistics = {"drr_raycast_statistics", good_raycast, call_statistics, NULL};

static void raycast_askew(Given *g) { g->raycast = (char *)live.raycast + 1; }
static void raycast_foreign(Given *g) { g->raycast = live.volume; }
static void raycast_destroyed(Given *g) {
    DrrRaycast *raycast = NULL;
    drr_raycast_create(live.volume, &raycast);
    drr_raycast_destroy(raycast);
    g->raycast = raycast;
}
static void no_forward(Given *g) { memset(g->to.camera.forward, 0, sizeof g->to.camera.forward); }
static void up_along_forward(Given *g) {
    for (int axis = 0; axis < 3; axis++) g->to.camera.up[axis] = -3.0 * g->to.camera.forward[axis];
}
static void no_direction(Given *g) { memset(g->to.rays[1].direction, 0, sizeof g->to.rays[1].direction); }

#define RAYCAST_OWN_ROWS(f)                                                                                           \
    {f, "raycast", "misaligned", raycast_askew, NOTHING, INVALID, "raycast is 0x", "a DrrRaycast"},                   \
    {f, "raycast", "foreign", raycast_foreign, NOTHING, INVALID, "raycast is no such handle;",                        \
     "a DrrRaycast that has not been destroyed"},                                                                     \
    {f, "raycast", "destroyed", raycast_destroyed, NOTHING, INVALID, "raycast is ", "a DrrRaycast"}
#define RAYCAST_ROWS(f)                                                                                               \
    {f, "raycast", "NULL", NULL, POINT(raycast, NULL), INVALID, "raycast is NULL;", "a DrrRaycast"}, RAYCAST_OWN_ROWS(f)
#define VOLUME_HANDLE_ROWS(f)                                                                                         \
    {f, "volume", "NULL", NULL, POINT(volume, NULL), INVALID, "volume is NULL;", "a DrrVolume"},                      \
    {f, "volume", "misaligned", volume_askew, NOTHING, INVALID, "volume is 0x", "a DrrVolume"},                       \
    {f, "volume", "foreign", volume_foreign, NOTHING, INVALID, "volume is no such handle;", "a DrrVolume"},           \
    {f, "volume", "destroyed", volume_destroyed, NOTHING, INVALID, "volume is ", "a DrrVolume"}

#define VECTOR_ROW(f, name, member, axis, kind, number, value)                                                        \
    {f, name, kind, NULL, PUT(to.member[axis], double, number), INVALID, name " is [", value}
#define VECTOR_3_ROWS(f, name, member)                                                                                \
    VECTOR_ROW(f, name, member, 0, "NaN", NAN, "[NaN, "), VECTOR_ROW(f, name, member, 1, "+Inf", INFINITY, ", inf, "), \
    VECTOR_ROW(f, name, member, 2, "-Inf", -INFINITY, ", -inf]; valid: −1e10 … 1e10"),                                \
    VECTOR_ROW(f, name, member, 2, "huge", -1.1e10, ", -1.1e10]; valid: −1e10 … 1e10")
#define SCALAR_ROW(f, name, member, kind, number, value, valid)                                                       \
    {f, name, kind, NULL, PUT(to.member, double, number), INVALID, name " is " value ";", valid}
#define SCALAR_ROWS(f, name, member, valid)                                                                           \
    SCALAR_ROW(f, name, member, "NaN", NAN, "NaN", valid), SCALAR_ROW(f, name, member, "+Inf", INFINITY, "inf", valid), \
    SCALAR_ROW(f, name, member, "-Inf", -INFINITY, "-inf", valid),                                                    \
    SCALAR_ROW(f, name, member, "huge", 1e300, "1e300", valid)

#define VIEW_UPDATE_ROWS(f)                                                                                           \
    RAYCAST_ROWS(f), COUNT_ROWS(f, "width", width, "32768 pixels", 32769),                                            \
    COUNT_ROWS(f, "height", height, "32768 pixels", 32769),                                                           \
    POINTER_ROWS(f, matter, matter, "8 bytes"), STRUCT_SIZE_ROWS(f, "matter", matter, "24"),                          \
    SCALAR_ROWS(f, "matter.floor", matter.floor, "0 … 1000 g/cm³"),                                                   \
    SCALAR_ROW(f, "matter.floor", matter.floor, "negative", -0.5, "-0.5", "0 … 1000 g/cm³"),                          \
    {f, "matter.labels", "huge", NULL, PUT(to.matter.labels, uint32_t, 256), INVALID, "matter.labels is 256;",        \
     "0 … 255, a bit for each label"},                                                                                \
    POINTER_ROWS(f, spans, spans, "8 bytes")

static const Row raycast_rows[] = {
    VOLUME_HANDLE_ROWS(&raycast_create),
    POINTER_ROWS(&raycast_create, raycast, handle, "8 bytes"),
    RAYCAST_OWN_ROWS(&raycast_destroy),
    RAYCAST_ROWS(&raycast_set_volume),
    VOLUME_HANDLE_ROWS(&raycast_set_volume),

    POINTER_ROWS(&camera_init, camera, camera, "8 bytes"),
    RAYCAST_ROWS(&raycast_cast_camera),
    POINTER_ROWS(&raycast_cast_camera, camera, camera, "8 bytes"),
    STRUCT_SIZE_ROWS(&raycast_cast_camera, "camera", camera, "96"),
    VECTOR_3_ROWS(&raycast_cast_camera, "camera.position", camera.position),
    VECTOR_3_ROWS(&raycast_cast_camera, "camera.forward", camera.forward),
    {&raycast_cast_camera, "camera.forward", "zero", no_forward, NOTHING, INVALID, "camera.forward is [0e0, ",
     "not all 0"},
    VECTOR_3_ROWS(&raycast_cast_camera, "camera.up", camera.up),
    {&raycast_cast_camera, "camera.up", "singular", up_along_forward, NOTHING, INVALID, "camera.up is [",
     "not along forward: sine of the angle ≥ 1e-6"},
    SCALAR_ROWS(&raycast_cast_camera, "camera.vertical_field_of_view_degrees", camera.vertical_field_of_view_degrees,
                "above 0, below 180 degrees"),
    SCALAR_ROW(&raycast_cast_camera, "camera.vertical_field_of_view_degrees", camera.vertical_field_of_view_degrees,
               "zero", 0.0, "0", "above 0, below 180 degrees"),
    SCALAR_ROWS(&raycast_cast_camera, "camera.aspect", camera.aspect, "1e-6 … 1e6"),
    SCALAR_ROW(&raycast_cast_camera, "camera.aspect", camera.aspect, "zero", 0.0, "0", "1e-6 … 1e6"),
    {&raycast_cast_camera, "samples", "NULL", NULL, POINT(samples, NULL), INVALID, "samples is NULL;",
     "a pointer to 5 values"},
    {&raycast_cast_camera, "samples", "misaligned", NULL, ASKEW(samples, samples), INVALID, "samples is 0x",
     "aligned to 8 bytes"},

    RAYCAST_ROWS(&raycast_cast),
    POINTER_ROWS(&raycast_cast, rays, rays, "8 bytes"),
    VECTOR_3_ROWS(&raycast_cast, "rays[1].origin", rays[1].origin),
    VECTOR_3_ROWS(&raycast_cast, "rays[1].direction", rays[1].direction),
    {&raycast_cast, "rays[1].direction", "zero", no_direction, NOTHING, INVALID, "rays[1].direction is [0e0, ",
     "not all 0"},
    COUNT_ROWS(&raycast_cast, "ray_count", ray_count, "16777216", 16777217),
    POINTER_ROWS(&raycast_cast, samples, samples, "8 bytes"),

    POINTER_ROWS(&matter_init, matter, matter, "8 bytes"),
    VIEW_UPDATE_ROWS(&raycast_update),
    POINTER_ROWS(&raycast_update, uniforms, views, "16 bytes"),
    UNIFORMS_ROWS(&raycast_update, "uniforms"),
    VIEW_UPDATE_ROWS(&raycast_update_pose),
    POINTER_ROWS(&raycast_update_pose, pose, poses, "8 bytes"),
    POSE_ROWS(&raycast_update_pose, "pose"),

    POINTER_ROWS(&statistics_init, statistics, statistics, "8 bytes"),
    RAYCAST_ROWS(&statistics),
    POINTER_ROWS(&statistics, statistics, statistics, "8 bytes"),
    STRUCT_SIZE_ROWS(&statistics, "statistics", statistics, "64"),
};

static inline int create_live_raycast(void) {
    OK(drr_raycast_create(live.volume, &live.raycast));
    return 0;
}

static inline int destroy_live_raycast(void) {
    OK(drr_raycast_destroy(live.raycast));
    return 0;
}

#endif
