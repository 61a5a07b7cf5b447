#include "DRR_Shared.h"

// On a GPU the header is the wire structs and nothing else: these names are free.
struct DrrScene {};
int drr_version;
#ifdef DRR_STATUS_OK
#error "constants of the host"
#endif

float first_component(const ProjectionUniforms &view) {
    return view.sourcePosition.x + view.modelViewProjectionMatrix.columns[3][0];
}
