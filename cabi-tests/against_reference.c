/* How far the float32 engine is from its float64 twin, and its algorithm from the exact integral, on every image. */
#include <math.h>
#include <string.h>

#include "water.h"

enum { MATERIALS = 4, VIEWS = 2 };

/* Relative L2 distance of x from the truth. */
static double distance(const float *x, const double *truth, int count) {
    double difference = 0.0, size = 0.0;
    for (int i = 0; i < count; i++) {
        difference += pow(x[i] - truth[i], 2.0);
        size += pow(truth[i], 2.0);
    }
    return size > 0.0 ? sqrt(difference / size) : difference;
}

static float intensity[VIEWS * PIXELS], line[VIEWS * PIXELS], bone[VIEWS * PIXELS];
static float areal[VIEWS * MATERIALS * PIXELS];
static double intensity64[VIEWS * PIXELS], line64[VIEWS * PIXELS], bone64[VIEWS * PIXELS];
static double areal64[VIEWS * MATERIALS * PIXELS];

static int compare(const DrrVolume *volume, DrrAlgorithm algorithm, const char *name, double exact_tolerance) {
    DrrScene scene = water_scene();
    scene.algorithm = algorithm;
    DrrProjector *projector = NULL;
    OK(drr_projector_create(volume, &scene, &projector));
    const DrrDetectorPose pair[VIEWS] = {water_pose(-6.0), water_pose(6.0)};
    DrrOutputs fast;
    drr_outputs_init(&fast);
    fast.intensity = intensity;
    fast.line_integral = line;
    fast.areal_density = areal;
    fast.bone_path_mm = bone;
    OK(drr_projector_project_poses(projector, pair, VIEWS, &fast));
    DrrReferenceOutputs reference;
    drr_reference_outputs_init(&reference);
    reference.intensity = intensity64;
    reference.line_integral = line64;
    reference.areal_density = areal64;
    reference.bone_path_mm = bone64;
    OK(drr_reference_project(projector, algorithm, pair, VIEWS, &reference));
    const double twin = distance(line, line64, VIEWS * PIXELS);
    CHECK(twin <= 2e-6 && twin > 0.0);
    CHECK(distance(intensity, intensity64, VIEWS * PIXELS) <= 2e-6);
    CHECK(distance(areal, areal64, VIEWS * MATERIALS * PIXELS) <= 2e-6);
    CHECK(distance(bone, bone64, VIEWS * PIXELS) <= 2e-6);
    CHECK(bone64[HEIGHT / 2 * WIDTH + WIDTH / 2 + 3] > 1.0);

    OK(drr_reference_project(projector, DRR_ALGORITHM_EXACT, pair, VIEWS, &reference));
    const double exact = distance(line, line64, VIEWS * PIXELS);
    CHECK(exact <= exact_tolerance && exact > twin);
    printf("%s: twin %.1e, exact %.1e\n", name, twin, exact);
    OK(drr_projector_destroy(projector));
    return 0;
}

/* Tables given by address in a view are those of a scene made with them. */
static int compare_tables(const DrrVolume *volume) {
    static float spectrum[136], mu[MATERIALS * 136];
    static const char *const names[MATERIALS] = {"air", "lung", "water", "bone_cortical"};
    OK(drr_physics_spectrum("W80_2p5Al", 15.0, 1.0, 136, spectrum));
    for (int m = 0; m < MATERIALS; m++) OK(drr_physics_mass_attenuation(names[m], 15.0, 1.0, 136, &mu[m * 136]));
    DrrScene scene = water_scene();
    DrrProjector *plain = NULL, *own = NULL;
    OK(drr_projector_create(volume, &scene, &plain));
    scene.spectrum = spectrum;
    scene.mass_attenuation = mu;
    OK(drr_projector_create(volume, &scene, &own));
    const DrrDetectorPose pose = water_pose(6.0);
    ProjectionUniforms view;
    OK(drr_uniforms_cone(&pose, WIDTH, HEIGHT, &view));
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = line;
    OK(drr_projector_project(own, &view, 1, &outputs));
    outputs.line_integral = line + PIXELS;
    OK(drr_projector_project(plain, &view, 1, &outputs));
    CHECK(memcmp(line, line + PIXELS, sizeof(float) * PIXELS) != 0);
    view.spectrumLutAddress = (DrrAddress)(uintptr_t)spectrum;
    view.muLutAddress = (DrrAddress)(uintptr_t)mu;
    OK(drr_projector_project(plain, &view, 1, &outputs));
    CHECK(memcmp(line, line + PIXELS, sizeof(float) * PIXELS) == 0);
    OK(drr_projector_destroy(own));
    OK(drr_projector_destroy(plain));
    return 0;
}

/* One energy: I = exp(-sum of mu/rho x areal density), with I0 = 1. */
static int compare_one_energy(const DrrVolume *volume) {
    DrrScene scene = water_scene();
    scene.effects = 0;
    scene.mono_energy_kev = 60.0;
    DrrProjector *projector = NULL;
    OK(drr_projector_create(volume, &scene, &projector));
    static const char *const names[MATERIALS] = {"air", "lung", "soft_tissue", "bone_cortical"};
    float mu[MATERIALS];
    for (int m = 0; m < MATERIALS; m++) OK(drr_physics_mass_attenuation(names[m], 60.0, 1.0, 1, &mu[m]));
    const DrrDetectorPose pose = water_pose(6.0);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.intensity = intensity;
    outputs.areal_density = areal;
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    CHECK(intensity[0] == 1.0f);
    for (int i = 0; i < PIXELS; i++) {
        double p = 0.0;
        for (int m = 0; m < MATERIALS; m++) p += mu[m] * areal[m * PIXELS + i];
        CHECK(fabs(intensity[i] - exp(-p)) < 1e-6);
    }
    OK(drr_projector_destroy(projector));
    return 0;
}

int main(void) {
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    OK(create_cpu_context(&context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    const int failed = compare(volume, DRR_ALGORITHM_JOSEPH, "Joseph", 0.02) ||
                       compare(volume, DRR_ALGORITHM_MARCH, "march", 0.02) ||
                       compare(volume, DRR_ALGORITHM_SIDDON, "Siddon", 0.1) ||
                       compare(volume, DRR_ALGORITHM_DISTANCE_DRIVEN, "distance-driven", 0.1) ||
                       compare_tables(volume) || compare_one_energy(volume);
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    if (!failed) printf("PASS\n");
    return failed;
}
