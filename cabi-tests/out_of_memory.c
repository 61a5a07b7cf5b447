/* With too little memory for a big volume, big images or many views, the call says so, writes nothing, and the library
 * goes on. Linux only: elsewhere RLIMIT_AS is not enforced. Not for sanitizers, which reserve the address space. */
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "water.h"

#define REFUSED(call, text)                                       \
    do {                                                          \
        CHECK((call) == DRR_STATUS_OUT_OF_MEMORY);                \
        CHECK(strstr(drr_last_error_message(), (text)) != NULL);  \
    } while (0)

/* The voxels of LONG x SIDE x SIDE in float32, or the areal densities of 4 materials on BIGGER x BIGGER pixels. */
#define SIZE ((size_t)1 << 30)
#define MIB ((size_t)1 << 20)
enum { LONG = 1024, SIDE = 512, BIGGER = 8192, VIEWS = DRR_MAX_VIEWS };

/* Lets this process have `more` bytes of address space than it has. */
static int allow(size_t more) {
    unsigned long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    CHECK(file != NULL);
    CHECK(fscanf(file, "%lu", &pages) == 1);
    fclose(file);
    struct rlimit limit;
    CHECK(getrlimit(RLIMIT_AS, &limit) == 0);
    const rlim_t wanted = (rlim_t)pages * (rlim_t)sysconf(_SC_PAGESIZE) + (rlim_t)more;
    limit.rlim_cur = limit.rlim_max == RLIM_INFINITY || wanted < limit.rlim_max ? wanted : limit.rlim_max;
    CHECK(setrlimit(RLIMIT_AS, &limit) == 0);
    return 0;
}

static int refused_volumes(const DrrContext *context, const void *voxels) {
    DrrVolume *volume = NULL;
    DrrVolumeDescriptor descriptor = water_descriptor();
    descriptor.dimensions[0] = LONG;
    descriptor.dimensions[1] = descriptor.dimensions[2] = SIDE;
    REFUSED(drr_volume_create(context, &descriptor, (const int16_t *)voxels, NULL, &volume),
            "536870912 bytes for the volume");
    REFUSED(drr_volume_create_float32(context, &descriptor, (const float *)voxels, NULL, &volume),
            "1073741824 bytes for the volume's densities");
    CHECK(volume == NULL);
    return 0;
}

static int refused_images(const DrrVolume *volume, char *place) {
    DrrProjector *projector = NULL;
    DrrScene scene = water_scene();
    scene.detector_width = scene.detector_height = BIGGER;
    OK(drr_projector_create(volume, &scene, &projector));
    const DrrDetectorPose pose = water_pose(0.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.areal_density = (float *)(void *)place;
    REFUSED(drr_projector_project_poses(projector, &pose, 1, &outputs), "1073741824 bytes for the images");
    DrrReferenceOutputs twin;
    drr_reference_outputs_init(&twin);
    twin.intensity = (double *)(void *)place;
    REFUSED(drr_reference_project(projector, DRR_ALGORITHM_JOSEPH, &pose, 1, &twin),
            "536870912 bytes for the images");
    for (size_t i = 0; i < SIZE; i += 4096) CHECK(place[i] == 0);
    OK(drr_projector_destroy(projector));
    return 0;
}

static int refused_views(const DrrVolume *volume, char *place) {
    static DrrDetectorPose poses[VIEWS];
    DrrProjector *projector = NULL;
    DrrScene scene = water_scene();
    scene.detector_width = scene.detector_height = 1;
    OK(drr_projector_create(volume, &scene, &projector));
    for (int v = 0; v < VIEWS; v++) poses[v] = water_pose(0.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = (float *)(void *)place;
    /* Whichever of the call's lists it is that does not fit. */
    int refused = 0;
    for (size_t more = 2 * MIB;; more += 2 * MIB) {
        if (allow(more)) return 1;
        const DrrStatus status = drr_projector_project_poses(projector, poses, VIEWS, &outputs);
        if (status == DRR_STATUS_OK) break;
        REFUSED(status, "bytes for the ");
        CHECK(outputs.intensity[0] == 0.0f && outputs.intensity[VIEWS - 1] == 0.0f);
        refused++;
    }
    CHECK(refused > 4);
    CHECK(outputs.intensity[0] > 0.0f && outputs.intensity[VIEWS - 1] == outputs.intensity[0]);
    OK(drr_projector_destroy(projector));
    return 0;
}

/* Tables of 4096 energies: 170 MB if every view held its own, 160 KB when those at the same addresses are shared. */
static int shared_tables(const DrrVolume *volume, char *place) {
    enum { ENERGIES = 4096, MATERIALS = 4, WITH_TABLES = 1024 };
    static float spectrum[ENERGIES], mass_attenuation[MATERIALS * ENERGIES];
    static ProjectionUniforms views[WITH_TABLES];
    for (int k = 0; k < ENERGIES; k++) spectrum[k] = 1.0f;
    for (int i = 0; i < MATERIALS * ENERGIES; i++) mass_attenuation[i] = 0.2f;
    DrrScene scene = water_scene();
    scene.detector_width = scene.detector_height = 1;
    scene.energy_count = ENERGIES;
    scene.energy_step_kev = 0.03125;
    scene.spectrum = spectrum;
    scene.mass_attenuation = mass_attenuation;
    DrrProjector *projector = NULL;
    OK(drr_projector_create(volume, &scene, &projector));
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrDetectorPose pose;
    OK(drr_pose_c_arm(centre, 0.0, 500.0, 800.0, 1.0, 1, 1, &pose));
    for (int v = 0; v < WITH_TABLES; v++) {
        OK(drr_uniforms_cone(&pose, 1, 1, &views[v]));
        views[v].spectrumLutAddress = (DrrAddress)(uintptr_t)spectrum;
        views[v].muLutAddress = (DrrAddress)(uintptr_t)mass_attenuation;
    }
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = (float *)(void *)place;
    OK(drr_projector_project(projector, views, WITH_TABLES, &outputs));
    CHECK(outputs.line_integral[0] > 0.0f && outputs.line_integral[WITH_TABLES - 1] == outputs.line_integral[0]);
    OK(drr_projector_destroy(projector));
    return 0;
}

static int project(const DrrVolume *volume, float *intensity) {
    DrrProjector *projector = NULL;
    const DrrScene scene = water_scene();
    const DrrDetectorPose pose = water_pose(6.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = intensity;
    OK(drr_projector_create(volume, &scene, &projector));
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    OK(drr_projector_destroy(projector));
    return 0;
}

int main(void) {
#if !defined(__linux__)
    printf("PASS without having tested anything: this system does not enforce RLIMIT_AS\n");
    return 0;
#endif
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = DRR_BACKEND_CPU;
    options.thread_count = 2;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    static float before[PIXELS], after[PIXELS];
    OK(drr_context_create(&options, &context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    if (project(volume, before)) return 1;
    char *place = (char *)calloc(2, SIZE); /* zeros that nobody has touched take no memory */
    CHECK(place != NULL);

    if (allow(256 * MIB)) return 1;
    if (refused_volumes(context, place) || refused_images(volume, place)) return 1;
    /* The limit still holds. */
    if (project(volume, after)) return 1;
    CHECK(memcmp(before, after, sizeof before) == 0 && before[0] > 0.0f);
    if (refused_views(volume, place) || allow(64 * MIB) || shared_tables(volume, place)) return 1;
    OK(drr_volume_destroy(volume));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    memset(after, 0, sizeof after);
    if (project(volume, after)) return 1;
    CHECK(memcmp(before, after, sizeof before) == 0);
    free(place);
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
