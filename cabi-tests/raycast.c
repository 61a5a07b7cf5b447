/* Where rays enter a volume and leave what is in it: a camera's five rays, a list, and all rays of a view, which are computed
 * again only when something changes.
 *
 *   cc -std=c11 -Iinclude -Icabi-tests cabi-tests/raycast.c -ldrr -lm
 */
#include <math.h>
#include <string.h>

#include "check.h"

/* A box of 40 mm in voxels of 1 mm about the origin; bone in one block of 8 voxels: from 4 to 12 mm along each axis. */
enum { N = 40, VOXELS = N * N * N, FIRST = 24, SIDE = 8, PIXELS = 21 };

static int16_t hu[VOXELS];

static int close_to(double value, double expected) { return fabs(value - expected) < 1e-12 * (1.0 + fabs(expected)); }

static int make(DrrContext **context, DrrVolume **volume) {
    DrrVolumeDescriptor descriptor;
    OK(create_cpu_context(context));
    OK(drr_volume_descriptor_init(&descriptor));
    for (int axis = 0; axis < 3; axis++) {
        descriptor.dimensions[axis] = N;
        descriptor.index_to_world[12 + axis] = -0.5 * (N - 1);
    }
    for (int n = 0; n < VOXELS; n++) hu[n] = -2000; /* padding: vacuum */
    for (int k = 0; k < SIDE; k++) {
        for (int j = 0; j < SIDE; j++) {
            for (int i = 0; i < SIDE; i++) hu[((FIRST + k) * N + FIRST + j) * N + FIRST + i] = 1000;
        }
    }
    OK(drr_volume_create(*context, &descriptor, hu, NULL, volume));
    return 0;
}

/* From 40 mm before the box's centre along +y, its picture as wide as half its height: at a distance t it is t high. */
static int camera_rays(DrrRaycast *raycast) {
    const double side = sqrt(0.25 * 0.25 + 1.0 + 0.5 * 0.5); /* of a corner's ray, per mm along y */
    DrrCamera camera;
    OK(drr_camera_init(&camera));
    camera.position[1] = -40.0;
    const double forward[3] = {0.0, 5.0, 0.0}, up[3] = {0.0, 0.0, 1.0};
    memcpy(camera.forward, forward, sizeof forward);
    memcpy(camera.up, up, sizeof up);
    camera.vertical_field_of_view_degrees = 2.0 * atan(0.5) * 180.0 / acos(-1.0);
    camera.aspect = 0.5;
    DrrRaySample samples[DRR_CAMERA_RAYS];
    OK(drr_raycast_cast_camera(raycast, &camera, samples));
    /* The centre enters after 20 mm and leaves after 60; in dataset space the camera is 20 mm from either side's face. */
    CHECK(samples[0].hit && samples[0].entry_mm == 20.0 && samples[0].exit_mm == 60.0);
    CHECK(samples[0].origin[0] == 20.0 && samples[0].origin[1] == -20.0 && samples[0].origin[2] == 20.0);
    /* Corners: top left, top right, bottom left, bottom right. They enter with the centre and leave by the top or the
     * bottom, 20 mm from the middle, which is 40 mm along y. */
    const double x[5] = {0.0, -0.25, 0.25, -0.25, 0.25}, z[5] = {0.0, 0.5, 0.5, -0.5, -0.5};
    for (int n = 1; n < DRR_CAMERA_RAYS; n++) {
        CHECK(samples[n].hit);
        CHECK(close_to(samples[n].direction[0], x[n] / side) && close_to(samples[n].direction[2], z[n] / side));
        CHECK(close_to(samples[n].world_entry_mm, 20.0 * side) && close_to(samples[n].world_exit_mm, 40.0 * side));
    }
    return 0;
}

/* A list keeps its order, also of rays that miss; one that starts inside enters at 0. */
static int list(DrrRaycast *raycast) {
    const DrrWorldRay rays[4] = {{{30.0, 0.0, 0.0}, {0.0, 1.0, 0.0}},
                                 {{0.0, 0.0, 0.0}, {0.0, 0.0, -2.0}},
                                 {{0.0, 50.0, 0.0}, {0.0, 1.0, 0.0}},
                                 {{-30.0, -30.0, 0.0}, {3.0, 3.0, -0.0}}};
    DrrRaySample samples[4];
    OK(drr_raycast_cast(raycast, rays, 4, samples));
    CHECK(!samples[0].hit && samples[0].exit_mm == 0.0);
    CHECK(samples[1].hit && samples[1].entry_mm == 0.0 && samples[1].exit_mm == 20.0);
    CHECK(!samples[2].hit);
    CHECK(samples[3].hit && close_to(samples[3].entry_mm, 10.0 * sqrt(2.0)));
    CHECK(close_to(samples[3].world_exit_mm, 50.0 * sqrt(2.0)));
    return 0;
}

