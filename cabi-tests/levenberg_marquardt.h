/* Levenberg and Marquardt's method for a few parameters, in plain C: steps of Gauss and Newton on J^T J and J^T r, damped
 * as long as they do not lower the loss (Marquardt 1963). */
#ifndef LEVENBERG_MARQUARDT_H
#define LEVENBERG_MARQUARDT_H

#include <math.h>
#include <string.h>

#include "DRR_Shared.h"

enum { MOST_PARAMETERS = 6, MOST_STEPS = 100 };

/* Loss, gradient and J^T J of whatever `problem` is. */
typedef DrrStatus (*Loss)(const void *problem, const double *parameters, double *loss, double *gradient, double *hessian);

/* Solves the symmetric, positive system of n equations by Cholesky's decomposition; false when it is not positive. */
static inline int solve(int n, double *matrix, double *vector) {
    for (int i = 0; i < n; i++) {
        for (int j = 0; j <= i; j++) {
            double sum = matrix[n * i + j];
            for (int k = 0; k < j; k++) sum -= matrix[n * i + k] * matrix[n * j + k];
            if (i == j && !(sum > 0.0)) return 0;
            matrix[n * i + j] = i == j ? sqrt(sum) : sum / matrix[n * j + j];
        }
        for (int k = 0; k < i; k++) vector[i] -= matrix[n * i + k] * vector[k];
        vector[i] /= matrix[n * i + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++) vector[i] -= matrix[n * k + i] * vector[k];
        vector[i] /= matrix[n * i + i];
    }
    return 1;
}

/* Changes `parameters` until no step lowers the loss any more. Counts the steps that did. */
static inline DrrStatus minimise(Loss loss_of, const void *problem, int n, double *parameters, int *steps) {
    double loss, gradient[MOST_PARAMETERS], hessian[MOST_PARAMETERS * MOST_PARAMETERS], damping = 1e-3;
    DrrStatus status = loss_of(problem, parameters, &loss, gradient, hessian);
    *steps = 0;
    while (status == DRR_STATUS_OK && *steps < MOST_STEPS && damping < 1e9) {
        double matrix[MOST_PARAMETERS * MOST_PARAMETERS], step[MOST_PARAMETERS], next[MOST_PARAMETERS], next_loss;
        memcpy(matrix, hessian, sizeof matrix);
        for (int k = 0; k < n; k++) {
            matrix[(n + 1) * k] *= 1.0 + damping;
            step[k] = -gradient[k];
        }
        if (!solve(n, matrix, step)) {
            damping *= 10.0;
            continue;
        }
        for (int k = 0; k < n; k++) next[k] = parameters[k] + step[k];
        double next_gradient[MOST_PARAMETERS], next_hessian[MOST_PARAMETERS * MOST_PARAMETERS];
        status = loss_of(problem, next, &next_loss, next_gradient, next_hessian);
        if (status != DRR_STATUS_OK || !(next_loss < loss)) {
            damping *= 10.0;
            continue;
        }
        memcpy(parameters, next, (size_t)n * sizeof *parameters);
        memcpy(gradient, next_gradient, sizeof gradient);
        memcpy(hessian, next_hessian, sizeof hessian);
        loss = next_loss;
        damping *= 0.1;
        ++*steps;
    }
    return status;
}

#endif
