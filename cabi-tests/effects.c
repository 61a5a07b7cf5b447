/* A water cube before a detector of two layers, with scatter, blur and noise: the images are what physics says, and one
 * exposure makes the images of every spectrum. */
#include <math.h>
#include <string.h>

#include "check.h"

enum { N = 16, WIDTH = 24, HEIGHT = 20, PIXELS = WIDTH * HEIGHT, LAYERS = 2, ENERGIES = 136 };
enum { MIDDLE = HEIGHT / 2 * WIDTH + WIDTH / 2, NOISE = DRR_EFFECT_QUANTUM_NOISE | DRR_EFFECT_ELECTRONIC_NOISE };

static const double PHOTONS = 2000.0, ELECTRONIC = 2.0;

static DrrContext *context;
static DrrVolume *volume;
static DrrDetectorPose pose;
static float top[ENERGIES], bottom[ENERGIES], soft[ENERGIES];

typedef struct Images {
    float intensity[LAYERS][PIXELS], line_integral[LAYERS][PIXELS];
} Images;

/* 64 mm of water. */
static int make_water(void) {
    static int16_t hu[N * N * N];
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrVolumeDescriptor descriptor;
    drr_volume_descriptor_init(&descriptor);
    for (int axis = 0; axis < 3; axis++) {
        descriptor.dimensions[axis] = N;
        descriptor.index_to_world[5 * axis] = 4.0;
        descriptor.index_to_world[12 + axis] = -30.0;
    }
    OK(drr_volume_create(context, &descriptor, hu, NULL, &volume));
    OK(drr_pose_c_arm(centre, 0.0, 500.0, 800.0, 2.0, WIDTH, HEIGHT, &pose));
    OK(drr_physics_detector("top_counting", 15.0, 1.0, ENERGIES, top));
    OK(drr_physics_detector("bottom_counting", 15.0, 1.0, ENERGIES, bottom));
    OK(drr_physics_spectrum("W80_2p5Al", 15.0, 1.0, ENERGIES, soft));
    return 0;
}

static DrrScene dual_layers(DrrEffects effects) {
    DrrScene scene;
    drr_scene_init(&scene);
    scene.detector_width = WIDTH;
    scene.detector_height = HEIGHT;
    scene.detector_response = scene.detector_efficiency = top;
    scene.second_detector_response = scene.second_detector_efficiency = bottom;
    scene.effects |= effects;
    scene.scatter_photons = 2000;
    scene.photons_per_pixel = PHOTONS;
    scene.electronic_noise_photons = ELECTRONIC;
    return scene;
}

static DrrOutputs places(Images *images) {
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    memset(images, 0xff, sizeof *images); /* NaN */
    outputs.intensity = images->intensity[0];
    outputs.line_integral = images->line_integral[0];
    return outputs;
}

static int project(const DrrScene *scene, Images *images) {
    DrrProjector *projector = NULL;
    const DrrOutputs outputs = places(images);
    OK(drr_projector_create(volume, scene, &projector));
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    OK(drr_projector_destroy(projector));
    return 0;
}

static int is_close(double value, double expected, double tolerance) {
    return fabs(value - expected) <= tolerance * fabs(expected);
}

/* The second layer sees what the first one has let pass: harder radiation, which water attenuates less. Each layer is, bit
 * for bit, what it is alone but for how float32 sums. */
static int layers(void) {
    static Images both, alone;
    DrrScene scene = dual_layers(0);
    if (project(&scene, &both)) return 1;
    CHECK(both.line_integral[0][MIDDLE] > 1.0f);
    CHECK(both.line_integral[1][MIDDLE] < 0.97f * both.line_integral[0][MIDDLE]);
    CHECK(both.intensity[1][MIDDLE] < 0.5f * both.intensity[0][MIDDLE] && both.intensity[1][MIDDLE] > 0.0f);
    scene.detector_response = bottom;
    scene.second_detector_response = NULL;
    scene.detector_efficiency = scene.second_detector_efficiency = NULL;
    if (project(&scene, &alone)) return 1;
    for (int i = 0; i < PIXELS; i++) CHECK(is_close(both.line_integral[1][i], alone.line_integral[0][i], 1e-5));
    CHECK(isnan(alone.intensity[1][0])); /* one layer writes one image */
    return 0;
}

