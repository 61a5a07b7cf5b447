/* Bad input of every kind: a status, a message that names the argument, and nothing written. */
#include <math.h>
#include <string.h>

#include "water.h"

/* The call is refused with this status, and the message has this text in it. */
#define REFUSED(call, status, text)                                       \
    do {                                                                  \
        CHECK((call) == (status));                                        \
        CHECK(strstr(drr_last_error_message(), (text)) != NULL);          \
    } while (0)
#define INVALID(call, text) REFUSED(call, DRR_STATUS_INVALID_ARGUMENT, text)
#define WITH(type, base, change, call, text) \
    do {                                     \
        type given = (base);                 \
        given.change;                        \
        INVALID(call, text);                 \
    } while (0)

static int refused_volumes(const DrrContext *context) {
    const DrrVolumeDescriptor good = water_descriptor();
    const int16_t *hu = water_ball();
    DrrVolume *volume = NULL;
#define VOLUME(change, text) \
    WITH(DrrVolumeDescriptor, good, change, drr_volume_create(context, &given, hu, NULL, &volume), text)
    VOLUME(struct_size = 0, "struct_size");
    VOLUME(struct_size = sizeof given + 8, "struct_size");
    VOLUME(dimensions[1] = 0, "dimensions[1] is 0");
    VOLUME(dimensions[2] = (size_t)-1, "dimensions[2]");
    VOLUME(dimensions[0] = 32769, "32768");
    VOLUME(index_to_world[5] = NAN, "index_to_world");
    VOLUME(index_to_world[12] = INFINITY, "index_to_world");
    VOLUME(index_to_world[5] = 0.0, "singular");
    VOLUME(index_to_world[3] = 1e-9, "last row");
    VOLUME(index_to_world[15] = 0.0, "last row");
    VOLUME(calibration = 99, "calibration is 99");
    VOLUME(thresholds = 99, "thresholds is 99");
    INVALID(drr_volume_create(NULL, &good, hu, NULL, &volume), "context is NULL");
    INVALID(drr_volume_create(context, NULL, hu, NULL, &volume), "descriptor is NULL");
    INVALID(drr_volume_create(context, &good, NULL, NULL, &volume), "hu is NULL");
    INVALID(drr_volume_create(context, &good, hu, NULL, NULL), "volume is NULL");
    const int16_t *odd = (const int16_t *)(const void *)((const char *)hu + 1);
    INVALID(drr_volume_create(context, &good, odd, NULL, &volume), "aligned");
    static uint8_t labels[N * N * N];
    labels[1] = 8;
    INVALID(drr_volume_create(context, &good, hu, labels, &volume), "label at voxel [1, 0, 0] is 8");
    static float values[N * N * N];
    values[N] = NAN;
    INVALID(drr_volume_create_float32(context, &good, values, NULL, &volume), "hu at voxel [0, 1, 0] is NaN");
    CHECK(volume == NULL);
    return 0;
}

static int refused_scenes(const DrrVolume *volume) {
    const DrrScene good = water_scene();
    static float table[136];
    DrrProjector *projector = NULL;
#define SCENE(change, text) WITH(DrrScene, good, change, drr_projector_create(volume, &given, &projector), text)
    SCENE(struct_size = 4, "struct_size");
    SCENE(detector_width = 0, "detector_width is 0");
    SCENE(detector_height = (size_t)1 << 40, "detector_height");
    SCENE(effects = 1u << 31, "effects is 0x80000000");
    SCENE(algorithm = 17, "algorithm is 17");
    SCENE(supersampling = 0, "supersampling is 0");
    SCENE(supersampling = 0xffffffffu, "supersampling");
    SCENE(bone_material = 4, "bone_material is 4");
    SCENE(bone_material = 259, "bone_material is 259");
    SCENE(material_count = 3, "material_count is 3");
    SCENE(energy_count = 0, "count is 0");
    SCENE(energy_count = (size_t)-1, "count");
    SCENE(first_energy_kev = NAN, "first_kev is NaN");
    SCENE(energy_step_kev = 0.5, "15.5 keV");
    SCENE(spectrum = table, "sum of the spectrum is 0");
    SCENE(detector_response = table, "sum of the spectrum is 0");
    DrrScene own = good;
    own.mass_attenuation = table;
    own.material_count = (size_t)-1;
    INVALID(drr_projector_create(volume, &own, &projector), "material_count");
    own.material_count = 1; /* the volume has bone, label 3 */
    own.effects = DRR_EFFECT_POLYENERGETIC;
    INVALID(drr_projector_create(volume, &own, &projector), "material_count is 1");
    table[7] = -1.0f;
    INVALID(drr_projector_create(volume, &own, &projector), "mass_attenuation[0][7] is -1");
    SCENE(spectrum = table, "spectrum[7] is -1");
    DrrScene mono = good;
    mono.effects = 0;
    mono.mono_energy_kev = 70.5;
    INVALID(drr_projector_create(volume, &mono, &projector), "mono_energy_kev is 70.5");
    DrrScene march = good;
    march.algorithm = DRR_ALGORITHM_MARCH;
    march.step_voxels = 0.0;
    INVALID(drr_projector_create(volume, &march, &projector), "step_voxels is 0");
    DrrScene exact = good;
    exact.algorithm = DRR_ALGORITHM_EXACT;
    REFUSED(drr_projector_create(volume, &exact, &projector), DRR_STATUS_UNSUPPORTED, "reference");
    INVALID(drr_projector_create(NULL, &good, &projector), "volume is NULL");
    INVALID(drr_projector_create(volume, NULL, &projector), "scene is NULL");
    INVALID(drr_projector_create(volume, &good, NULL), "projector is NULL");
    CHECK(projector == NULL);
    return 0;
}

