/* An error is stated instead of a method: the plan says what was chosen and why, the images keep it over all rays, and the
 * certificate says so too. */
#include <math.h>
#include <string.h>

#include "water.h"

enum { VIEWS = 2, RAYS = VIEWS * PIXELS };

static DrrContext *context;
static DrrVolume *volume;
static DrrDetectorPose poses[VIEWS];

/* Root mean square of 1000 (p - exact) / exact where exact is above a twentieth of its largest. */
static double rmse_hu(const float *p, const double *exact) {
    double largest = 0.0, squares = 0.0;
    int rays = 0;
    for (int i = 0; i < RAYS; i++) largest = fmax(largest, exact[i]);
    for (int i = 0; i < RAYS; i++) {
        if (exact[i] <= largest / 20.0) continue;
        squares += pow(1000.0 * (p[i] - exact[i]) / exact[i], 2.0);
        rays++;
    }
    return sqrt(squares / rays);
}

static int keeps(const DrrScene *scene, double *rmse) {
    static float p[RAYS];
    static double exact[RAYS];
    DrrProjector *projector = NULL;
    OK(drr_projector_create(volume, scene, &projector));
    const char *plan = drr_projector_describe(projector);
    CHECK(plan != NULL && strstr(plan, "\"choice\"") != NULL && strstr(plan, "\"chosen\"") != NULL);
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    outputs.line_integral = p;
    OK(drr_projector_project_poses(projector, poses, VIEWS, &outputs));
    DrrReferenceOutputs truth;
    drr_reference_outputs_init(&truth);
    truth.line_integral = exact;
    OK(drr_reference_project(projector, DRR_ALGORITHM_EXACT, poses, VIEWS, &truth));
    *rmse = rmse_hu(p, exact);
    CHECK(*rmse <= scene->tolerance_hu);

    DrrCertificate certificate, again;
    drr_certificate_init(&certificate);
    CHECK(isnan(certificate.rmse_hu));
    drr_certificate_init(&again);
    OK(drr_projector_certify(projector, poses, VIEWS, &certificate));
    OK(drr_projector_certify(projector, poses, VIEWS, &again));
    CHECK(memcmp(&certificate, &again, sizeof again) == 0);
    /* So few rays are all looked at: nothing is left to estimate. */
    CHECK(certificate.rays == RAYS);
    CHECK(fabs(certificate.rmse_hu - *rmse) <= 1e-6 * *rmse && certificate.rmse_hu_bound == certificate.rmse_hu);
    CHECK(certificate.max_hu >= *rmse && certificate.relative_l2 > 0.0 && certificate.max_intensity > 0.0);
    CHECK(certificate.confidence > 0.9 && certificate.confidence < 1.0);
    OK(drr_projector_destroy(projector));
    return 0;
}

static int presets(void) {
    DrrScene scene = water_scene(), before = scene;
    OK(drr_scene_set_preset(&scene, "standard"));
    CHECK(scene.tolerance_hu == 2.0 && scene.tolerance_mm == 0.2);
    scene.tolerance_hu = scene.tolerance_mm = 0.0;
    CHECK(memcmp(&scene, &before, sizeof scene) == 0);
    return 0;
}

/* Few energies alone: the method is the scene's, and the images stay within the bound of those with all energies. */
static int few_energies(void) {
    static float p[2][RAYS];
    DrrScene scene = water_scene();
    for (int few = 0; few < 2; few++) {
        DrrProjector *projector = NULL;
        scene.few_energies_hu = few ? 0.5 : 0.0;
        OK(drr_projector_create(volume, &scene, &projector));
        CHECK((strstr(drr_projector_describe(projector), "\"quadrature\"") != NULL) == few);
        DrrOutputs outputs;
        drr_outputs_init(&outputs);
        outputs.line_integral = p[few];
        OK(drr_projector_project_poses(projector, poses, VIEWS, &outputs));
        OK(drr_projector_destroy(projector));
    }
    float largest = 0.0f;
    for (int i = 0; i < RAYS; i++) largest = fmaxf(largest, p[0][i]);
    for (int i = 0; i < RAYS; i++) {
        /* The floor is that of the rays the planner has seen, which are not these. */
        CHECK(fabs(p[1][i] - p[0][i]) <= 1e-3 * 0.5 * fmax(p[0][i], 0.1 * largest) + 1e-6);
    }
    CHECK(memcmp(p[0], p[1], sizeof p[0]) != 0);
    return 0;
}

int main(void) {
    const DrrVolumeDescriptor descriptor = water_descriptor();
    OK(create_cpu_context(&context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    for (int v = 0; v < VIEWS; v++) poses[v] = water_pose(v ? 6.0 : -6.0);
    DrrScene scene = water_scene();
    scene.expected_poses = poses;
    scene.expected_pose_count = VIEWS;
    double strict, lax;
    scene.tolerance_hu = 1.0;
    if (keeps(&scene, &strict)) return 1;
    scene.tolerance_hu = 100.0;
    if (keeps(&scene, &lax)) return 1;
    CHECK(strict < lax);
    if (presets() || few_energies()) return 1;
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS %.3f HU of 1, %.3f HU of 100\n", strict, lax);
    return 0;
}
