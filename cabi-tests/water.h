/* A small object for the programs: a water ball of 14 mm radius with a bone in it, 1 mm voxels, around the origin. */
#ifndef WATER_H
#define WATER_H

#include "check.h"

enum { N = 32, WIDTH = 24, HEIGHT = 20, PIXELS = WIDTH * HEIGHT };

static inline const int16_t *water_ball(void) {
    static int16_t hu[N * N * N];
    for (int i = 0; i < N * N * N; i++) {
        const double x = i % N - 15.5, y = i / N % N - 15.5, z = (double)(i / (N * N)) - 15.5;
        const double r2 = x * x + y * y + z * z;
        hu[i] = (int16_t)(r2 > 196.0 ? -1000 : (x - 5.0) * (x - 5.0) + y * y < 9.0 ? 900 : 0);
    }
    return hu;
}

static inline DrrVolumeDescriptor water_descriptor(void) {
    DrrVolumeDescriptor descriptor;
    drr_volume_descriptor_init(&descriptor);
    for (int axis = 0; axis < 3; axis++) {
        descriptor.dimensions[axis] = N;
        descriptor.index_to_world[12 + axis] = -15.5;
    }
    return descriptor;
}

static inline DrrScene water_scene(void) {
    DrrScene scene;
    drr_scene_init(&scene);
    scene.detector_width = WIDTH;
    scene.detector_height = HEIGHT;
    scene.effects |= DRR_EFFECT_BONE_PATH;
    return scene;
}

static inline DrrDetectorPose water_pose(double angle_degrees) {
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrDetectorPose pose;
    drr_pose_c_arm(centre, angle_degrees, 500.0, 800.0, 2.5, WIDTH, HEIGHT, &pose);
    return pose;
}

#endif
