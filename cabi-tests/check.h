/* What the programs share: stop at the first thing that is not so, and say what the library says about it. */
#ifndef CHECK_H
#define CHECK_H

#include <stdio.h>

#include "DRR_Shared.h"

#define CHECK(condition)                                                                          \
    do {                                                                                          \
        if (!(condition)) {                                                                       \
            printf("FAIL %s:%d: %s (%s)\n", __FILE__, __LINE__, #condition, drr_last_error_message()); \
            return 1;                                                                             \
        }                                                                                         \
    } while (0)

/* An engine that is always there, whose LUT addresses are pointers. */
static inline DrrStatus create_cpu_context(DrrContext **context) {
    DrrContextOptions options;
    drr_context_options_init(&options);
    options.backend = DRR_BACKEND_CPU;
    return drr_context_create(&options, context);
}

#define OK(call) CHECK((call) == DRR_STATUS_OK)

#endif
