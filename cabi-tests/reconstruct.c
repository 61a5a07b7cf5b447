/* Reconstructs a volume from its line integrals: conjugate gradients on the least-squares problem (CGLS, Hestenes and
 * Stiefel 1952), which needs nothing but A x and A^T b, and needs that the one is the transpose of the other.
 *
 *   cc -std=c11 -Iinclude -Icabi-tests cabi-tests/reconstruct.c -ldrr -lm
 */
#include <math.h>
#include <string.h>

#include "check.h"

enum { N = 20, VOXELS = N * N * N, PIXELS = 32, VIEWS = 24, RAYS = VIEWS * PIXELS * PIXELS, ITERATIONS = 60 };

static double dot(const double *a, const double *b, int count) {
    double sum = 0.0;
    for (int i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

/* a + factor b, into a. */
static void add(double *a, double factor, const double *b, int count) {
    for (int i = 0; i < count; i++) a[i] += factor * b[i];
}

/* Attenuation per mm: a cube in a ball. */
static void phantom(double *volume) {
    for (int i = 0; i < VOXELS; i++) {
        const double x = i % N - 9.5, y = i / N % N - 9.5, z = (double)(i / (N * N)) - 9.5;
        const int in_cube = fabs(x - 2.0) < 3.0 && fabs(y + 1.0) < 3.0 && fabs(z) < 3.0;
        volume[i] = x * x + y * y + z * z > 72.0 ? 0.0 : in_cube ? 0.05 : 0.02;
    }
}

static int make(DrrContext **context, DrrRayTransformF64 **transform) {
    const double centre[3] = {0.0, 0.0, 0.0};
    DrrVolumeDescriptor descriptor;
    DrrDetectorPose poses[VIEWS];
    OK(create_cpu_context(context));
    OK(drr_volume_descriptor_init(&descriptor));
    for (int axis = 0; axis < 3; axis++) {
        descriptor.dimensions[axis] = N;
        descriptor.index_to_world[12 + axis] = -9.5;
    }
    for (int v = 0; v < VIEWS; v++) {
        OK(drr_pose_c_arm(centre, 360.0 * v / VIEWS, 200.0, 300.0, 1.2, PIXELS, PIXELS, &poses[v]));
    }
    OK(drr_ray_transform_create_f64(*context, &descriptor, poses, VIEWS, PIXELS, PIXELS, DRR_ALGORITHM_JOSEPH, 0.0,
                                    transform));
    return 0;
}

/* <A x, b> and <x, A^T b> are one number. */
static int adjoint_is_the_transpose(const DrrRayTransformF64 *transform) {
    static double x[VOXELS], b[RAYS], projected[RAYS], back[VOXELS];
    uint32_t state = 1;
    for (int i = 0; i < VOXELS; i++) x[i] = (state = 1664525u * state + 1013904223u) / 4294967296.0 - 0.5;
    for (int i = 0; i < RAYS; i++) b[i] = (state = 1664525u * state + 1013904223u) / 4294967296.0 - 0.5;
    OK(drr_ray_transform_forward_f64(transform, x, projected));
    OK(drr_ray_transform_adjoint_f64(transform, b, back));
    const double scale = sqrt(dot(projected, projected, RAYS) * dot(b, b, RAYS));
    CHECK(fabs(dot(projected, b, RAYS) - dot(x, back, VOXELS)) < 1e-12 * scale);
    return 0;
}

/* x, from 0, to minimise |A x - measured|. Every residual is smaller than the one before. */
static int cgls(const DrrRayTransformF64 *transform, const double *measured, double *x) {
    static double residual[RAYS], image[RAYS], slope[VOXELS], direction[VOXELS];
    memcpy(residual, measured, sizeof residual);
    OK(drr_ray_transform_adjoint_f64(transform, residual, slope));
    memcpy(direction, slope, sizeof direction);
    double square = dot(slope, slope, VOXELS), before = dot(residual, residual, RAYS);
    for (int k = 0; k < ITERATIONS; k++) {
        OK(drr_ray_transform_forward_f64(transform, direction, image));
        const double length = square / dot(image, image, RAYS);
        add(x, length, direction, VOXELS);
        add(residual, -length, image, RAYS);
        const double now = dot(residual, residual, RAYS);
        CHECK(now < before);
        before = now;
        OK(drr_ray_transform_adjoint_f64(transform, residual, slope));
        const double next = dot(slope, slope, VOXELS);
        for (int i = 0; i < VOXELS; i++) direction[i] = slope[i] + next / square * direction[i];
        square = next;
    }
    return 0;
}

int main(void) {
    static double truth[VOXELS], found[VOXELS], measured[RAYS];
    DrrContext *context = NULL;
    DrrRayTransformF64 *transform = NULL;
    if (make(&context, &transform) || adjoint_is_the_transpose(transform)) return 1;
    phantom(truth);
    OK(drr_ray_transform_forward_f64(transform, truth, measured));
    if (cgls(transform, measured, found)) return 1;
    add(found, -1.0, truth, VOXELS);
    const double error = sqrt(dot(found, found, VOXELS) / dot(truth, truth, VOXELS));
    CHECK(error < 0.05);
    OK(drr_ray_transform_destroy_f64(transform));
    OK(drr_context_destroy(context));
    printf("PASS after %d iterations: the volume to %.1e of its norm\n", ITERATIONS, error);
    return 0;
}
