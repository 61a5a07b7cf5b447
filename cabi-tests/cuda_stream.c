/* Projections into a CUDA stream: the images stay on the GPU and are those that a projection returns; a view's tables
 * are read there. Where there is no NVIDIA GPU there is nothing to do. */
#include <dlfcn.h>
#include <string.h>

#include "water.h"

enum { VIEWS = 11, MATERIALS = 4, ENERGIES = 136, LAYERS = 4 };
static const size_t planes[LAYERS] = {1, 1, MATERIALS, 1};

/* What is needed of NVIDIA's driver. */
typedef uint64_t Address;
static struct Driver {
    int (*retain)(void **context, int device), (*release)(int device);
    int (*push)(void *context), (*pop)(void **context);
    int (*create)(void **stream, unsigned flags), (*synchronize)(void *stream), (*destroy)(void *stream);
    int (*allocate)(Address *address, size_t size), (*give_back)(Address address);
    int (*up)(Address to, const void *from, size_t size, void *stream);
    int (*down)(void *to, Address from, size_t size);
} driver;

static int load(void) {
    static const char *const names[] = {
        "cuDevicePrimaryCtxRetain", "cuDevicePrimaryCtxRelease_v2", "cuCtxPushCurrent_v2", "cuCtxPopCurrent_v2",
        "cuStreamCreate",           "cuStreamSynchronize",          "cuStreamDestroy_v2",  "cuMemAlloc_v2",
        "cuMemFree_v2",             "cuMemcpyHtoDAsync_v2",         "cuMemcpyDtoH_v2",
    };
    void *library = dlopen("libcuda.so.1", RTLD_NOW);
    CHECK(library != NULL && sizeof driver == sizeof names);
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        void *function = dlsym(library, names[n]);
        CHECK(function != NULL);
        memcpy((char *)&driver + n * sizeof function, &function, sizeof function);
    }
    return 0;
}

/* A context's child, as a C program makes it. */
static int create(const DrrContext *context, const int16_t *hu, const DrrScene *scene, DrrProjector **projector) {
    const DrrVolumeDescriptor descriptor = water_descriptor();
    DrrVolume *volume = NULL;
    OK(drr_volume_create(context, &descriptor, hu, NULL, &volume));
    OK(drr_projector_create(volume, scene, projector));
    OK(drr_volume_destroy(volume));
    return 0;
}

static float projected[LAYERS][VIEWS * MATERIALS * PIXELS], encoded[LAYERS][VIEWS * MATERIALS * PIXELS];

/* More views than one launch takes, into a stream and into the default stream. */
static int images(const DrrProjector *projector, void *stream) {
    DrrDetectorPose poses[VIEWS];
    for (int v = 0; v < VIEWS; v++) poses[v] = water_pose(33.0 * v);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = projected[0];
    outputs.line_integral = projected[1];
    outputs.areal_density = projected[2];
    outputs.bone_path_mm = projected[3];
    OK(drr_projector_project_poses(projector, poses, VIEWS, &outputs));

    Address layers[LAYERS];
    for (int n = 0; n < LAYERS; n++) CHECK(driver.allocate(&layers[n], planes[n] * VIEWS * PIXELS * sizeof(float)) == 0);
    DrrDeviceOutputs places;
    OK(drr_device_outputs_init(&places));
    places.intensity = (void *)(uintptr_t)layers[0];
    places.line_integral = (void *)(uintptr_t)layers[1];
    places.areal_density = (void *)(uintptr_t)layers[2];
    places.bone_path_mm = (void *)(uintptr_t)layers[3];
    OK(drr_projector_encode_poses(projector, poses, VIEWS, stream, &places));
    CHECK(driver.synchronize(stream) == 0);
    for (int n = 0; n < LAYERS; n++) {
        const size_t size = planes[n] * VIEWS * PIXELS * sizeof(float);
        CHECK(driver.down(encoded[n], layers[n], size) == 0);
        CHECK(memcmp(encoded[n], projected[n], size) == 0);
    }
    places.intensity_texture = (void *)(uintptr_t)layers[0];
    CHECK(drr_projector_encode_poses(projector, poses, VIEWS, stream, &places) == DRR_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(drr_last_error_message(), "outputs.intensity_texture is not NULL; valid: NULL") != NULL);
    for (int n = 0; n < LAYERS; n++) CHECK(driver.give_back(layers[n]) == 0);
    return 0;
}

