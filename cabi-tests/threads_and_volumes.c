/* Eight threads share one projector while its parents are destroyed and other threads make and destroy contexts,
 * volumes and projectors: each image is, byte for byte, that of a single thread. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>

#include "water.h"

enum { PROJECTING = 8, MAKING = 3, ROUNDS = 4 };

typedef struct {
    DrrContext *context;
    DrrVolume *volume;
    DrrProjector *projector;
} Handles;

static const int16_t *voxels;
static float expected[PIXELS];
static atomic_int projecting;

static int make(uint32_t threads, Handles *made) {
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const DrrScene scene = water_scene();
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.thread_count = threads;
    OK(drr_context_create(&options, &made->context));
    OK(drr_volume_create(made->context, &descriptor, voxels, NULL, &made->volume));
    OK(drr_projector_create(made->volume, &scene, &made->projector));
    return 0;
}

static int project(const DrrProjector *projector, float *intensity) {
    const DrrDetectorPose pose = water_pose(6.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = intensity;
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    return 0;
}

static int rounds_of_projecting(const DrrProjector *projector) {
    float intensity[PIXELS];
    for (int round = 0; round < ROUNDS; round++) {
        memset(intensity, 0, sizeof intensity);
        atomic_fetch_add(&projecting, 1);
        if (project(projector, intensity)) return 1;
        CHECK(memcmp(intensity, expected, sizeof intensity) == 0);
    }
    return 0;
}

static int rounds_of_making(void) {
    for (uint32_t round = 0; round < ROUNDS; round++) {
        Handles handles = {NULL, NULL, NULL};
        float intensity[PIXELS];
        if (make(1 + round, &handles)) return 1;
        OK(drr_context_destroy(handles.context));
        if (project(handles.projector, intensity)) return 1;
        OK(drr_volume_destroy(handles.volume));
        OK(drr_projector_destroy(handles.projector));
        CHECK(memcmp(intensity, expected, sizeof intensity) == 0);
    }
    return 0;
}

/* What a thread returns when something was not so. */
static char failed;

static void *run_projecting(void *projector) {
    return rounds_of_projecting((const DrrProjector *)projector) ? &failed : NULL;
}

static void *run_making(void *unused) {
    (void)unused;
    return rounds_of_making() ? &failed : NULL;
}

int main(void) {
    Handles alone = {NULL, NULL, NULL}, shared = {NULL, NULL, NULL};
    voxels = water_ball(); /* which writes them anew each time */
    if (make(1, &alone) || project(alone.projector, expected) || make(4, &shared)) return 1;
    OK(drr_projector_destroy(alone.projector));
    OK(drr_volume_destroy(alone.volume));
    OK(drr_context_destroy(alone.context));

    pthread_t threads[PROJECTING + MAKING];
    for (int t = 0; t < PROJECTING; t++)
        CHECK(pthread_create(&threads[t], NULL, run_projecting, shared.projector) == 0);
    for (int t = PROJECTING; t < PROJECTING + MAKING; t++)
        CHECK(pthread_create(&threads[t], NULL, run_making, NULL) == 0);
    while (atomic_load(&projecting) < PROJECTING) sched_yield(); /* then eight rounds have begun */
    OK(drr_context_destroy(shared.context));
    OK(drr_volume_destroy(shared.volume));
    for (int t = 0; t < PROJECTING + MAKING; t++) {
        void *result;
        CHECK(pthread_join(threads[t], &result) == 0);
        CHECK(result == NULL);
    }
    OK(drr_projector_destroy(shared.projector));
    printf("PASS\n");
    return 0;
}
