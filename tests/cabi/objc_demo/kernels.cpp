// The demo's kernels as host code, one call per thread of the grid.
#include "../../../objc-demo/Metal/Display.metal"

#include "../../../objc-demo/Metal/Denoise.metal"

// A grid is larger than the picture where threadgroups do not divide it.
extern "C" void show(const float *intensity, float window, float level, uint views, uint size, float *greys) {
    const DRRDisplayUniforms uniforms = {window, level, views, size};
    for (uint y = 0; y < size + 3; y++)
        for (uint x = 0; x < views * size + 3; x++) drr_display(intensity, uniforms, {greys, views * size}, {x, y});
}

extern "C" void denoise(const float *from, float *to, uint views, uint size) {
    for (uint z = 0; z < views; z++)
        for (uint y = 0; y < size + 3; y++)
            for (uint x = 0; x < size + 3; x++) drr_denoise(from, to, size, {x, y, z});
}
