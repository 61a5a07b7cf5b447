/* What the functions are given: good arguments, and all that they point to, in one block of memory. That the block is
 * the same after a call as before says that nothing was written. */
#ifndef GIVEN_H
#define GIVEN_H

#include <string.h>

#include "check.h"

enum { NX = 4, NY = 3, NZ = 2, VOXELS = NX * NY * NZ };
enum { WIDTH = 3, HEIGHT = 2, PIXELS = WIDTH * HEIGHT, VIEWS = 2, IMAGES = VIEWS * PIXELS };
enum { MATERIALS = 4, ENERGIES = 136, RAYS = 2 };

/* What the arguments point to. Rows that are not about a table leave its pointer NULL. */
typedef struct Pointees {
    DrrContextOptions options;
    DrrVolumeDescriptor descriptor;
    int16_t hu[VOXELS];
    float hu_float32[VOXELS];
    uint8_t labels[VOXELS];
    DrrScene scene;
    float spectrum[ENERGIES], response[ENERGIES], attenuation[8 * ENERGIES];
    float efficiency[ENERGIES], second_response[ENERGIES], second_efficiency[ENERGIES], filter_attenuation[ENERGIES];
    DrrFilter filters[2];
    double angles[3], thicknesses[3];
    DrrImplant implants[4];
    DrrScrewSection sections[2];
    DrrBlurComponent blur[2];
    double frequencies[3], mtf[3];
    double centre[3];
    DrrDetectorPose poses[VIEWS];
    ProjectionUniforms views[VIEWS];
    DrrOutputs outputs;
    DrrReferenceOutputs reference_outputs;
    DrrDeviceOutputs device_outputs;
    float images[3][IMAGES], areal_density[MATERIALS * IMAGES], values[ENERGIES];
    double reference_images[3][IMAGES], reference_areal_density[MATERIALS * IMAGES];
    void *handle;
    DrrBackend backend;
    DrrCertificate certificate;
    DrrParallelGeometry geometry;
    float field[VOXELS], measured[IMAGES], jacobian[6 * PIXELS];
    double field_f64[VOXELS], measured_f64[IMAGES], jacobian_f64[6 * PIXELS];
    double parameters[6 * VIEWS], lengths[2 * PIXELS], loss, gradient[6], hessian[36];
    uint8_t mask[PIXELS];
    DrrCamera camera;
    DrrWorldRay rays[RAYS];
    DrrRaySample samples[DRR_CAMERA_RAYS];
    DrrMatter matter;
    DrrRaySpan spans[PIXELS];
    DrrRaycastStatistics statistics;
} Pointees;

/* One member per parameter name of the header; functions read those that they have. */
typedef struct Given {
    void *options, *context, *descriptor, *hu, *labels, *texture, *volume, *scene, *projector, *centre, *pose, *uniforms,
        *views, *poses, *outputs, *weights, *coefficients, *factors, *queue, *backend,
        *certificate, *exposure, *geometry, *parallel, *transform, *pose_gradient, *pivot, *parameters, *measured,
        *mask, *lengths, *loss, *gradient, *hessian, *image, *jacobian, *images, *raycast, *camera, *rays, *samples,
        *matter, *spans, *statistics;
    const char *name, *path;
    double angle_degrees, source_axis_mm, source_detector_mm, pixel_mm, first_energy_kev, energy_step_kev, step_voxels;
    size_t width, height, energy_count, view_count, ray_count;
    DrrAlgorithm algorithm;
    DrrPoseSignal signal;
    Pointees to;
} Given;

static Given given;

/* Live handles. */
static struct Handles {
    DrrContext *context;
    DrrVolume *volume, *adipose;
    DrrProjector *projector, *boneless, *monoenergetic, *unstepped, *vast, *focused;
    DrrExposure *exposure, *boneless_exposure;
    DrrRaycast *raycast;
    DrrParallel *parallel;
    DrrParallelF64 *parallel_f64;
    DrrRayTransform *transform;
    DrrRayTransformF64 *transform_f64;
    DrrPoseGradient *pose_gradient;
    DrrPoseGradientF64 *pose_gradient_f64;
} live;