static int refused_projections(const DrrVolume *volume) {
    DrrScene scene = water_scene();
    scene.effects = DRR_EFFECT_POLYENERGETIC;
    DrrProjector *projector = NULL;
    OK(drr_projector_create(volume, &scene, &projector));
    static float intensity[PIXELS];
    for (int i = 0; i < PIXELS; i++) intensity[i] = 42.0f;
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    const DrrDetectorPose good = water_pose(0.0);
    INVALID(drr_projector_project_poses(projector, &good, 1, &outputs), "at least one image");
    outputs.intensity = intensity;
    INVALID(drr_projector_project_poses(NULL, &good, 1, &outputs), "projector is NULL");
    INVALID(drr_projector_project_poses(projector, NULL, 1, &outputs), "poses is NULL");
    INVALID(drr_projector_project_poses(projector, &good, 0, &outputs), "view_count is 0");
    INVALID(drr_projector_project_poses(projector, &good, (size_t)-1, &outputs), "view_count");
    INVALID(drr_projector_project_poses(projector, &good, 1, NULL), "outputs is NULL");
    /* A handle of another type. */
    const DrrProjector *foreign = (const DrrProjector *)(const void *)volume;
    INVALID(drr_projector_project_poses(foreign, &good, 1, &outputs), "no such handle");
    CHECK(drr_projector_describe(foreign) == NULL);

    DrrDetectorPose poses[2] = {good, good};
    poses[1].source[2] = NAN;
    INVALID(drr_projector_project_poses(projector, poses, 2, &outputs), "poses[1].source");
    poses[1] = good;
    memcpy(poses[1].row_step, poses[1].column_step, sizeof poses[1].row_step);
    INVALID(drr_projector_project_poses(projector, poses, 2, &outputs), "poses[1].column_step and row_step");

    ProjectionUniforms view, broken;
    OK(drr_uniforms_cone(&good, WIDTH, HEIGHT, &view));
    broken = view;
    memset(&broken.modelViewProjectionMatrix, 0xff, sizeof broken.modelViewProjectionMatrix);
    INVALID(drr_projector_project(projector, &broken, 1, &outputs), "views[0].modelViewProjectionMatrix");
    broken = view;
    broken.sourcePosition.x += 1.0f;
    INVALID(drr_projector_project(projector, &broken, 1, &outputs), "views[0].sourcePosition");
    broken = view;
    static float lut[137];
    broken.spectrumLutAddress = (DrrAddress)(uintptr_t)lut + 2;
    INVALID(drr_projector_project(projector, &broken, 1, &outputs), "aligned");
    broken.spectrumLutAddress = (DrrAddress)(uintptr_t)lut;
    INVALID(drr_projector_project(projector, &broken, 1, &outputs), "views[0].sum of the spectrum");
    const ProjectionUniforms *odd = (const ProjectionUniforms *)(const void *)((const char *)&view + 4);
    INVALID(drr_projector_project(projector, odd, 1, &outputs), "aligned to 16");

    outputs.bone_path_mm = intensity;
    INVALID(drr_projector_project(projector, &view, 1, &outputs), "DRR_EFFECT_BONE_PATH");
    for (int i = 0; i < PIXELS; i++) CHECK(intensity[i] == 42.0f);
    OK(drr_projector_destroy(projector));
    return 0;
}

