/* From nothing to a stereo pair: a 120 kVp exposure of a water cube, 1 mm voxels, from -6 and +6 degrees.
 *
 *   cc -std=c11 -Iinclude minimal.c -ldrr -lm
 */
#include <stdio.h>

#include "DRR_Shared.h"

enum { N = 64, PIXELS = 128 };

static int16_t hu[N * N * N]; /* zeros: water */
static float images[2][PIXELS][PIXELS];

static int project(DrrContext **context, DrrVolume **volume, DrrProjector **projector) {
    DrrVolumeDescriptor descriptor;
    drr_volume_descriptor_init(&descriptor);
    for (int axis = 0; axis < 3; axis++) descriptor.dimensions[axis] = N;

    DrrScene scene;
    drr_scene_init(&scene); /* 120 kVp, ideal detector, air, lung, soft tissue and bone */
    scene.detector_width = scene.detector_height = PIXELS;

    const double centre[3] = {(N - 1) / 2.0, (N - 1) / 2.0, (N - 1) / 2.0};
    DrrDetectorPose pair[2];
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = &images[0][0][0];

    return drr_context_create(NULL, context) || drr_volume_create(*context, &descriptor, hu, NULL, volume) ||
           drr_projector_create(*volume, &scene, projector) ||
           drr_pose_c_arm(centre, -6.0, 1000.0, 1500.0, 1.0, PIXELS, PIXELS, &pair[0]) ||
           drr_pose_c_arm(centre, +6.0, 1000.0, 1500.0, 1.0, PIXELS, PIXELS, &pair[1]) ||
           drr_projector_project_poses(*projector, pair, 2, &outputs);
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrProjector *projector = NULL;
    const int failed = project(&context, &volume, &projector);
    if (failed) fprintf(stderr, "%s\n", drr_last_error_message());
    else printf("PASS beside the cube %.3f, behind it %.3f\n", images[0][0][0], images[0][PIXELS / 2][PIXELS / 2]);
    drr_projector_destroy(projector);
    drr_volume_destroy(volume);
    drr_context_destroy(context);
    return failed;
}