/* Tables given by address in a view are those of a scene made with them. */
static int tables(const DrrContext *context, const DrrProjector *plain, void *stream) {
    static float spectrum[ENERGIES];
    OK(drr_physics_spectrum("W80_2p5Al", 15.0, 1.0, ENERGIES, spectrum));
    DrrScene scene = water_scene();
    scene.spectrum = spectrum;
    DrrProjector *own = NULL;
    if (create(context, water_ball(), &scene, &own)) return 1;
    const DrrDetectorPose pose = water_pose(6.0);
    ProjectionUniforms view;
    OK(drr_uniforms_cone(&pose, WIDTH, HEIGHT, &view));
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = projected[0];
    OK(drr_projector_project(own, &view, 1, &outputs));
    OK(drr_projector_destroy(own));

    Address address;
    CHECK(driver.allocate(&address, sizeof spectrum) == 0);
    CHECK(driver.up(address, spectrum, sizeof spectrum, stream) == 0 && driver.synchronize(stream) == 0);
    outputs.line_integral = projected[1];
    view.spectrumLutAddress = address + 1;
    CHECK(drr_projector_project(plain, &view, 1, &outputs) == DRR_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(drr_last_error_message(), "spectrumLutAddress is 0x") != NULL);
    CHECK(strstr(drr_last_error_message(), "aligned to 4 bytes") != NULL);
    view.spectrumLutAddress = address;
    OK(drr_projector_project(plain, &view, 1, &outputs));
    CHECK(memcmp(projected[0], projected[1], sizeof(float) * PIXELS) == 0);
    CHECK(driver.give_back(address) == 0);
    return 0;
}

/* A volume without bone has a bone path too: of zeros, whatever was in the memory before. */
static int boneless(const DrrContext *context, void *stream) {
    static const int16_t water[N * N * N];
    const DrrScene scene = water_scene();
    const DrrDetectorPose pose = water_pose(6.0);
    DrrProjector *projector = NULL;
    if (create(context, water, &scene, &projector)) return 1;
    for (int i = 0; i < PIXELS; i++) encoded[0][i] = 1.0f;
    Address address;
    CHECK(driver.allocate(&address, PIXELS * sizeof(float)) == 0);
    CHECK(driver.up(address, encoded[0], PIXELS * sizeof(float), stream) == 0);
    DrrDeviceOutputs places;
    OK(drr_device_outputs_init(&places));
    places.bone_path_mm = (void *)(uintptr_t)address;
    OK(drr_projector_encode_poses(projector, &pose, 1, stream, &places));
    CHECK(driver.synchronize(stream) == 0);
    CHECK(driver.down(encoded[0], address, PIXELS * sizeof(float)) == 0);
    for (int i = 0; i < PIXELS; i++) CHECK(encoded[0][i] == 0.0f);
    CHECK(driver.give_back(address) == 0);
    OK(drr_projector_destroy(projector));
    return 0;
}

/* What is wrong with a GPU's index is said. */
static int indices(void) {
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = DRR_BACKEND_CUDA;
    options.device_index = 1000;
    DrrContext *context = NULL;
    CHECK(drr_context_create(&options, &context) == DRR_STATUS_INVALID_ARGUMENT);
    CHECK(strstr(drr_last_error_message(), "options.device_index is 1000; valid: 0 … ") != NULL);
    return 0;
}

int main(void) {
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = DRR_BACKEND_CUDA;
    DrrContext *context = NULL;
    const DrrStatus status = drr_context_create(&options, &context);
    if (status == DRR_STATUS_UNSUPPORTED) {
        printf("PASS without a GPU: %s\n", drr_last_error_message());
        return 0;
    }
    CHECK(status == DRR_STATUS_OK);
    const DrrScene scene = water_scene();
    DrrProjector *projector = NULL;
    void *device = NULL, *stream = NULL;
    if (load() || indices() || create(context, water_ball(), &scene, &projector)) return 1;
    CHECK(driver.retain(&device, 0) == 0 && driver.push(device) == 0 && driver.create(&stream, 1) == 0);
    if (images(projector, stream) || images(projector, NULL) || tables(context, projector, stream)) return 1;
    if (boneless(context, stream)) return 1;
    OK(drr_projector_destroy(projector));
    OK(drr_context_destroy(context));
    CHECK(driver.destroy(stream) == 0 && driver.pop(&device) == 0 && driver.release(0) == 0);
    printf("PASS in CUDA streams\n");
    return 0;
}
