/* What looks wrong and is valid: it is accepted, and the images say what physics says. */
#include <math.h>
#include <string.h>

#include "check.h"

enum { WIDTH = 3, HEIGHT = 3, PIXELS = WIDTH * HEIGHT, MIDDLE = 4, MOST_VOXELS = 512 };

static DrrContext *context;

/* One view, all of it. */
typedef struct Images {
    float intensity[PIXELS], line_integral[PIXELS], areal_density[8][PIXELS], bone_path[PIXELS];
} Images;

/* What is projected: a cube of n voxels of the same CT number, seen along +y through its centre. */
typedef struct Setting {
    DrrVolumeDescriptor volume;
    int16_t hu[MOST_VOXELS];
    uint8_t labels[MOST_VOXELS];
    int labelled;
    DrrScene scene;
    DrrDetectorPose pose;
} Setting;

static Setting setting(size_t n, int16_t hu, double voxel_mm) {
    Setting s;
    memset(&s, 0, sizeof s);
    drr_volume_descriptor_init(&s.volume);
    drr_scene_init(&s.scene);
    const double middle = 0.5 * (double)(n - 1) * voxel_mm, centre[3] = {middle, middle, middle};
    for (int axis = 0; axis < 3; axis++) {
        s.volume.dimensions[axis] = n;
        s.volume.index_to_world[5 * axis] = voxel_mm;
    }
    for (size_t i = 0; i < n * n * n; i++) s.hu[i] = hu;
    s.scene.detector_width = WIDTH;
    s.scene.detector_height = HEIGHT;
    s.scene.effects |= DRR_EFFECT_BONE_PATH;
    /* Neighbouring pixels see the cube too. */
    drr_pose_c_arm(centre, 0.0, 1000.0 * voxel_mm, 1500.0 * voxel_mm, 0.3 * voxel_mm, WIDTH, HEIGHT, &s.pose);
    return s;
}

static DrrOutputs places(Images *images) {
    DrrOutputs outputs;
    drr_outputs_init(&outputs);
    memset(images, 0xff, sizeof *images); /* NaN */
    outputs.intensity = images->intensity;
    outputs.line_integral = images->line_integral;
    outputs.areal_density = images->areal_density[0];
    outputs.bone_path_mm = images->bone_path;
    return outputs;
}

static int projector_of(const Setting *s, DrrProjector **projector) {
    DrrVolume *volume = NULL;
    OK(drr_volume_create(context, &s->volume, s->hu, s->labelled ? s->labels : NULL, &volume));
    OK(drr_projector_create(volume, &s->scene, projector));
    OK(drr_volume_destroy(volume));
    return 0;
}

static int project(const Setting *s, Images *images) {
    DrrProjector *projector = NULL;
    if (projector_of(s, &projector)) return 1;
    const DrrOutputs outputs = places(images);
    OK(drr_projector_project_poses(projector, &s->pose, 1, &outputs));
    OK(drr_projector_destroy(projector));
    return 0;
}

static int is_close(double value, double expected) { return fabs(value - expected) <= 1e-5 * fabs(expected); }

/* Water of n voxels of any size, from 1e-6 to 1e6 mm: 0.1 g/cm^2 per mm, label 2. */
static int sizes_of_voxels_and_volumes(void) {
    static const double sizes[] = {1e-6, 0.01, 1.0, 1e6};
    static Images images;
    for (size_t n = 1; n <= 8; n += 7) {
        for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++) {
            Setting s = setting(n, 0, sizes[k]);
            for (s.scene.algorithm = 0; s.scene.algorithm < 3; s.scene.algorithm++) {
                if (project(&s, &images)) return 1;
                CHECK(is_close(images.areal_density[2][MIDDLE], 0.1 * (double)n * sizes[k]));
                CHECK(images.areal_density[3][MIDDLE] == 0.0f && images.bone_path[MIDDLE] == 0.0f);
                CHECK(images.line_integral[MIDDLE] > 0.0f && images.intensity[MIDDLE] >= 0.0f);
            }
        }
    }
    return 0;
}