/* Every voxel size and distance is a power of two: what is made from them is exact. */
static inline void good_volume(Given *g) {
    drr_volume_descriptor_init(&g->to.descriptor);
    const size_t dimensions[3] = {NX, NY, NZ};
    memcpy(g->to.descriptor.dimensions, dimensions, sizeof dimensions);
    for (int i = 0; i < VOXELS; i++) {
        g->to.hu[i] = (int16_t)(i % 3 == 0 ? 900 : i % 5 == 0 ? -1000 : 40 - i);
        g->to.hu_float32[i] = g->to.hu[i];
        g->to.labels[i] = (uint8_t)(i % MATERIALS);
    }
    g->descriptor = &g->to.descriptor;
    g->hu = g->to.hu;
    g->labels = g->to.labels;
}

static inline void good_scene(Given *g) {
    drr_scene_init(&g->to.scene);
    g->to.scene.detector_width = WIDTH;
    g->to.scene.detector_height = HEIGHT;
    g->to.scene.effects |= DRR_EFFECT_BONE_PATH;
    for (int k = 0; k < ENERGIES; k++) {
        g->to.spectrum[k] = g->to.response[k] = g->to.second_response[k] = 1.0f;
        g->to.efficiency[k] = g->to.second_efficiency[k] = 0.5f;
        g->to.filter_attenuation[k] = 0.2f;
    }
    for (int k = 0; k < 8 * ENERGIES; k++) g->to.attenuation[k] = 0.2f;
    g->scene = &g->to.scene;
}

/* What a scene can point to beside tables of energies: a slab and a bow-tie, one implant of each shape, a blur. */
static inline void good_parts(Given *g) {
    memset(g->to.filters, 0, sizeof g->to.filters);
    g->to.filters[0].material = "aluminium";
    g->to.filters[0].thickness_mm = 2.0;
    g->to.filters[1].mass_attenuation = g->to.filter_attenuation;
    g->to.filters[1].density = 1.0;
    g->to.filters[1].angles_degrees = g->to.angles;
    g->to.filters[1].thicknesses_mm = g->to.thicknesses;
    g->to.filters[1].point_count = 3;
    memset(g->to.implants, 0, sizeof g->to.implants);
    for (int n = 0; n < 4; n++) {
        g->to.implants[n].shape = (DrrImplantShape)n;
        g->to.implants[n].material = 3;
        g->to.implants[n].density = 4.5;
        g->to.implants[n].position[0] = n;
        g->to.implants[n].radius_mm = 0.25;
        for (int axis = 0; axis < 3; axis++) g->to.implants[n].axes[4 * axis] = 1.0;
    }
    g->to.implants[1].sections = g->to.sections;
    g->to.implants[1].section_count = 2;
    for (int n = 0; n < 3; n++) {
        g->to.angles[n] = n - 1.0;
        g->to.thicknesses[n] = 1.0 + n;
        g->to.frequencies[n] = n;
        g->to.mtf[n] = 1.0 / (1.0 + n);
    }
    for (int n = 0; n < 2; n++) {
        g->to.sections[n].length_mm = g->to.sections[n].radius_mm = 0.5;
        g->to.blur[n].weight = g->to.blur[n].sigma_mm = 0.5;
    }
}

static inline void good_views(Given *g) {
    const double centre[3] = {1.5, 1.0, 0.5};
    memcpy(g->to.centre, centre, sizeof centre);
    g->angle_degrees = 0.0;
    g->source_axis_mm = 64.0;
    g->source_detector_mm = 128.0;
    g->pixel_mm = 1.0;
    g->width = WIDTH;
    g->height = HEIGHT;
    for (int v = 0; v < VIEWS; v++) {
        drr_pose_c_arm(centre, 30.0 * v, 64.0, 128.0, 1.0, WIDTH, HEIGHT, &g->to.poses[v]);
        drr_uniforms_cone(&g->to.poses[v], WIDTH, HEIGHT, &g->to.views[v]);
    }
    g->centre = g->to.centre;
    g->poses = g->to.poses;
    g->views = g->to.views;
    g->view_count = VIEWS;
}

