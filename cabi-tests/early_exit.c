/* A ray along a water rod may stop early: the intensity changes by at most exp(-15) of I0, and other images not at
 * all. */
#include <math.h>
#include <string.h>

#include "water.h"

enum { MATERIALS = 4, LONG = 256, SIDE = 8 };

static float whole[PIXELS], stopped[PIXELS], lines[2][PIXELS];

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrProjector *projector = NULL;
    static const int16_t rod[SIDE * LONG * SIDE]; /* zeros: water */
    DrrVolumeDescriptor descriptor;
    drr_volume_descriptor_init(&descriptor);
    descriptor.dimensions[0] = descriptor.dimensions[2] = SIDE;
    descriptor.dimensions[1] = LONG;
    descriptor.index_to_world[12] = descriptor.index_to_world[14] = -(SIDE - 1) / 2.0;
    descriptor.index_to_world[13] = -(LONG - 1) / 2.0;
    OK(drr_context_create(NULL, &context));
    OK(drr_volume_create(context, &descriptor, rod, NULL, &volume));
    static float heavy[MATERIALS * 136];
    for (int i = 0; i < MATERIALS * 136; i++) heavy[i] = 2.0f; /* cm^2/g: exp(-51) along the rod */
    DrrScene scene = water_scene();
    scene.mass_attenuation = heavy;
    scene.algorithm = DRR_ALGORITHM_SIDDON; /* rays that are cast side by side, Joseph's, do not stop */
    OK(drr_projector_create(volume, &scene, &projector));

    const DrrDetectorPose pose = water_pose(0.0);
    ProjectionUniforms views[2];
    OK(drr_uniforms_cone(&pose, WIDTH, HEIGHT, &views[0]));
    views[1] = views[0];
    memset(&views[1].enableEarlyExit, 2, 1); /* not a C bool's byte, but not 0 */

    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = whole;
    OK(drr_projector_project(projector, &views[0], 1, &outputs));
    outputs.intensity = stopped;
    OK(drr_projector_project(projector, &views[1], 1, &outputs));
    CHECK(memcmp(whole, stopped, sizeof whole) != 0);
    for (int i = 0; i < PIXELS; i++) CHECK(fabs((double)whole[i] - stopped[i]) <= exp(-15.0) * whole[0]);

    outputs.intensity = NULL;
    outputs.line_integral = lines[0];
    OK(drr_projector_project(projector, views, 2, &outputs));
    CHECK(memcmp(lines[0], lines[1], sizeof lines[0]) == 0);
    CHECK(lines[0][HEIGHT / 2 * WIDTH + WIDTH / 2] > 30.0f);
    OK(drr_projector_destroy(projector));
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