static int counts(DrrRaycast *raycast, uint64_t views, size_t rays) {
    DrrRaycastStatistics statistics;
    OK(drr_raycast_statistics_init(&statistics));
    OK(drr_raycast_statistics(raycast, &statistics));
    CHECK(statistics.views_computed == views && statistics.rays == rays);
    return 0;
}

/* Seen along +y from 100 mm before the middle, in pixels of 2 mm there. */
static int view(DrrRaycast *raycast) {
    static DrrRaySpan spans[PIXELS * PIXELS], again[PIXELS * PIXELS];
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrDetectorPose pose;
    ProjectionUniforms uniforms;
    DrrMatter matter;
    OK(drr_pose_c_arm(centre, 0.0, 100.0, 200.0, 4.0, PIXELS, PIXELS, &pose));
    OK(drr_matter_init(&matter));
    OK(drr_raycast_update_pose(raycast, &pose, PIXELS, PIXELS, &matter, spans));
    /* The middle ray passes the block by; the one of 4 columns and rows further on runs through it, 8 mm from the middle at
     * the middle. Along y the block is 104 to 112 mm from the source; spans begin up to 3 voxels early. */
    const int middle = PIXELS / 2 * PIXELS + PIXELS / 2, through = middle + 4 * PIXELS + 4;
    const double slant = sqrt(1.0 + 2.0 * 0.08 * 0.08);
    CHECK(spans[middle].entry_mm == 0.0 && spans[middle].exit_mm == 0.0 && close_to(spans[middle].skipped_mm, 40.0));
    const double entry = spans[through].entry_mm / slant, exit = spans[through].exit_mm / slant;
    CHECK(entry <= 104.0 && entry >= 101.0 && exit >= 112.0 && exit <= 115.0);
    CHECK(close_to(spans[through].skipped_mm, slant * (40.0 - (exit - entry))));
    if (counts(raycast, 1, PIXELS * PIXELS)) return 1;

    OK(drr_raycast_update_pose(raycast, &pose, PIXELS, PIXELS, &matter, again));
    CHECK(memcmp(spans, again, sizeof spans) == 0);
    if (counts(raycast, 1, PIXELS * PIXELS)) return 1;
    OK(drr_uniforms_cone(&pose, PIXELS, PIXELS, &uniforms));
    OK(drr_raycast_update(raycast, &uniforms, PIXELS, PIXELS, &matter, again));
    CHECK(fabs(again[through].entry_mm - spans[through].entry_mm) < 1e-3); /* float32 */
    if (counts(raycast, 2, PIXELS * PIXELS)) return 1;

    /* Lung, label 1, is nowhere. */
    matter.labels = 1u << 1;
    OK(drr_raycast_update(raycast, &uniforms, PIXELS, PIXELS, &matter, again));
    for (int n = 0; n < PIXELS * PIXELS; n++) CHECK(again[n].exit_mm == 0.0);
    if (counts(raycast, 3, PIXELS * PIXELS)) return 1;

    /* What fails empties the cache, and writes nothing. */
    memcpy(again, spans, sizeof spans);
    matter.floor = -1.0;
    CHECK(drr_raycast_update(raycast, &uniforms, PIXELS, PIXELS, &matter, again) == DRR_STATUS_INVALID_ARGUMENT);
    CHECK(memcmp(spans, again, sizeof spans) == 0);
    return counts(raycast, 3, 0);
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrRaycast *raycast = NULL;
    if (make(&context, &volume)) return 1;
    OK(drr_raycast_create(volume, &raycast));
    OK(drr_volume_destroy(volume)); /* the cache keeps it */
    OK(drr_context_destroy(context));
    if (camera_rays(raycast) || list(raycast) || view(raycast)) return 1;
    OK(drr_raycast_destroy(raycast));
    printf("PASS\n");
    return 0;
}
