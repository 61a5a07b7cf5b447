// Intensities on the screen: grey by window and level of -ln(intensity), the views side by side, heads up. DRRPicture's rule.
#include <metal_stdlib>
using namespace metal;

struct DRRDisplayUniforms {
    float window, level;
    uint views, size;
};

kernel void drr_display(const device float *intensity [[buffer(0)]], constant DRRDisplayUniforms &uniforms [[buffer(1)]],
                        texture2d<float, access::write> picture [[texture(0)]], uint2 at [[thread_position_in_grid]]) {
    const uint size = uniforms.size;
    if (at.x >= uniforms.views * size || at.y >= size) return;
    const uint view = at.x / size, pixel = (view * size + size - 1 - at.y) * size + at.x % size;
    // Noise may leave nothing, or less: as dark as can be.
    const float value = -log(max(intensity[pixel], 1.17549435e-38f));
    const float grey = clamp((value - uniforms.level) / uniforms.window + 0.5f, 0.0f, 1.0f);
    picture.write(float4(grey, grey, grey, 1.0f), at);
}