/* Mirrored in the world, and the voxels stored the other way round: the same object. */
static int a_negative_determinant(void) {
    static Images plain, mirrored;
    Setting s = setting(4, 0, 1.0);
    for (int i = 0; i < 64; i++) s.hu[i] = (int16_t)(100 * (i % 4));
    if (project(&s, &plain)) return 1;
    s.volume.index_to_world[0] = -1.0;
    s.volume.index_to_world[12] = 3.0;
    for (int i = 0; i < 64; i++) s.hu[i] = (int16_t)(100 * (3 - i % 4));
    if (project(&s, &mirrored)) return 1;
    for (int i = 0; i < PIXELS; i++) CHECK(is_close(mirrored.line_integral[i], plain.line_integral[i]));
    CHECK(plain.line_integral[MIDDLE] > 0.01f);
    return 0;
}

/* Every CT number below the scanner's range is vacuum, with the bits of a ray that meets nothing. */
static int padding_is_vacuum(void) {
    static const int16_t paddings[] = {-32768, -3024, -2048, -1025};
    static Images beside, images;
    Setting s = setting(4, 0, 1.0);
    s.pose.source[0] = s.pose.first_pixel[0] = 1e4;
    if (project(&s, &beside)) return 1;
    for (int i = 0; i < PIXELS; i++) CHECK(beside.line_integral[i] == 0.0f && beside.intensity[i] > 0.99f);
    for (size_t k = 0; k < sizeof paddings / sizeof *paddings; k++) {
        s = setting(4, paddings[k], 1.0);
        memset(s.labels, 3, sizeof s.labels);
        for (s.labelled = 0; s.labelled < 2; s.labelled++) {
            for (s.scene.algorithm = 0; s.scene.algorithm < 3; s.scene.algorithm++) {
                if (project(&s, &images)) return 1;
                CHECK(memcmp(images.intensity, beside.intensity, sizeof images.intensity) == 0);
                CHECK(memcmp(images.line_integral, beside.line_integral, sizeof images.line_integral) == 0);
                CHECK(memcmp(images.areal_density, beside.areal_density, 4 * sizeof *images.areal_density) == 0);
            }
        }
    }
    /* Behind water, and called water by its label, it takes nothing away. */
    for (size_t k = 0; k < sizeof paddings / sizeof *paddings; k++) {
        s = setting(4, 0, 1.0);
        for (int i = 0; i < 64; i++) s.hu[i] = i / 4 % 4 < 2 ? paddings[k] : 0;
        memset(s.labels, 2, sizeof s.labels);
        s.scene.algorithm = DRR_ALGORITHM_SIDDON;
        for (s.labelled = 0; s.labelled < 2; s.labelled++) {
            if (project(&s, &images)) return 1;
            CHECK(is_close(images.areal_density[2][MIDDLE], 0.2));
        }
    }
    return 0;
}

static int steps_at_both_ends(void) {
    static const double steps[] = {1.0 / 64.0, 8.0};
    static Images images;
    for (int k = 0; k < 2; k++) {
        Setting s = setting(8, 0, 1.0);
        s.scene.algorithm = DRR_ALGORITHM_MARCH;
        s.scene.step_voxels = steps[k];
        if (project(&s, &images)) return 1;
        CHECK(is_close(images.areal_density[2][MIDDLE], 0.8));
    }
    return 0;
}