/* Good arguments for every function; what a function names as its place to write is set by its own `good`. */
static inline void good(Given *g) {
    memset(g, 0xa5, sizeof *g);
    drr_context_options_init(&g->to.options);
    g->to.options.backend = DRR_BACKEND_CPU;
    g->to.options.thread_count = 1;
    g->options = &g->to.options;
    good_volume(g);
    good_scene(g);
    good_parts(g);
    good_views(g);
    g->context = live.context;
    g->volume = live.volume;
    g->projector = live.projector;
    g->exposure = live.exposure;
    g->algorithm = DRR_ALGORITHM_EXACT;
    drr_outputs_init(&g->to.outputs);
    g->to.outputs.intensity = g->to.images[0];
    g->to.outputs.line_integral = g->to.images[1];
    g->to.outputs.bone_path_mm = g->to.images[2];
    g->to.outputs.areal_density = g->to.areal_density;
    drr_reference_outputs_init(&g->to.reference_outputs);
    g->to.reference_outputs.intensity = g->to.reference_images[0];
    g->to.reference_outputs.line_integral = g->to.reference_images[1];
    g->to.reference_outputs.bone_path_mm = g->to.reference_images[2];
    g->to.reference_outputs.areal_density = g->to.reference_areal_density;
    drr_device_outputs_init(&g->to.device_outputs);
    g->to.device_outputs.intensity = g->to.images[0];
    g->to.device_outputs.line_integral = g->to.images[1];
    g->to.device_outputs.bone_path_mm = g->to.images[2];
    g->to.device_outputs.areal_density = g->to.areal_density;
    g->outputs = &g->to.outputs;
    g->queue = NULL;
    g->backend = &g->to.backend;
    drr_certificate_init(&g->to.certificate);
    g->certificate = &g->to.certificate;
    g->first_energy_kev = 15.0;
    g->energy_step_kev = 1.0;
    g->energy_count = ENERGIES;
    g->weights = g->coefficients = g->factors = g->to.values;
    g->pose = &g->to.poses[0];
    g->uniforms = &g->to.views[0];
}

/* On the CPU, whose LUT addresses are pointers that C programs have. */
static inline int create_live_handles(void) {
    good(&given);
    OK(drr_context_create(&given.to.options, &live.context));
    DrrVolumeDescriptor *descriptor = &given.to.descriptor;
    DrrScene *scene = &given.to.scene;
    OK(drr_volume_create(live.context, descriptor, given.to.hu, NULL, &live.volume));
    OK(drr_projector_create(live.volume, scene, &live.projector));
    OK(drr_exposure_create_poses(live.projector, given.to.poses, VIEWS, NULL, NULL, &live.exposure));
    scene->step_voxels = 0.0;
    OK(drr_projector_create(live.volume, scene, &live.unstepped));
    scene->effects = DRR_EFFECT_POLYENERGETIC | DRR_EFFECT_BONE_PATH | DRR_EFFECT_FOCAL_SPOT;
    scene->focal_spot_width_mm = 0.5;
    OK(drr_projector_create(live.volume, scene, &live.focused));
    scene->effects = 0;
    OK(drr_projector_create(live.volume, scene, &live.monoenergetic));
    scene->effects = DRR_EFFECT_POLYENERGETIC;
    OK(drr_projector_create(live.volume, scene, &live.boneless));
    OK(drr_exposure_create_poses(live.boneless, given.to.poses, VIEWS, NULL, NULL, &live.boneless_exposure));
    scene->detector_width = scene->detector_height = 32768;
    OK(drr_projector_create(live.volume, scene, &live.vast));
    for (int i = 0; i < VOXELS; i++) given.to.hu[i] = -80;
    descriptor->thresholds = DRR_THRESHOLDS_FIVE_CLASS;
    OK(drr_volume_create(live.context, descriptor, given.to.hu, NULL, &live.adipose));
    return 0;
}

static inline int destroy_live_handles(void) {
    OK(drr_exposure_destroy(live.boneless_exposure));
    OK(drr_exposure_destroy(live.exposure));
    OK(drr_projector_destroy(live.focused));
    OK(drr_projector_destroy(live.vast));
    OK(drr_projector_destroy(live.boneless));
    OK(drr_projector_destroy(live.monoenergetic));
    OK(drr_projector_destroy(live.unstepped));
    OK(drr_projector_destroy(live.projector));
    OK(drr_volume_destroy(live.adipose));
    OK(drr_volume_destroy(live.volume));
    OK(drr_context_destroy(live.context));
    return 0;
}

#endif
