/* Bad values of every argument of every function: a status, a message that names argument, value and what is valid,
 * nothing written, and a library that goes on working. */
#include "context_rows.h"
#include "effect_rows.h"
#include "exposure_rows.h"
#include "parallel_rows.h"
#include "pose_gradient_rows.h"
#include "projection_rows.h"
#include "ray_transform_rows.h"
#include "raycast_rows.h"
#include "scene_rows.h"
#include "table_rows.h"
#include "view_rows.h"
#include "volume_rows.h"

/* Functions that cannot fail. */
static int infallible(void) {
    CHECK(drr_last_error_message()[0] == '\0');
    CHECK(strcmp(drr_status_name(DRR_STATUS_UNSUPPORTED), "DRR_STATUS_UNSUPPORTED") == 0);
    CHECK(strcmp(drr_status_name(DRR_STATUS_FILE), "DRR_STATUS_FILE") == 0);
    CHECK(strcmp(drr_status_name(DRR_STATUS_FILE + 1), "unknown status") == 0);
    CHECK(strcmp(drr_status_name(UINT32_MAX), "unknown status") == 0);
    CHECK(drr_version_number() == 10000 * DRR_VERSION_MAJOR + 100 * DRR_VERSION_MINOR + DRR_VERSION_PATCH);
    CHECK(drr_version()[0] != '\0');
    return 0;
}

int main(void) {
    if (infallible() || create_live_handles() || create_live_parallel()) return 1;
    if (create_live_transforms() || create_live_pose_gradients() || create_live_raycast()) return 1;
    const float *line_integrals = given.to.images[1];
    float first[IMAGES];
    good(&given);
    OK(call_project_poses(&given));
    memcpy(first, line_integrals, sizeof first);
    CHECK(first[0] > 0.0f);

    if (RUN(context_rows) || RUN(volume_rows) || RUN(scene_rows)) return 1;
    if (RUN_FOR(&projector_create, scene_field_rows) || RUN_FOR(&projector_create, effect_field_rows)) return 1;
    make_ready = expose_scene;
    clear_away = destroy_exposed;
    if (RUN_FOR(&exposure_develop_scene, scene_field_rows)) return 1;
    if (RUN_FOR(&exposure_develop_scene, effect_field_rows)) return 1;
    make_ready = NULL;
    clear_away = NULL;
    if (RUN(exposure_rows) || RUN(parallel_rows) || RUN(ray_transform_rows) || RUN(pose_gradient_rows)) return 1;
    if (RUN_FOR(&pose_gradient_plan, scene_field_rows) || RUN_FOR(&pose_gradient_plan_f64, scene_field_rows)) return 1;
    if (RUN_FOR(&pose_gradient_plan, effect_field_rows) || RUN_FOR(&pose_gradient_plan_f64, effect_field_rows)) return 1;
    if (RUN(raycast_rows) || RUN(geometry_rows) || RUN(projection_rows) || RUN(table_rows)) return 1;

    good(&given);
    OK(call_project_poses(&given));
    CHECK(memcmp(first, line_integrals, sizeof first) == 0);
    CHECK(strstr(drr_last_error_message(), "factors") != NULL); /* success leaves the last message alone */
    if (destroy_live_raycast() || destroy_live_pose_gradients() || destroy_live_transforms() || destroy_live_parallel()) return 1;
    if (destroy_live_handles()) return 1;
    printf("PASS\n");
    return 0;
}
