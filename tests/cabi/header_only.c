#include "DRR_Shared.h"

int main(void) { return sizeof(ProjectionUniforms) == 112 ? 0 : 1; }