/* Scatter adds to the signal, most where little is left of the primary; blur and fill factor leave an even field. */
static int scatter_and_blur(void) {
    static const DrrBlurComponent blur[] = {{0.8, 1.0}, {0.2, 4.0}};
    static Images plain, scattered, blurred;
    DrrScene scene = dual_layers(DRR_EFFECT_SCATTER);
    if (project(&scene, &scattered)) return 1;
    scene.effects &= ~(DrrEffects)DRR_EFFECT_SCATTER;
    if (project(&scene, &plain)) return 1;
    for (int l = 0; l < LAYERS; l++) {
        for (int i = 0; i < PIXELS; i++) CHECK(scattered.intensity[l][i] > plain.intensity[l][i]);
        CHECK(scattered.intensity[l][MIDDLE] < 3.0f * plain.intensity[l][MIDDLE]);
        CHECK(scattered.line_integral[l][MIDDLE] < plain.line_integral[l][MIDDLE]);
    }
    scene.blur = blur;
    scene.blur_count = 2;
    scene.effects |= DRR_EFFECT_FILL_FACTOR;
    scene.fill_factor = 0.64;
    if (project(&scene, &blurred)) return 1;
    double sums[2] = {0.0, 0.0};
    for (int i = 0; i < PIXELS; i++) {
        sums[0] += plain.intensity[0][i];
        sums[1] += blurred.intensity[0][i];
    }
    CHECK(is_close(sums[1], 0.64 * sums[0], 0.02) && memcmp(&plain, &blurred, sizeof plain) != 0);
    return 0;
}

/* The same seed gives the same noise, another one another; means and variances are Poisson's and the electronics'. */
static int noise(void) {
    static Images mean, first, again, other;
    DrrScene scene = dual_layers(0);
    if (project(&scene, &mean)) return 1;
    scene = dual_layers(NOISE);
    if (project(&scene, &first) || project(&scene, &again)) return 1;
    CHECK(memcmp(&first, &again, sizeof first) == 0);
    scene.noise_seed = 1;
    if (project(&scene, &other)) return 1;
    for (int l = 0; l < LAYERS; l++) {
        CHECK(memcmp(first.intensity[l], other.intensity[l], sizeof first.intensity[l]) != 0);
        double sum = 0.0, squares = 0.0, variance = 0.0;
        for (int i = 0; i < PIXELS; i++) {
            /* In photons: the default spectrum's sum is 1, and a photon that is detected counts as one. */
            const double photons = PHOTONS * mean.intensity[l][i], noisy = PHOTONS * first.intensity[l][i];
            sum += noisy - photons;
            squares += (noisy - photons) * (noisy - photons);
            variance += photons + ELECTRONIC * ELECTRONIC;
        }
        CHECK(fabs(sum) < 5.0 * sqrt(variance));
        /* Of PIXELS squares of about normal numbers: a relative deviation of sqrt(2 / PIXELS), 0.065. */
        CHECK(is_close(squares, variance, 5.0 * sqrt(2.0 / PIXELS)));
    }
    return 0;
}

/* Everything at once; what is before the volume changes intensities as it should. */
static int source_and_implants(void) {
    static Images plain, filtered, implanted;
    static const double angles[2] = {-3.0, 3.0}, thicknesses[2] = {1.0, 5.0};
    const DrrFilter filters[2] = {{"aluminium", NULL, 0.0, 1.0, NULL, NULL, 0},
                                  {"water", NULL, 0.0, 0.0, angles, thicknesses, 2}};
    DrrImplant sphere;
    memset(&sphere, 0, sizeof sphere);
    sphere.shape = DRR_IMPLANT_SPHERE;
    sphere.material = 3;
    sphere.density = 4.0;
    sphere.radius_mm = 5.0;
    DrrScene scene = dual_layers(0);
    if (project(&scene, &plain)) return 1;
    scene.filters = filters;
    scene.filter_count = 2;
    if (project(&scene, &filtered)) return 1;
    for (int i = 0; i < PIXELS; i++) CHECK(filtered.intensity[0][i] < plain.intensity[0][i]);
    /* The wedge is thicker where i grows; the open field has it too. */
    CHECK(filtered.intensity[0][MIDDLE + 8] < filtered.intensity[0][MIDDLE - 9]);
    CHECK(is_close(filtered.line_integral[0][MIDDLE], plain.line_integral[0][MIDDLE], 0.1));
    scene.effects |= DRR_EFFECT_HEEL | DRR_EFFECT_FALL_OFF | DRR_EFFECT_FOCAL_SPOT | DRR_EFFECT_FILL_FACTOR;
    scene.focal_spot_width_mm = 0.6;
    scene.focal_spot_height_mm = 1.2;
    scene.fill_factor = 0.8;
    scene.supersampling = 2;
    scene.implants = &sphere;
    scene.implant_count = 1;
    if (project(&scene, &implanted)) return 1;
    CHECK(implanted.line_integral[0][MIDDLE] > plain.line_integral[0][MIDDLE] + 0.3f);
    return 0;
}

