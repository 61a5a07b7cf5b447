/* A long projection is cancelled by another thread; the projector is as good as before. */
#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>

#include "water.h"

enum { VIEWS = 6 };

/* What the progress function and the thread that cancels share. The function's own fields need no lock: the library
 * calls it once at a time. */
typedef struct {
    atomic_int begun, stop;
    int never_stops;
    double last;
    int calls, shrank, calls_after_false;
} Job;

static bool progress(void *user_data, double fraction) {
    Job *job = (Job *)user_data;
    job->calls_after_false += atomic_load(&job->stop) && !job->never_stops;
    job->shrank |= !(fraction >= job->last && fraction <= 1.0);
    job->last = fraction;
    if (++job->calls < 3 || job->never_stops) return true;
    atomic_store(&job->begun, 1);
    while (!atomic_load(&job->stop)) sched_yield();
    return false;
}

static void *stop(void *argument) {
    Job *job = (Job *)argument;
    while (!atomic_load(&job->begun)) sched_yield();
    atomic_store(&job->stop, 1);
    return NULL;
}

static float complete[VIEWS * PIXELS], image[VIEWS * PIXELS];
static double complete64[VIEWS * PIXELS], image64[VIEWS * PIXELS];

/* Projects into `image` or `image64`. */
static DrrStatus project(const DrrProjector *projector, int reference, DrrProgress function, Job *job) {
    DrrDetectorPose poses[VIEWS];
    for (int v = 0; v < VIEWS; v++) poses[v] = water_pose(60.0 * v);
    if (reference) {
        DrrReferenceOutputs outputs;
        drr_reference_outputs_init(&outputs);
        outputs.line_integral = image64;
        outputs.progress = function;
        outputs.progress_data = job;
        return drr_reference_project(projector, DRR_ALGORITHM_JOSEPH, poses, VIEWS, &outputs);
    }
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = image;
    outputs.progress = function;
    outputs.progress_data = job;
    return drr_projector_project_poses(projector, poses, VIEWS, &outputs);
}

static int cancel(const DrrProjector *projector, int reference) {
    OK(project(projector, reference, NULL, NULL));
    memcpy(complete, image, sizeof image);
    memcpy(complete64, image64, sizeof image64);

    Job cancelled = {0};
    memset(image, 0x42, sizeof image);
    memset(image64, 0x42, sizeof image64);
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, stop, &cancelled) == 0);
    const DrrStatus status = project(projector, reference, progress, &cancelled);
    CHECK(pthread_join(thread, NULL) == 0);
    CHECK(status == DRR_STATUS_CANCELLED);
    CHECK(strstr(drr_last_error_message(), "cancelled") != NULL);
    CHECK(cancelled.calls == 3 && cancelled.calls_after_false == 0);
    CHECK(cancelled.last > 0.0 && cancelled.last < 1.0 && !cancelled.shrank);
    for (size_t i = 0; i < sizeof image; i++) CHECK(((unsigned char *)image)[i] == 0x42);
    for (size_t i = 0; i < sizeof image64; i++) CHECK(((unsigned char *)image64)[i] == 0x42);

    Job whole = {.never_stops = 1};
    OK(project(projector, reference, progress, &whole));
    CHECK(whole.calls > 1 && whole.last == 1.0 && !whole.shrank);
    if (reference) CHECK(memcmp(image64, complete64, sizeof image64) == 0);
    else CHECK(memcmp(image, complete, sizeof image) == 0);
    return 0;
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrProjector *projector = NULL;
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = DRR_BACKEND_CPU; /* reports more often than a GPU */
    options.thread_count = 4;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    DrrScene scene = water_scene();
    scene.supersampling = 3;
    OK(drr_context_create(&options, &context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    OK(drr_projector_create(volume, &scene, &projector));
    CHECK(strcmp(drr_status_name(DRR_STATUS_CANCELLED), "DRR_STATUS_CANCELLED") == 0);
    if (cancel(projector, 0) || cancel(projector, 1)) return 1;
    OK(drr_projector_destroy(projector));
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
