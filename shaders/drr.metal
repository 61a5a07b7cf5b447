// The entry point for Metal.
#include "DRR_Shared.h"
#include "pixel.h"