static bool count(void *calls, double fraction) {
    ++*(int *)calls;
    return fraction < 2.0;
}
static bool refuse(void *calls, double fraction) {
    ++*(int *)calls;
    return fraction > 2.0;
}

/* What the exposure's own scene gives is what the projector gives; another spectrum's image is that of a new march. */
static int one_march_for_all(void) {
    static Images projected, developed;
    DrrProjector *projector = NULL;
    DrrExposure *exposure = NULL;
    DrrScene scene = dual_layers(NOISE | DRR_EFFECT_SCATTER);
    if (project(&scene, &projected)) return 1;
    OK(drr_projector_create(volume, &scene, &projector));
    int calls = 0;
    CHECK(drr_exposure_create_poses(projector, &pose, 1, refuse, &calls, &exposure) == DRR_STATUS_CANCELLED);
    CHECK(calls == 1 && exposure == NULL);
    OK(drr_exposure_create_poses(projector, &pose, 1, count, &calls, &exposure));
    CHECK(calls > 1);
    OK(drr_projector_destroy(projector));
    DrrOutputs outputs = places(&developed);
    OK(drr_exposure_develop(exposure, NULL, &outputs));
    CHECK(memcmp(&projected, &developed, sizeof projected) == 0);

    scene.effects = DRR_EFFECT_POLYENERGETIC;
    scene.spectrum = soft;
    if (project(&scene, &projected)) return 1;
    outputs = places(&developed);
    OK(drr_exposure_develop(exposure, &scene, &outputs));
    for (int l = 0; l < LAYERS; l++) {
        for (int i = 0; i < PIXELS; i++) {
            CHECK(is_close(developed.line_integral[l][i], projected.line_integral[l][i], 1e-6));
            CHECK(is_close(developed.intensity[l][i], projected.intensity[l][i], 1e-6));
        }
    }
    scene.second_detector_response = scene.second_detector_efficiency = NULL;
    outputs = places(&developed);
    OK(drr_exposure_develop(exposure, &scene, &outputs));
    CHECK(memcmp(developed.intensity[0], projected.intensity[0], sizeof developed.intensity[0]) == 0);
    CHECK(isnan(developed.intensity[1][0]));
    OK(drr_exposure_destroy(exposure));
    return 0;
}

/* Each ray is cast from every point of the focal spot: progress ends at 1, in float64 as well. */
static bool last_fraction(void *last, double fraction) {
    const bool grows = fraction >= *(double *)last && fraction <= 1.0;
    *(double *)last = grows ? fraction : 2.0;
    return true;
}
static int progress_over_the_focal_spot(void) {
    static Images images;
    static double reference[LAYERS][PIXELS];
    DrrProjector *projector = NULL;
    DrrScene scene = dual_layers(DRR_EFFECT_FOCAL_SPOT);
    scene.focal_spot_width_mm = scene.focal_spot_height_mm = 5.0;
    OK(drr_projector_create(volume, &scene, &projector));
    DrrOutputs outputs = places(&images);
    double last = 0.0;
    outputs.progress = last_fraction;
    outputs.progress_data = &last;
    OK(drr_projector_project_poses(projector, &pose, 1, &outputs));
    CHECK(last == 1.0);
    DrrReferenceOutputs twin;
    drr_reference_outputs_init(&twin);
    twin.line_integral = reference[0];
    twin.progress = last_fraction;
    twin.progress_data = &last;
    last = 0.0;
    OK(drr_reference_project(projector, DRR_ALGORITHM_JOSEPH, &pose, 1, &twin));
    CHECK(last == 1.0);
    for (int l = 0; l < LAYERS; l++) {
        for (int i = 0; i < PIXELS; i++) CHECK(is_close(images.line_integral[l][i], reference[l][i], 1e-4));
    }
    OK(drr_projector_destroy(projector));
    return 0;
}

int main(void) {
    OK(create_cpu_context(&context));
    if (make_water() || layers() || scatter_and_blur() || noise()) return 1;
    if (source_and_implants() || one_march_for_all() || progress_over_the_focal_spot()) return 1;
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
