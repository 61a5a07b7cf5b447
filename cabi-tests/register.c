/* Finds where an object is from a stereo pair, seen from -6 and +6 degrees: three angles and three translations, by
 * Levenberg and Marquardt's method on what drr_pose_gradient_loss_value_and_grad returns, summed over both views.
 *
 *   cc -std=c11 -Iinclude -Icabi-tests cabi-tests/register.c -ldrr -lm
 */
#include "check.h"
#include "levenberg_marquardt.h"

enum { N = 32, PIXELS = 40, VIEWS = 2 };

typedef struct Pair {
    const DrrPoseGradient *pose_gradient;
    DrrDetectorPose poses[VIEWS];
    float measured[VIEWS][PIXELS * PIXELS];
} Pair;

static DrrStatus loss_of(const void *problem, const double *parameters, double *loss, double *gradient,
                         double *hessian) {
    const Pair *pair = (const Pair *)problem;
    *loss = 0.0;
    memset(gradient, 0, 6 * sizeof *gradient);
    memset(hessian, 0, 36 * sizeof *hessian);
    for (int v = 0; v < VIEWS; v++) {
        double one, its_gradient[6], its_hessian[36];
        const DrrStatus status =
            drr_pose_gradient_loss_value_and_grad(pair->pose_gradient, &pair->poses[v], parameters,
                                                  DRR_SIGNAL_LINE_INTEGRAL, pair->measured[v], NULL, &one,
                                                  its_gradient, its_hessian);
        if (status != DRR_STATUS_OK) return status;
        *loss += one;
        for (int k = 0; k < 6; k++) gradient[k] += its_gradient[k];
        for (int k = 0; k < 36; k++) hessian[k] += its_hessian[k];
    }
    return DRR_STATUS_OK;
}

/* Soft tissue with two lumps of bone, none of them round, so that every motion shows. HU. */
static const float *phantom(void) {
    static float hu[N * N * N];
    for (int i = 0; i < N * N * N; i++) {
        const double x = 2.0 * (i % N) - 31.0, y = 2.0 * (i / N % N) - 31.0, z = 2.0 * (double)(i / (N * N)) - 31.0;
        const double body = x * x / 500.0 + y * y / 350.0 + z * z / 600.0;
        const double first = pow((x - 8.0) / 6.0, 2.0) + pow((y + 5.0) / 9.0, 2.0) + pow((z - 6.0) / 5.0, 2.0);
        const double second = pow((x + 9.0) / 4.0, 2.0) + pow((y - 4.0) / 5.0, 2.0) + pow((z + 9.0) / 8.0, 2.0);
        hu[i] = (float)(1030.0 / (1.0 + exp(12.0 * (body - 1.0))) + 700.0 * (exp(-first) + exp(-second)) - 1000.0);
    }
    return hu;
}

static int make(DrrContext **context, DrrVolume **volume, DrrPoseGradient **pose_gradient, Pair *pair) {
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrVolumeDescriptor descriptor;
    DrrScene scene;
    OK(create_cpu_context(context));
    OK(drr_volume_descriptor_init(&descriptor));
    for (int axis = 0; axis < 3; axis++) {
        descriptor.dimensions[axis] = N;
        descriptor.index_to_world[5 * axis] = 2.0;
        descriptor.index_to_world[12 + axis] = -31.0;
    }
    OK(drr_volume_create_float32(*context, &descriptor, phantom(), NULL, volume));
    OK(drr_scene_init(&scene));
    scene.detector_width = scene.detector_height = PIXELS;
    OK(drr_pose_gradient_create(*volume, &scene, NULL, pose_gradient));
    for (int v = 0; v < VIEWS; v++) {
        OK(drr_pose_c_arm(centre, v == 0 ? -6.0 : 6.0, 700.0, 1000.0, 3.0, PIXELS, PIXELS, &pair->poses[v]));
    }
    pair->pose_gradient = *pose_gradient;
    return 0;
}

int main(void) {
    static Pair pair;
    const double degree = acos(-1.0) / 180.0;
    /* alpha, beta, phi, then the translation along x, y (the depth) and z. */
    const double truth[6] = {1.5 * degree, -1.0 * degree, 2.0 * degree, 1.5, -3.0, 1.0};
    double found[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
    DrrContext *context = NULL;
    DrrVolume *volume = NULL;
    DrrPoseGradient *pose_gradient = NULL;
    if (make(&context, &volume, &pose_gradient, &pair)) return 1;
    for (int v = 0; v < VIEWS; v++) {
        OK(drr_pose_gradient_project(pose_gradient, &pair.poses[v], truth, DRR_SIGNAL_LINE_INTEGRAL, pair.measured[v]));
    }
    int steps;
    OK(minimise(loss_of, &pair, 6, found, &steps));
    double degrees = 0.0, mm = 0.0;
    for (int k = 0; k < 3; k++) degrees = fmax(degrees, fabs(found[k] - truth[k]) / degree);
    for (int k = 3; k < 6; k++) mm = fmax(mm, fabs(found[k] - truth[k]));
    CHECK(degrees < 3e-6 && mm < 1.4e-6);
    OK(drr_pose_gradient_destroy(pose_gradient));
    OK(drr_volume_destroy(volume));
    OK(drr_context_destroy(context));
    printf("PASS in %d steps: angles to %.1e degrees, translations to %.1e mm\n", steps, degrees, mm);
    return 0;
}
