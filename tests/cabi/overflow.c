/* Wrong on purpose: the image has one pixel too few. Shows that the sanitizer sees what the library writes. */
#include <stdlib.h>

#include "water.h"

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrProjector *projector = NULL;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const DrrScene scene = water_scene();
    OK(drr_context_create(NULL, &context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    OK(drr_projector_create(volume, &scene, &projector));
    const DrrDetectorPose pose = water_pose(0.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = (float *)malloc((PIXELS - 1) * sizeof(float));
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    free(outputs.intensity);
    return 0;
}
