/* What the differentiable projectors return agrees: J^T r and J^T J are those of the Jacobian, images those of each other,
 * rays that do not count are left out, and what is optional may be NULL. Handles outlive what they were made from. */
#include <math.h>
#include <string.h>

#include "water.h"

enum { SIZE = 12, ALL = SIZE * SIZE };

static const double parameters[12] = {0.02, -0.03, 0.4, 1.5, -0.5, 0.75, -0.1, 0.05, 0.2, -1.0, 0.5, 0.0};

static int is_close(double value, double expected, double scale) { return fabs(value - expected) <= 1e-5 * scale; }

/* Whether loss, gradient and J^T J are the sums of `count` parameters' planes over the pixels that count. */
static int sums_agree(int count, const float *image, const float *jacobian, const float *measured, const uint8_t *mask,
                      double loss, const double *gradient, const double *hessian) {
    double half = 0.0, first[6] = {0.0}, second[36] = {0.0}, scale[6] = {0.0};
    for (int i = 0; i < ALL; i++) {
        if (mask != NULL && mask[i] == 0) continue;
        const double residual = image[i] - measured[i];
        half += 0.5 * residual * residual;
        for (int m = 0; m < count; m++) {
            first[m] += jacobian[m * ALL + i] * residual;
            scale[m] += jacobian[m * ALL + i] * jacobian[m * ALL + i];
            for (int n = 0; n < count; n++) second[count * m + n] += jacobian[m * ALL + i] * jacobian[n * ALL + i];
        }
    }
    if (!is_close(loss, half, half)) return 0;
    for (int m = 0; m < count; m++) {
        if (!(scale[m] > 0.0) || !is_close(gradient[m], first[m], sqrt(scale[m] * 2.0 * half))) return 0;
        for (int n = 0; n < count; n++) {
            if (!is_close(hessian[count * m + n], second[count * m + n], sqrt(scale[m] * scale[n]))) return 0;
        }
    }
    return 1;
}

static const float *attenuation(void) {
    static float volume[N * N * N];
    const int16_t *hu = water_ball();
    for (int i = 0; i < N * N * N; i++) volume[i] = 0.02f * (1.0f + hu[i] / 1000.0f);
    return volume;
}

static int parallel_beam(void) {
    static float image[ALL], images[2 * ALL], again[ALL], measured[ALL], jacobian[5 * ALL];
    static double volume[N * N * N], exact[ALL];
    static uint8_t mask[ALL];
    static double lengths[2 * ALL];
    double loss, gradient[5], hessian[25], lone, alone[5];
    DrrContext *context = NULL;
    DrrParallel *parallel = NULL;
    DrrParallelF64 *twin = NULL;
    DrrParallelGeometry geometry;
    OK(create_cpu_context(&context));
    OK(drr_parallel_geometry_init(&geometry));
    for (int axis = 0; axis < 3; axis++) geometry.dimensions[axis] = N;
    geometry.detector_columns = geometry.detector_rows = SIZE;
    geometry.pixel[0] = geometry.pixel[1] = 2.0;
    const float *single = attenuation();
    for (int i = 0; i < N * N * N; i++) volume[i] = single[i];
    OK(drr_parallel_create(context, &geometry, single, &parallel));
    OK(drr_parallel_create_f64(context, &geometry, volume, &twin));
    OK(drr_context_destroy(context));

    OK(drr_parallel_batch_forward_project(parallel, parameters, 2, images));
    OK(drr_parallel_forward_project_view(parallel, parameters + 5, NULL, NULL, measured));
    CHECK(memcmp(images + ALL, measured, sizeof measured) == 0);
    OK(drr_parallel_view_jacobian(parallel, parameters, NULL, NULL, image, jacobian));
    for (int i = 0; i < ALL; i++) CHECK(is_close(image[i], images[i], 0.6));
    OK(drr_parallel_view_loss_value_and_grad(parallel, parameters, measured, NULL, NULL, &loss, gradient, hessian));
    CHECK(sums_agree(5, image, jacobian, measured, NULL, loss, gradient, hessian));
    OK(drr_parallel_view_loss_value_and_grad(parallel, parameters, measured, NULL, NULL, &lone, alone, NULL));
    CHECK(lone == loss && memcmp(alone, gradient, sizeof alone) == 0);
    OK(drr_parallel_view_jacobian(parallel, parameters, NULL, NULL, NULL, jacobian));

    /* <A x, b> = <x, A^T b>. */
    static float back[N * N * N];
    OK(drr_parallel_adjoint(parallel, parameters, 2, images, back));
    double one = 0.0, other = 0.0;
    for (int i = 0; i < 2 * ALL; i++) one += (double)images[i] * images[i];
    for (int i = 0; i < N * N * N; i++) other += volume[i] * back[i];
    CHECK(one > 0.0 && is_close(other, one, one));

    /* Any byte but 0 counts; where none does, measured values are not read. */
    for (int i = 0; i < ALL; i++) {
        mask[i] = (uint8_t)(i % 3 == 0 ? 0 : 1 + i);
        if (mask[i] == 0) measured[i] = NAN;
        lengths[2 * i] = -100.0;
        lengths[2 * i + 1] = 0.0;
    }
    OK(drr_parallel_view_loss_value_and_grad(parallel, parameters, measured, mask, NULL, &loss, gradient, hessian));
    CHECK(sums_agree(5, image, jacobian, measured, mask, loss, gradient, hessian));
    OK(drr_parallel_forward_project_view(parallel, parameters, mask, NULL, again));
    for (int i = 0; i < ALL; i++) CHECK(again[i] == (mask[i] == 0 ? 0.0f : images[i]));
    /* Both halves of each ray. */
    OK(drr_parallel_forward_project_view(parallel, parameters, NULL, lengths, again));
    for (int i = 0; i < ALL; i++) lengths[2 * i] = 0.0, lengths[2 * i + 1] = 100.0;
    OK(drr_parallel_forward_project_view(parallel, parameters, NULL, lengths, image));
    for (int i = 0; i < ALL; i++) CHECK(is_close(again[i] + image[i], images[i], 0.6) && again[i] < 0.5f);

    OK(drr_parallel_forward_project_view_f64(twin, parameters, NULL, NULL, exact));
    for (int i = 0; i < ALL; i++) CHECK(is_close(exact[i], images[i], 0.6));
    OK(drr_parallel_destroy_f64(twin));
    OK(drr_parallel_destroy(parallel));
    return 0;
}

