/* A CT that is loaded from a file is the volume of its voxels, and lies where the file says. */
#include "nifti.h"
#include "water.h"

/* The projection of a volume, which is given up. */
static int project(DrrVolume *volume, float *line_integral) {
    const DrrScene scene = water_scene();
    const DrrDetectorPose pose = water_pose(6.0);
    DrrProjector *projector = NULL;
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = line_integral;
    OK(drr_projector_create(volume, &scene, &projector));
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    OK(drr_projector_destroy(projector));
    OK(drr_volume_destroy(volume));
    return 0;
}

/* Whether a path is refused with a file's status, by its name, and with nothing written. */
static int refused(const DrrContext *context, const char *path, const char *why) {
    DrrVolumeDescriptor descriptor, before;
    drr_volume_descriptor_init(&descriptor);
    before = descriptor;
    DrrVolume *volume = NULL;
    CHECK(drr_volume_load(context, path, &descriptor, &volume) == DRR_STATUS_FILE);
    CHECK(volume == NULL && memcmp(&descriptor, &before, sizeof before) == 0);
    const char *message = drr_last_error_message();
    CHECK(strncmp(message, path, strlen(path)) == 0 && strstr(message, why) != NULL);
    return 0;
}

static int loads(const DrrContext *context, const char *path) {
    /* Sheared and mirrored, all entries exact in float32. */
    DrrVolumeDescriptor given = water_descriptor(), loaded;
    given.index_to_world[0] = -0.75;
    given.index_to_world[8] = 0.25;
    given.index_to_world[12] = 11.5;
    const size_t bytes = sizeof(int16_t) * N * N * N;
    CHECK(write_nifti(path, &given, water_ball(), bytes) == 0);

    DrrVolume *volume = NULL;
    drr_volume_descriptor_init(&loaded);
    const DrrStatus status = drr_volume_load(context, path, &loaded, &volume);
    if (status == DRR_STATUS_UNSUPPORTED) {
        CHECK(strstr(drr_last_error_message(), "formats") != NULL && volume == NULL);
        return 0;
    }
    OK(status);
    CHECK(memcmp(&loaded, &given, sizeof given) == 0);
    static float of_file[PIXELS], of_memory[PIXELS], linear[PIXELS];
    CHECK(project(volume, of_file) == 0);
    OK(drr_volume_create(context, &given, water_ball(), NULL, &volume));
    CHECK(project(volume, of_memory) == 0);
    CHECK(memcmp(of_file, of_memory, sizeof of_file) == 0 && of_file[HEIGHT / 2 * WIDTH + WIDTH / 2] > 0.1f);

    /* Calibration and thresholds are the descriptor's: by a line through 0 HU bone is denser. */
    loaded.calibration = DRR_CALIBRATION_LINEAR;
    OK(drr_volume_load(context, path, &loaded, &volume));
    CHECK(project(volume, linear) == 0);
    float largest = 0.0f;
    for (int i = 0; i < PIXELS; i++) largest = linear[i] - of_file[i] > largest ? linear[i] - of_file[i] : largest;
    CHECK(largest > 0.01f);

    CHECK(write_nifti(path, &given, water_ball(), bytes - 1) == 0);
    CHECK(refused(context, path, "truncated") == 0);
    CHECK(remove(path) == 0);
    CHECK(refused(context, path, "No such file") == 0);
    CHECK(refused(context, "chest.jpeg", "unknown format") == 0);
    return 0;
}

int main(void) {
    DrrContext *context = NULL;
    OK(create_cpu_context(&context));
    const int failed = loads(context, nifti_path());
    remove(nifti_path());
    OK(drr_context_destroy(context));
    if (!failed) printf("PASS\n");
    return failed;
}
