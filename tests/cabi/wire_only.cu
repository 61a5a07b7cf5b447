#include "DRR_Shared.h"

// On a GPU the header is the wire structs and nothing else: these names are free.
struct DrrScene {};
typedef unsigned char uint64_t;

extern "C" __global__ void first_component(ProjectionUniforms view, float *out) {
    *out = view.sourcePosition.x + view.modelViewProjectionMatrix.columns[3][0] + (view.enableEarlyExit ? 1.0f : 0.0f);
}
