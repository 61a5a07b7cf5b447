/* Who owns what: voxels and tables are copied, children keep parents alive, and handles go in any order. */
#include <stdlib.h>
#include <string.h>

#include "water.h"

int main(void) {
    OK(drr_context_destroy(NULL));
    OK(drr_volume_destroy(NULL));
    OK(drr_projector_destroy(NULL));
    OK(drr_exposure_destroy(NULL));
    OK(drr_raycast_destroy(NULL));

    DrrContext *context = NULL;
    OK(drr_context_create(NULL, &context));
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const size_t size = sizeof(int16_t) * N * N * N;
    int16_t *hu = (int16_t *)malloc(size);
    CHECK(hu != NULL);
    memcpy(hu, water_ball(), size);
    DrrVolume *volume = NULL;
    OK(drr_volume_create(context, &descriptor, hu, NULL, &volume));
    free(hu);
    OK(drr_context_destroy(context)); /* the parent first */

    float *spectrum = (float *)malloc(136 * sizeof(float));
    CHECK(spectrum != NULL);
    OK(drr_physics_spectrum("W80_2p5Al", 15.0, 1.0, 136, spectrum));
    DrrScene scene = water_scene();
    DrrProjector *first = NULL, *second = NULL;
    OK(drr_projector_create(volume, &scene, &first));
    scene.spectrum = spectrum;
    OK(drr_projector_create(volume, &scene, &second));
    memset(spectrum, 0, 136 * sizeof(float));
    free(spectrum);
    memset(&scene, 0, sizeof scene);
    OK(drr_volume_destroy(volume));

    static float soft[PIXELS], hard[PIXELS];
    const DrrDetectorPose pose = water_pose(6.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = hard;
    OK(drr_projector_project_poses(first, &pose, 1, &outputs));
    CHECK(strstr(drr_projector_describe(second), "\"stages\"") != NULL);
    OK(drr_projector_destroy(first));
    outputs.line_integral = soft;
    OK(drr_projector_project_poses(second, &pose, 1, &outputs));
    const int middle = HEIGHT / 2 * WIDTH + WIDTH / 2;
    CHECK(soft[middle] > 1.05f * hard[middle] && hard[middle] > 0.1f); /* 80 kVp is attenuated more than 120 */
    /* An exposure needs nothing that it was made from. */
    DrrExposure *exposure = NULL;
    OK(drr_exposure_create_poses(second, &pose, 1, NULL, NULL, &exposure));
    OK(drr_projector_destroy(second));
    static float developed[PIXELS];
    outputs.line_integral = developed;
    OK(drr_exposure_develop(exposure, NULL, &outputs));
    for (int i = 0; i < PIXELS; i++) CHECK(developed[i] > soft[i] - 1e-5f && developed[i] < soft[i] + 1e-5f);
    OK(drr_exposure_destroy(exposure));
    printf("PASS\n");
    return 0;
}