/* Eight materials at one energy, one slab of each; label 7 is bone. Zeros of either sign are no attenuation. */
static int eight_materials_at_one_energy(void) {
    static const float spectrum[1] = {3.0f}, attenuation[8] = {0.0f, -0.0f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
    static Images images;
    Setting s = setting(8, 0, 1.0);
    for (int i = 0; i < 512; i++) s.labels[i] = (uint8_t)(i / 8 % 8);
    s.labelled = 1;
    s.scene.spectrum = spectrum;
    s.scene.mass_attenuation = attenuation;
    s.scene.material_count = 8;
    s.scene.energy_count = 1;
    s.scene.bone_material = 7;
    s.scene.algorithm = DRR_ALGORITHM_SIDDON;
    if (project(&s, &images)) return 1;
    for (int m = 0; m < 8; m++) CHECK(is_close(images.areal_density[m][MIDDLE], 0.1));
    CHECK(is_close(images.line_integral[MIDDLE], 0.21));
    CHECK(is_close(images.intensity[MIDDLE], 3.0 * exp(-0.21)));
    CHECK(is_close(images.bone_path[MIDDLE], 1.0));
    return 0;
}

/* What a scene says is not read may hold anything. */
static int unread_fields(void) {
    static Images images, plain;
    Setting s = setting(4, 0, 1.0);
    if (project(&s, &plain)) return 1;
    s.scene.mono_energy_kev = s.scene.step_voxels = NAN;
    if (project(&s, &images)) return 1;
    CHECK(memcmp(images.intensity, plain.intensity, sizeof plain.intensity) == 0);
    s.scene.effects = 0;
    s.scene.mono_energy_kev = 70.0;
    s.scene.bone_material = UINT32_MAX;
    DrrProjector *projector = NULL;
    if (projector_of(&s, &projector)) return 1;
    OK(drr_projector_destroy(projector));
    return 0;
}

/* Any byte is a bool, which one only early_exit.c can see; the padding is not read; tables of zeros are transparent. */
static int bytes_of_uniforms(void) {
    static Images images, transparent;
    static float no_attenuation[4 * 136], spectrum[136];
    const Setting s = setting(4, 0, 1.0);
    DrrProjector *projector = NULL;
    if (projector_of(&s, &projector)) return 1;
    ProjectionUniforms view;
    OK(drr_uniforms_cone(&s.pose, WIDTH, HEIGHT, &view));
    memset((char *)&view + offsetof(ProjectionUniforms, enableEarlyExit), 2, 1);
    view._padding = NAN;
    spectrum[0] = 5.0f;
    view.spectrumLutAddress = (DrrAddress)(uintptr_t)spectrum;
    view.muLutAddress = (DrrAddress)(uintptr_t)no_attenuation;
    DrrOutputs outputs = places(&transparent);
    OK(drr_projector_project(projector, &view, 1, &outputs));
    for (int i = 0; i < PIXELS; i++) CHECK(transparent.intensity[i] == 5.0f && transparent.line_integral[i] == 0.0f);
    CHECK(transparent.areal_density[2][MIDDLE] > 0.3f);
    /* Parallel along +y: the source is not read. */
    static const float parallel[4][4] = {{1, 0, 0, 0}, {0, 0, 0.01f, 0}, {0, -1, 0, 0}, {-1.5f, 1.5f, 0, 1}};
    memcpy(&view.modelViewProjectionMatrix, parallel, sizeof parallel);
    view.sourcePosition.x = view.sourcePosition.y = view.sourcePosition.z = NAN;
    outputs = places(&images);
    OK(drr_projector_project(projector, &view, 1, &outputs));
    CHECK(is_close(images.areal_density[2][MIDDLE], 0.4));
    OK(drr_projector_destroy(projector));
    return 0;
}

static int source_in_the_middle(void) {
    static Images images;
    Setting s = setting(8, 0, 1.0);
    for (int axis = 0; axis < 3; axis++) s.pose.source[axis] = 3.5;
    if (project(&s, &images)) return 1;
    CHECK(is_close(images.areal_density[2][MIDDLE], 0.4));
    return 0;
}

int main(void) {
    OK(create_cpu_context(&context));
    if (sizes_of_voxels_and_volumes() || a_negative_determinant() || padding_is_vacuum()) return 1;
    if (steps_at_both_ends() || eight_materials_at_one_energy() || unread_fields()) return 1;
    if (bytes_of_uniforms() || source_in_the_middle()) return 1;
    OK(drr_context_destroy(context));
    printf("PASS\n");
    return 0;
}