static int cone_beam(void) {
    static float image[ALL], again[ALL], measured[ALL], jacobian[6 * ALL];
    static uint8_t mask[ALL];
    double loss, gradient[6], hessian[36];
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrPoseGradient *pose_gradient = NULL;
    const DrrVolumeDescriptor descriptor = water_descriptor();
    DrrScene scene = water_scene();
    scene.detector_width = scene.detector_height = SIZE;
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrDetectorPose pose;
    OK(drr_pose_c_arm(centre, 20.0, 500.0, 800.0, 3.0, SIZE, SIZE, &pose));
    OK(create_cpu_context(&context));
    OK(drr_volume_create(context, &descriptor, water_ball(), NULL, &volume));
    OK(drr_pose_gradient_create(volume, &scene, NULL, &pose_gradient));
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    for (DrrPoseSignal signal = 0; signal < 2; signal++) {
        for (int i = 0; i < ALL; i++) mask[i] = (uint8_t)(i % 2);
        OK(drr_pose_gradient_project(pose_gradient, &pose, parameters + 6, signal, measured));
        OK(drr_pose_gradient_project(pose_gradient, &pose, parameters, signal, again));
        OK(drr_pose_gradient_jacobian(pose_gradient, &pose, parameters, signal, image, jacobian));
        CHECK(memcmp(image, again, sizeof image) == 0);
        OK(drr_pose_gradient_loss_value_and_grad(pose_gradient, &pose, parameters, signal, measured, NULL, &loss,
                                                 gradient, hessian));
        CHECK(sums_agree(6, image, jacobian, measured, NULL, loss, gradient, hessian));
        OK(drr_pose_gradient_loss_value_and_grad(pose_gradient, &pose, parameters, signal, measured, mask, &loss,
                                                 gradient, hessian));
        CHECK(sums_agree(6, image, jacobian, measured, mask, loss, gradient, hessian));
        OK(drr_pose_gradient_loss_value_and_grad(pose_gradient, &pose, parameters, signal, measured, mask, &loss,
                                                 gradient, NULL));
        OK(drr_pose_gradient_jacobian(pose_gradient, &pose, parameters, signal, NULL, jacobian));
    }
    OK(drr_pose_gradient_destroy(pose_gradient));
    return 0;
}

int main(void) {
    if (parallel_beam() || cone_beam()) return 1;
    printf("PASS\n");
    return 0;
}
