/* Finds how a measured view of a parallel beam is misaligned: the object's three angles and two translations, by
 * Levenberg and Marquardt's method on what drr_parallel_view_loss_value_and_grad returns.
 *
 *   cc -std=c11 -Iinclude -Icabi-tests cabi-tests/align.c -ldrr -lm
 */
#include "check.h"
#include "levenberg_marquardt.h"

enum { N = 32, PIXELS = 48 };

typedef struct View {
    const DrrParallel *parallel;
    const float *measured;
} View;

static DrrStatus loss_of(const void *problem, const double *parameters, double *loss, double *gradient,
                         double *hessian) {
    const View *view = (const View *)problem;
    return drr_parallel_view_loss_value_and_grad(view->parallel, parameters, view->measured, NULL, NULL, loss, gradient,
                                                 hessian);
}

/* Attenuation per mm: two smooth blobs in a third, none of them round, so that every motion shows. */
static const float *phantom(void) {
    static float volume[N * N * N];
    static const double blobs[3][7] = {{0, 0, 0, 10, 8, 9, 0.02}, {4, -3, 2, 3, 5, 2, 0.03}, {-4, 2, -5, 2, 3, 4, 0.04}};
    for (int i = 0; i < N * N * N; i++) {
        const double x[3] = {i % N - 15.5, i / N % N - 15.5, (double)(i / (N * N)) - 15.5};
        double sum = 0.0;
        for (int b = 0; b < 3; b++) {
            double square = 0.0;
            for (int axis = 0; axis < 3; axis++) square += pow((x[axis] - blobs[b][axis]) / blobs[b][3 + axis], 2.0);
            sum += blobs[b][6] * exp(-square);
        }
        volume[i] = (float)sum;
    }
    return volume;
}

int main(void) {
    static float measured[PIXELS * PIXELS];
    const double degree = acos(-1.0) / 180.0;
    /* alpha, beta, phi, dx, dz: where the object is, and where it is thought to be, at a view of 40 degrees. */
    const double truth[5] = {1.5 * degree, -2.0 * degree, 41.0 * degree, 2.0, -1.5};
    double found[5] = {0.0, 0.0, 40.0 * degree, 0.0, 0.0};
    DrrContext *context = NULL;
    DrrParallel *parallel = NULL;
    DrrParallelGeometry geometry;
    OK(create_cpu_context(&context));
    OK(drr_parallel_geometry_init(&geometry));
    for (int axis = 0; axis < 3; axis++) geometry.dimensions[axis] = N;
    geometry.detector_columns = geometry.detector_rows = PIXELS;
    OK(drr_parallel_create(context, &geometry, phantom(), &parallel));
    OK(drr_parallel_forward_project_view(parallel, truth, NULL, NULL, measured));

    const View view = {parallel, measured};
    int steps;
    OK(minimise(loss_of, &view, 5, found, &steps));
    double degrees = 0.0, mm = 0.0;
    for (int k = 0; k < 3; k++) degrees = fmax(degrees, fabs(found[k] - truth[k]) / degree);
    for (int k = 3; k < 5; k++) mm = fmax(mm, fabs(found[k] - truth[k]));
    CHECK(degrees < 5e-6 && mm < 1e-7);
    OK(drr_parallel_destroy(parallel));
    OK(drr_context_destroy(context));
    printf("PASS in %d steps: angles to %.1e degrees, translations to %.1e mm\n", steps, degrees, mm);
    return 0;
}