static int refused_geometry_and_tables(void) {
    const double centre[3] = {0.0, 0.0, 0.0}, nowhere[3] = {0.0, NAN, 0.0};
    DrrDetectorPose pose;
    memset(&pose, 0, sizeof pose);
    ProjectionUniforms view;
    INVALID(drr_pose_c_arm(nowhere, 0.0, 1000.0, 1500.0, 1.0, 8, 8, &pose), "pose.");
    INVALID(drr_pose_c_arm(centre, INFINITY, 1000.0, 1500.0, 1.0, 8, 8, &pose), "angle_degrees");
    INVALID(drr_pose_c_arm(centre, 0.0, -1.0, 1500.0, 1.0, 8, 8, &pose), "source_axis_mm is -1");
    INVALID(drr_pose_c_arm(centre, 0.0, 1000.0, 0.0, 1.0, 8, 8, &pose), "source_detector_mm is 0");
    INVALID(drr_pose_c_arm(centre, 0.0, 1000.0, 1500.0, NAN, 8, 8, &pose), "pixel_mm is NaN");
    INVALID(drr_pose_c_arm(centre, 0.0, 1000.0, 1500.0, 1.0, 0, 8, &pose), "width is 0");
    INVALID(drr_pose_c_arm(NULL, 0.0, 1000.0, 1500.0, 1.0, 8, 8, &pose), "centre is NULL");
    INVALID(drr_uniforms_cone(&pose, 8, 8, &view), "column_step");
    INVALID(drr_uniforms_cone(NULL, 8, 8, &view), "pose is NULL");
    pose = water_pose(0.0);
    INVALID(drr_uniforms_cone(&pose, 8, 0, &view), "height is 0");
    INVALID(drr_uniforms_cone(&pose, 8, 8, NULL), "uniforms is NULL");
    float values[136] = {42.0f};
    INVALID(drr_physics_spectrum("W999", 15.0, 1.0, 136, values), "W120_2p5Al");
    INVALID(drr_physics_spectrum(NULL, 15.0, 1.0, 136, values), "name is NULL");
    INVALID(drr_physics_spectrum("\xff", 15.0, 1.0, 136, values), "UTF-8");
    INVALID(drr_physics_mass_attenuation("water", 15.5, 1.0, 100, values), "15.5 keV");
    INVALID(drr_physics_mass_attenuation("unobtainium", 15.0, 1.0, 136, values), "titanium");
    INVALID(drr_physics_detector("ideal", 15.0, 1.0, 0, values), "count is 0");
    INVALID(drr_physics_detector("ideal", 15.0, 1.0, 136, NULL), "factors is NULL");
    CHECK(values[0] == 42.0f);
    return 0;
}

int main(void) {
    CHECK(drr_last_error_message()[0] == '\0');
    CHECK(strcmp(drr_status_name(DRR_STATUS_UNSUPPORTED), "DRR_STATUS_UNSUPPORTED") == 0);
    CHECK(strcmp(drr_status_name(12345), "unknown status") == 0);
    CHECK(drr_version_number() == 10000 * DRR_VERSION_MAJOR + 100 * DRR_VERSION_MINOR + DRR_VERSION_PATCH);

    DrrContext *context = NULL;
    DrrContextOptions options;
    INVALID(drr_context_options_init(NULL), "options is NULL");
    OK(drr_context_options_init(&options));
    WITH(DrrContextOptions, options, backend = 1000, drr_context_create(&given, &context), "backend is 1000");
    WITH(DrrContextOptions, options, thread_count = 1025, drr_context_create(&given, &context), "threads is 1025");
    WITH(DrrContextOptions, options, struct_size = 1, drr_context_create(&given, &context), "struct_size is 1");
    INVALID(drr_context_create(&options, NULL), "context is NULL");
    CHECK(context == NULL);

    OK(drr_context_create(&options, &context));
    DrrVolume *volume = NULL;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    if (refused_volumes(context) || refused_scenes(volume) || refused_projections(volume)) return 1;
    if (refused_geometry_and_tables()) return 1;
    INVALID(drr_context_destroy((DrrContext *)(void *)volume), "no such handle");
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
