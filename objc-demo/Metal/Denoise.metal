// Medians of 3 x 3 pixels, of one view per grid slice: a stand-in for what a neural network would do to images. Pixels of the
// edge stay.
#include <metal_stdlib>
using namespace metal;

static void sort(thread float &a, thread float &b) {
    const float low = min(a, b);
    b = max(a, b);
    a = low;
}

kernel void drr_denoise(const device float *from [[buffer(0)]], device float *to [[buffer(1)]],
                        constant uint &size [[buffer(2)]], uint3 at [[thread_position_in_grid]]) {
    if (at.x >= size || at.y >= size) return;
    const uint pixel = (at.z * size + at.y) * size + at.x;
    float v[9];
    if (at.x == 0 || at.y == 0 || at.x + 1 == size || at.y + 1 == size) {
        to[pixel] = from[pixel];
        return;
    }
    for (uint n = 0; n < 9; n++) v[n] = from[pixel + (n / 3) * size + n % 3 - size - 1];
    // The lower half in order is enough.
    for (uint n = 0; n < 5; n++)
        for (uint m = n + 1; m < 9; m++) sort(v[n], v[m]);
    to[pixel] = v[4];
}
