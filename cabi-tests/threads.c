/* Eight threads share one projector and one exposure: each gets the same bytes, and its own error message. */
#include <pthread.h>
#include <string.h>

#include "water.h"

enum { THREADS = 8, ROUNDS = 3 };

typedef struct {
    const DrrProjector *projector;
    const DrrExposure *exposure;
    int index;
    float intensity[PIXELS], developed[PIXELS];
    int failed;
} Worker;

static void *work(void *argument) {
    Worker *worker = (Worker *)argument;
    const DrrDetectorPose pose = water_pose(-6.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = worker->intensity;
    worker->failed = drr_last_error_message()[0] != '\0';
    for (int round = 0; round < ROUNDS; round++) {
        worker->failed |= drr_projector_project_poses(worker->projector, &pose, 1, &outputs) != DRR_STATUS_OK;
        outputs.intensity = worker->developed;
        worker->failed |= drr_exposure_develop(worker->exposure, NULL, &outputs) != DRR_STATUS_OK;
        outputs.intensity = worker->intensity;
        float unused;
        char expected[32];
        snprintf(expected, sizeof expected, "count is %d;", 5000 + worker->index);
        drr_physics_detector("ideal", 15.0, 1.0, (size_t)(5000 + worker->index), &unused);
        worker->failed |= strstr(drr_last_error_message(), expected) == NULL;
    }
    return NULL;
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrProjector *projector = NULL;
    DrrExposure *exposure = NULL;
    const DrrDetectorPose pose = water_pose(-6.0);
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const DrrScene scene = water_scene();
    OK(drr_context_create(NULL, &context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    OK(drr_projector_create(volume, &scene, &projector));
    OK(drr_exposure_create_poses(projector, &pose, 1, NULL, NULL, &exposure));

    static Worker workers[THREADS];
    pthread_t threads[THREADS];
    for (int t = 0; t < THREADS; t++) {
        workers[t].projector = projector;
        workers[t].exposure = exposure;
        workers[t].index = t;
        CHECK(pthread_create(&threads[t], NULL, work, &workers[t]) == 0);
    }
    for (int t = 0; t < THREADS; t++) {
        CHECK(pthread_join(threads[t], NULL) == 0);
        CHECK(!workers[t].failed);
        CHECK(memcmp(workers[t].intensity, workers[0].intensity, sizeof workers[0].intensity) == 0);
        CHECK(memcmp(workers[t].developed, workers[0].developed, sizeof workers[0].developed) == 0);
    }
    CHECK(workers[0].intensity[0] > 0.0f && workers[0].developed[0] > 0.0f);
    CHECK(drr_last_error_message()[0] == '\0'); /* the failures were other threads' */
    OK(drr_exposure_destroy(exposure));
    OK(drr_projector_destroy(projector));
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
