/* The best engine of this machine, a GPU's or not, projects what the reference projects; an engine that is not there
 * says what is missing. */
#include <math.h>
#include <string.h>

#include "water.h"

enum { VIEWS = 2, ALL = VIEWS * PIXELS, BACKENDS = 5 };

static const char *const names[BACKENDS] = {"auto", "cpu", "reference", "cuda", "metal"};

typedef struct {
    float intensity[ALL], line_integral[ALL], bone_path_mm[ALL];
} Images;

/* A context of one engine; untouched when the engine is not there. */
static DrrStatus create(DrrBackend backend, DrrContext **context) {
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = backend;
    return drr_context_create(&options, context);
}

static int project(const DrrContext *context, DrrProjector **projector, Images *images) {
    const DrrVolumeDescriptor descriptor = water_descriptor();
    const DrrScene scene = water_scene();
    const DrrDetectorPose pair[VIEWS] = {water_pose(-6.0), water_pose(6.0)};
    DrrVolume *volume = NULL;
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    OK(drr_projector_create(volume, &scene, projector));
    OK(drr_volume_destroy(volume));
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = images->intensity;
    outputs.line_integral = images->line_integral;
    outputs.bone_path_mm = images->bone_path_mm;
    OK(drr_projector_project_poses(*projector, pair, VIEWS, &outputs));
    return 0;
}

/* Relative L2 distance of x from the truth. */
static double distance(const float *x, const float *truth) {
    double difference = 0.0, size = 0.0;
    for (int i = 0; i < ALL; i++) {
        difference += pow((double)x[i] - truth[i], 2.0);
        size += pow(truth[i], 2.0);
    }
    return sqrt(difference / size);
}

/* Engines of the CPU have no queues. */
static int without_a_queue(const DrrProjector *projector) {
    static float image[PIXELS];
    const DrrDetectorPose pose = water_pose(6.0);
    DrrDeviceOutputs outputs;
    OK(drr_device_outputs_init(&outputs));
    outputs.intensity = image;
    CHECK(drr_projector_encode_poses(projector, &pose, 1, NULL, &outputs) == DRR_STATUS_UNSUPPORTED);
    CHECK(strstr(drr_last_error_message(), "queues") != NULL);
    /* Nor can they read what may lie at a GPU's addresses. */
    ProjectionUniforms view;
    OK(drr_uniforms_cone(&pose, WIDTH, HEIGHT, &view));
    view.spectrumLutAddress = 0x7f0000001000;
    CHECK(drr_projector_encode(projector, &view, 1, NULL, &outputs) == DRR_STATUS_UNSUPPORTED);
    for (int i = 0; i < PIXELS; i++) CHECK(image[i] == 0.0f);
    return 0;
}

/* Engines by name: there and used, or not there and said so. */
static int named(void) {
    for (DrrBackend backend = DRR_BACKEND_CPU; backend < BACKENDS; backend++) {
        DrrContext *context = NULL;
        const DrrStatus status = create(backend, &context);
        if (status == DRR_STATUS_UNSUPPORTED) {
            CHECK(backend == DRR_BACKEND_CUDA || backend == DRR_BACKEND_METAL);
            CHECK(context == NULL && strlen(drr_last_error_message()) > 10);
            printf("%s: %s\n", names[backend], drr_last_error_message());
            continue;
        }
        CHECK(status == DRR_STATUS_OK);
        DrrBackend found = DRR_BACKEND_AUTO;
        OK(drr_context_backend(context, &found));
        CHECK(found == backend);
        const char *const device = drr_context_device_name(context);
        CHECK(device != NULL && (device[0] != '\0') == (backend >= DRR_BACKEND_CUDA));
        OK(drr_context_destroy(context));
    }
    return 0;
}

int main(void) {
    static Images images, truth;
    DrrContext *best = NULL, *reference = NULL;
    DrrProjector *projector = NULL, *truthful = NULL;
    if (named()) return 1;
    OK(create(DRR_BACKEND_AUTO, &best));
    OK(create(DRR_BACKEND_REFERENCE, &reference));
    DrrBackend backend = DRR_BACKEND_AUTO;
    OK(drr_context_backend(best, &backend));
    CHECK(backend != DRR_BACKEND_AUTO && backend < BACKENDS);
    printf("best: %s %s\n", names[backend], drr_context_device_name(best));
    if (project(best, &projector, &images) || project(reference, &truthful, &truth)) return 1;
    const double distances[3] = {distance(images.intensity, truth.intensity),
                                 distance(images.line_integral, truth.line_integral),
                                 distance(images.bone_path_mm, truth.bone_path_mm)};
    for (int layer = 0; layer < 3; layer++) CHECK(distances[layer] <= 2e-6);
    printf("relative L2: %.1e %.1e %.1e\n", distances[0], distances[1], distances[2]);
    if (without_a_queue(truthful)) return 1;
    OK(drr_projector_destroy(truthful));
    OK(drr_projector_destroy(projector));
    OK(drr_context_destroy(reference));
    OK(drr_context_destroy(best));
    printf("PASS\n");
    return 0;
}
